"""Bodies from the models of an SDF world: links with their shapes, where `<state>` has them."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path

from swarm_common.model.errors import DescriptionError, WorldError
from swarm_common.model.shapes import Mesh, MeshFile, Part, Shape, Transform, Visual, inverse_of
from swarm_describe.files.meshes import hull_of, load_mesh
from swarm_describe.files.values import floats_of, text_of
from swarm_describe.worlds.frames import OWN_NAMES, SEPARATOR, Scope, base_of
from swarm_describe.worlds.models import Model, WorldState
from swarm_describe.worlds.scene import Body
from swarm_describe.worlds.shapes import EMPTY, is_known, material_color, shape_of
from swarm_describe.worlds.source import Source

MIN_MASS, MAX_MASS = 1e-6, 1e6  # [kg]
MAX_SCALE = 1e4  # of a mesh


@dataclass(frozen=True, slots=True)
class BodyPlace:
    """Place of a model while its bodies are made."""

    world_from_model: Transform  # its pose
    name: str  # full name, as Gazebo puts it
    is_static: bool  # whether it or one around it is static


def bodies_of(models: list[Model], scope: Scope, state: WorldState, source: Source) -> list[Body]:
    """Return the bodies of all models of a world, those without collision included.

    Models in which something is malformed are left out; the source takes note of them.

    Args:
        state: Poses that count in place of those of the models, and models that are gone.
    """
    bodies: list[Body] = []
    for model in models:
        if model.name in state.deleted:
            continue
        try:
            bodies += _whole(model, scope, state, source)
        except DescriptionError as cause:
            source.break_off(model.name, cause)
    return bodies


def _whole(model: Model, scope: Scope, state: WorldState, source: Source) -> list[Body]:
    own = list(_bodies(model, scope, None, state, source))
    if not model.is_static:
        own = _joined(own, _joints(model, model.name), source)
        own = [body if body.is_static else convex(body, source) for body in own]
    return own


def _bodies(
    model: Model, parent: Scope, outer: BodyPlace | None, state: WorldState, source: Source
) -> Iterator[Body]:
    name = model.name if outer is None else f"{outer.name}{SEPARATOR}{model.name}"
    world_from_model = parent.frame(model.name)
    if outer is not None:
        world_from_model = outer.world_from_model @ world_from_model
    world_from_model = state.models.get(name, world_from_model)
    is_static = model.is_static or (outer is not None and outer.is_static)
    place = BodyPlace(world_from_model, name, is_static)
    for link in model.element.findall("link"):
        body = _body(link, place, model, source)
        if body.name in state.links:
            body = replace(body, world_from_body=state.links[body.name])
        if body.parts or body.visuals:
            yield body
    for child in model.children:
        yield from _bodies(child, model.scope, place, state, source)


def _body(link: ET.Element, place: BodyPlace, model: Model, source: Source) -> Body:
    name = f"{place.name}{SEPARATOR}{link.get('name', 'link')}"
    model_from_link = model.scope.placed(link, name)
    parts = []
    for collision in link.findall("collision"):
        shape = _collision_shape(collision, name, model.here, source)
        if shape is not None:
            pose = _inside(collision, name, model.scope, model_from_link)
            parts.append(Part(shape, pose))
    return Body(
        name=name,
        world_from_body=place.world_from_model @ model_from_link,
        parts=tuple(parts),
        is_static=place.is_static,
        mass=_mass(link, name, place.is_static, source),
        friction=_friction(link, name),
        visuals=tuple(_visuals(link, name, model, model_from_link, source)),
    )


def _inside(element: ET.Element, name: str, scope: Scope, model_from_link: Transform) -> Transform:
    """Return the pose of a collision or visual in its link."""
    base = base_of(element, scope, "")
    own = scope.placed(element, name)
    if base in OWN_NAMES and base != "__model__":
        return own
    inside: Transform = inverse_of(model_from_link) @ own
    return inside


def _collision_shape(collision: ET.Element, name: str, here: Path, source: Source) -> Shape | None:
    geometry = collision.find("geometry")
    if geometry is None:
        raise WorldError(f"<collision> of {name} has no <geometry>")
    for element in geometry:
        if ":" in element.tag:  # of another program
            continue
        if element.tag == EMPTY:
            return None
        if element.tag != "mesh":
            return shape_of(element, name)
        path = _mesh_path(element, name, here, source)
        if path is None:
            return None
        mesh = load_mesh(path, _scale(element, name), text_of(element, "submesh/name"))
        if not len(mesh.faces):
            source.remark(f"{path.name} of {name} has no triangles; nothing is there")
            return None
        return mesh
    return None


def _visuals(
    link: ET.Element, name: str, model: Model, model_from_link: Transform, source: Source
) -> Iterator[Visual]:
    """Yield what a link looks like; what is wrong with a look is a note, as nobody touches it."""
    for visual in link.findall("visual"):
        for element in visual.findall("geometry/*"):
            try:
                shape = _look(element, name, model, source)
                if shape is not None:
                    pose = _inside(visual, name, model.scope, model_from_link)
                    yield Visual(shape, pose, material_color(visual, name))
            except DescriptionError as error:
                source.remark(f"a visual is left out: {error}")


def _look(element: ET.Element, name: str, model: Model, source: Source) -> Shape | MeshFile | None:
    """Return the shape of a visual; None where it has none that we draw."""
    if element.tag != "mesh" or element.find("uri") is None:
        return shape_of(element, name) if is_known(element.tag) else None
    path = _mesh_path(element, name, model.here, source)
    if path is None:
        return None
    return MeshFile(path, _scale(element, name), text_of(element, "submesh/name"))


def _mesh_path(mesh: ET.Element, name: str, here: Path, source: Source) -> Path | None:
    uri = text_of(mesh, "uri")
    if not uri:
        raise WorldError(f"<mesh> of {name} has no <uri>")
    path = source.find(uri, here, name)
    if path is not None and not path.is_file():
        raise WorldError(f"<uri> of {name} is '{uri}'; {path} is a folder, expected a mesh file")
    return path


def _scale(mesh: ET.Element, name: str) -> tuple[float, float, float]:
    x, y, z = floats_of(mesh.find("scale"), 3, "1 1 1", name)
    if max(abs(x), abs(y), abs(z)) > MAX_SCALE:
        raise WorldError(
            f"<scale> of {name} is '{x:g} {y:g} {z:g}'; expected factors of at most {MAX_SCALE:g}"
        )
    return x, y, z


def _mass(link: ET.Element, name: str, is_static: bool, source: Source) -> float:
    mass = floats_of(link.find("inertial/mass"), 1, "1", name)[0]
    if is_static:  # of no account
        return 1.0
    if mass == 0.0:
        source.remark(f"the <mass> of {name}, 0, is 1 kg here")
        return 1.0
    if not MIN_MASS <= mass <= MAX_MASS:
        raise WorldError(
            f"<mass> of {name} is {mass:g} kg; expected {MIN_MASS:g} to {MAX_MASS:g} kg"
        )
    return mass


def _friction(link: ET.Element, name: str) -> float:
    for tag in ("ode/mu", "bullet/friction"):
        element = link.find(f"collision/surface/friction/{tag}")
        if element is not None:
            friction = floats_of(element, 1, "", name)[0]
            if friction < 0.0:
                raise WorldError(f"<{element.tag}> of {name} is {friction:g}; must not be negative")
            return min(friction, 10.0)
    return 1.0


def _joints(model: Model, name: str) -> Iterator[tuple[str, str]]:
    """Return full names of the links that joints of a model connect; `world` is one, too."""
    for joint in model.element.findall("joint"):
        ends = [text_of(joint, tag) for tag in ("parent", "child")]
        first, second = (end if end == "world" else f"{name}{SEPARATOR}{end}" for end in ends)
        yield first, second
    for child in model.children:
        yield from _joints(child, f"{name}{SEPARATOR}{child.name}")


def _joined(bodies: list[Body], joints: Iterator[tuple[str, str]], source: Source) -> list[Body]:
    """Return the bodies of a model that can move, those joined together made one."""
    every = [[body] for body in bodies]
    groups = {group[0].name: group for group in every}
    fixed: set[int] = set()  # ids of groups that are joined to the world
    for first, second in joints:
        if "world" in (first, second):
            other = second if first == "world" else first
            if other in groups:
                fixed.add(id(groups[other]))
            continue
        if first not in groups or second not in groups or groups[first] is groups[second]:
            continue
        source.remark(f"the joints of {first.partition(SEPARATOR)[0]} are stiff here")
        kept, gone = groups[first], groups[second]
        kept += gone
        if id(gone) in fixed:
            fixed.add(id(kept))
        for body in gone:
            groups[body.name] = kept
    kept_groups = [group for group in every if groups[group[0].name] is group]
    return [welded(group, id(group) in fixed) for group in kept_groups]


def convex(body: Body, source: Source) -> Body:
    """Return a body that can move with the hulls of its meshes in place of them."""
    if not any(isinstance(part.shape, Mesh) for part in body.parts):
        return body
    source.remark(f"the meshes of {body.name}, which can move, are their convex hulls here")
    parts = [
        Part(hull_of(part.shape.vertices, part.shape.source), part.body_from_part)
        if isinstance(part.shape, Mesh)
        else part
        for part in body.parts
    ]
    return replace(body, parts=tuple(parts))


def welded(group: list[Body], is_fixed: bool) -> Body:
    """Return bodies as one, in the frame of the first, which stands if one of them does."""
    first = replace(group[0], is_static=group[0].is_static or is_fixed)
    if len(group) == 1:
        return first
    parts, visuals = list(first.parts), list(first.visuals)
    for body in group[1:]:
        moved = inverse_of(first.world_from_body) @ body.world_from_body
        parts += [Part(p.shape, moved @ p.body_from_part) for p in body.parts]
        visuals += [replace(v, body_from_visual=moved @ v.body_from_visual) for v in body.visuals]
    is_static = first.is_static or any(body.is_static for body in group)
    mass = sum(body.mass for body in group)
    return replace(
        first, parts=tuple(parts), visuals=tuple(visuals), mass=mass, is_static=is_static
    )
