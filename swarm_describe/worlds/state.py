"""The `<state>` of an SDF world: poses that models and links had when the world was saved."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from dataclasses import dataclass, field

from swarm_common.model.errors import WorldError
from swarm_describe.files.values import floats_of, transform_of
from swarm_describe.worlds.frames import SEPARATOR
from swarm_describe.worlds.models import MAX_DEPTH
from swarm_describe.worlds.scene import Transform
from swarm_describe.worlds.source import Source


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
