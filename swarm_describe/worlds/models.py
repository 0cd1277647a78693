"""The tree of models in an SDF world, and the poses of its `<state>`, in which it was saved."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from dataclasses import dataclass, field
from pathlib import Path

from swarm_common.model.errors import DescriptionError, WorldError
from swarm_common.model.shapes import Transform, inverse_of
from swarm_describe.files.values import flag_of, floats_of, pose_of, text_of, transform_of
from swarm_describe.worlds.frames import SEPARATOR, Scope, base_of
from swarm_describe.worlds.grammar import account_for
from swarm_describe.worlds.source import NEWEST, Source, parse_sdf, parse_xml, version_of

MAX_DEPTH = 24  # of models in models
SUN, GROUND = ("sun",), ("ground_plane", "ground plane")
GROUND_MODEL = """<model name="ground_plane"><static>true</static><link name="link">
<collision name="collision"><geometry><plane><normal>0 0 1</normal></plane></geometry></collision>
</link></model>"""


@dataclass(slots=True)
class Model:
    """A model with all that it includes."""

    name: str  # in its parent
    element: ET.Element  # `<model>`
    here: Path  # folder of the file that the element is in
    is_static: bool  # whether it says so itself
    scope: Scope  # its frames
    is_merged: bool = False  # whether its names count as its parent's
    children: list[Model] = field(default_factory=list)  # models inside
    # pose and its reference frame, if the including element gives one
    outer_pose: tuple[Transform, str] | None = None
    placement: str = ""  # frame of it that stands at its pose


def models_in(
    parent: ET.Element, here: Path, source: Source, scope: Scope, trail: tuple[Path, ...] = ()
) -> list[Model]:
    """Return the models in an element, in file order, and enter them into its scope."""
    if len(trail) > MAX_DEPTH:
        raise WorldError(f"models are nested more than {MAX_DEPTH} deep at {scope.where}")
    models = []
    for child in parent:
        try:
            model = _child(child, here, source, scope, trail)
        except DescriptionError as cause:
            if trail:  # the model around it is unusable
                raise
            names = (text_of(child, "name"), child.get("name"), text_of(child, "uri"), "model")
            source.break_off(next(filter(None, names)), cause)
            continue
        if model is not None:
            models.append(model)
    return models


def _child(
    child: ET.Element, here: Path, source: Source, scope: Scope, trail: tuple[Path, ...]
) -> Model | None:
    """Return the model that an element is, entered into the scope; None for other elements."""
    if child.tag == "model":
        model = _model(child, child.get("name") or "model", here, source, scope, trail)
    elif child.tag == "include":
        included = _included(child, here, source, scope, trail)
        if included is None:
            return None
        model = included
    else:
        return None
    if model.name in scope.inner:
        twin, model.name = model.name, _free_name(model.name, scope)
        source.remark(f"a second model '{twin}' is called '{model.name}' here")
    _enter(model, scope)
    return model


def _model(
    element: ET.Element,
    name: str,
    here: Path,
    source: Source,
    parent: Scope,
    trail: tuple[Path, ...],
) -> Model:
    where = f"{parent.where}{SEPARATOR}{name}" if parent.where else name
    scope = Scope(where)
    account_for(element, "model", f"model '{where}'", source)
    scope.add_all(element)
    model = Model(name, element, here, flag_of(element, "static"), scope)
    model.placement = element.get("placement_frame", "")
    model.children = models_in(element, here, source, scope, (*trail, here / name))
    return model


def _included(
    include: ET.Element, here: Path, source: Source, parent: Scope, trail: tuple[Path, ...]
) -> Model | None:
    account_for(include, "include", f"an <include> of {parent.where or 'the world'}", source)
    uri = text_of(include, "uri")
    name = text_of(include, "name")
    where = f"included as '{name}'" if name else "included"
    if not uri:
        raise WorldError(f"an <include> of {parent.where or 'the world'} has no <uri>")
    found = _built_in(uri, here, source)
    if found is None:
        path = source.find(uri, here, where)
        if path is None:
            return None
        file = model_file(path, source)
        if file in trail:
            chain = " -> ".join(step.parent.name for step in (*trail, file) if step.suffix)
            raise WorldError(f"model {uri} includes itself: {chain}")
        root = parse_sdf(file, source)
        element = root.find("model")
        if element is None:
            _without_model(root, uri, file, source)
            return None
        account_for(root, "model file", file.name, source)
        found, here, trail = element, file.parent, (*trail, file)
    if found.tag != "model":
        return None
    model = _model(found, name or found.get("name") or "model", here, source, parent, trail)
    _override(model, include)
    return model


def _override(model: Model, include: ET.Element) -> None:
    """Let an `<include>` have its say about pose and the like."""
    if include.find("static") is not None:
        model.is_static = flag_of(include, "static")
    if (pose := include.find("pose")) is not None:
        where = f"the <include> of {model.name}"
        model.outer_pose = (pose_of(include, where), pose.get("relative_to", ""))
    model.placement = text_of(include, "placement_frame", model.placement)
    model.is_merged = include.get("merge", "false").lower() in ("true", "1")


def _enter(model: Model, scope: Scope) -> None:
    """Make a model known as a frame of its parent."""
    name = model.name
    if model.outer_pose is not None:
        pose, base = model.outer_pose
    else:
        pose = pose_of(model.element, model.scope.where)
        base = base_of(model.element, scope, "")
    if model.placement:
        pose = pose @ inverse_of(model.scope.frame(model.placement))
    scope.frames[name] = (pose, base)
    scope.inner[name] = model.scope
    if model.is_merged:
        scope.merged.append(name)


def _free_name(name: str, scope: Scope) -> str:
    number = 1
    while f"{name}_{number}" in scope.inner:
        number += 1
    return f"{name}_{number}"


def _built_in(uri: str, here: Path, source: Source) -> ET.Element | None:
    """Return a model that every Gazebo has, if there is no file of it: sun and ground."""
    name = uri.rstrip("/").rpartition("/")[2].lower().replace("%20", " ")
    if name not in SUN + GROUND or source.paths.find(uri, here) is not None:
        return None
    if name in GROUND:
        return ET.fromstring(GROUND_MODEL)
    source.ignored["light"] += 1
    return ET.Element("light")


def _without_model(root: ET.Element, uri: str, file: Path, source: Source) -> None:
    """Record an included light or actor, which is no obstacle."""
    for tag in ("light", "actor"):
        if root.find(tag) is not None:
            source.ignored[tag] += 1
            return
    raise WorldError(f"{file}, included as {uri}, has no <model>")


def model_file(path: Path, source: Source) -> Path:
    """Return the SDF file of a model's folder: the newest that we read."""
    if path.is_file():
        return path.resolve()
    config = path / "model.config"
    if not config.is_file():
        if (path / "model.sdf").is_file():
            return (path / "model.sdf").resolve()
        raise WorldError(f"{path} is a folder without model.config; expected a model of Gazebo's")
    root = parse_xml(config, source)
    choices = []
    for element in root.iter("sdf"):
        file = path / (element.text or "").strip()
        if file.is_file():
            choices.append((_version_or_zero(element, config), file))
    readable = [choice for choice in choices if choice[0] <= NEWEST] or choices
    if not readable:
        names = ", ".join((element.text or "").strip() for element in root.iter("sdf"))
        raise WorldError(f"{config} names no SDF file that is there; found: {names or 'none'}")
    return max(readable, key=lambda choice: choice[0])[1].resolve()


def _version_or_zero(element: ET.Element, config: Path) -> tuple[int, int]:
    try:
        return version_of(element, config)
    except WorldError:
        return (0, 0)


@dataclass(slots=True)
class WorldState:
    """Poses in the world, by full names."""

    models: dict[str, Transform] = field(default_factory=dict)  # `world_from_model`
    links: dict[str, Transform] = field(default_factory=dict)  # `world_from_link`
    deleted: set[str] = field(default_factory=set)  # models that were taken out
    # elements with models that were put in
    inserted: list[ET.Element] = field(default_factory=list)


def state_of(world: ET.Element, source: Source) -> WorldState:
    """Return the content of the `<state>` elements of a world; the last one counts."""
    state = WorldState()
    elements = world.findall("state")
    if len(elements) > 1:
        source.remark(f"of {len(elements)} <state>, the last one that names a model counts")
    for element in elements:
        for model in element.findall("model"):
            _read(model, "", state, source, 1)
        state.deleted |= {(name.text or "").strip() for name in element.findall("deletions/name")}
        state.inserted += element.findall("insertions")
    return state


def _read(model: ET.Element, prefix: str, state: WorldState, source: Source, depth: int) -> None:
    name = prefix + model.get("name", "")
    if depth > MAX_DEPTH:
        raise WorldError(f"<state>: models are nested more than {MAX_DEPTH} deep at {name}")
    pose = model.find("pose")
    if pose is not None:
        state.models[name] = transform_of(pose, f"<state> of {name}")
    if floats_of(model.find("scale"), 3, "1 1 1", f"<state> of {name}") != [1.0, 1.0, 1.0]:
        source.remark(f"the <scale> in the <state> of {name} is ignored")
    for link in model.findall("link"):
        pose = link.find("pose")
        if pose is not None:
            full = f"{name}{SEPARATOR}{link.get('name', 'link')}"
            state.links[full] = transform_of(pose, f"<state> of {full}")
    for child in model.findall("model"):
        _read(child, f"{name}{SEPARATOR}", state, source, depth + 1)
