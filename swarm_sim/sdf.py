"""Reading of SDFormat worlds (Gazebo's `.sdf` and `.world`) into a `Scene`.

Read: models, nested models, links, collisions with box, cylinder, sphere and plane, and poses.
Ignored on purpose: visuals, lights, plugins, physics settings, sensors, cameras.
"""

from __future__ import annotations

import xml.etree.ElementTree as ET
from collections.abc import Callable, Iterator
from pathlib import Path

from swarm_common.errors import WorldError
from swarm_common.resources import find_resource, resource_names
from swarm_common.sites import Sites
from swarm_common.sites_io import load_sites
from swarm_sim.actors import ACTORS_FILE, load_actors
from swarm_sim.scene import (
    Body,
    Box,
    Cylinder,
    Part,
    Plane,
    Scene,
    Shape,
    Sphere,
    Transform,
    transform_from_xyz_rpy,
)

WORLD_FILE = "world.sdf"
SITES_FILE = "sites.yaml"


def world_names() -> list[str]:
    """Return the names of the worlds that ship with the project."""
    return resource_names("world", WORLD_FILE)


def load_world(name_or_path: str | Path) -> Scene:
    """Return a world.

    Args:
        name_or_path: Name of a folder in `worlds/`, or a path to a folder, `.sdf` or `.world`.

    Raises:
        UnknownNameError: If there is no such world.
        WorldError: If the file is unusable; the message names file and line or element.
    """
    path = find_resource("world", name_or_path, WORLD_FILE)
    sites_path, actors_path = path.with_name(SITES_FILE), path.with_name(ACTORS_FILE)
    return Scene(
        name=path.parent.name if path.name == WORLD_FILE else path.stem,
        directory=path.parent,
        bodies=tuple(read_bodies(path)),
        sites=load_sites(sites_path) if sites_path.is_file() else Sites(),
        walkers=load_actors(actors_path) if actors_path.is_file() else (),
    )


def read_bodies(path: Path) -> list[Body]:
    """Return the links of all models in an SDF file, in file order."""
    try:
        root = ET.parse(path).getroot()
    except ET.ParseError as cause:
        line, column = cause.position
        raise WorldError(f"{path}, line {line}, column {column}: malformed XML: {cause}") from cause
    except OSError as cause:
        raise WorldError(f"cannot read {path}: {cause}") from cause
    if root.tag != "sdf":
        raise WorldError(f"{path}: the outermost element is <{root.tag}>; expected <sdf>")
    world = root.find("world")
    top = root if world is None else world
    try:
        return [
            body
            for model in top.findall("model")
            for body in _bodies_of_model(model, "", _IDENTITY, False)
        ]
    except WorldError as cause:
        raise WorldError(f"{path}: {cause}") from cause


_IDENTITY = transform_from_xyz_rpy(0.0, 0.0, 0.0, 0.0, 0.0, 0.0)


def _bodies_of_model(
    model: ET.Element, prefix: str, world_from_parent: Transform, is_static: bool
) -> Iterator[Body]:
    name = prefix + model.get("name", "model")
    world_from_model = world_from_parent @ _pose(model, name)
    is_static = is_static or _text(model, "static", "false") in ("true", "1")
    for link in model.findall("link"):
        body = _body(link, f"{name}::{link.get('name', 'link')}", world_from_model, is_static)
        if body.parts:
            yield body
    for child in model.findall("model"):
        yield from _bodies_of_model(child, f"{name}::", world_from_model, is_static)


def _body(link: ET.Element, name: str, world_from_model: Transform, is_static: bool) -> Body:
    parts = [
        Part(shape, _pose(collision, name))
        for collision in link.findall("collision")
        if (shape := _shape(collision, name)) is not None
    ]
    mass = _floats(link.find("inertial/mass"), 1, "1", name)[0]
    return Body(name, world_from_model @ _pose(link, name), tuple(parts), is_static, mass)


def _shape(collision: ET.Element, where: str) -> Shape | None:
    geometry = collision.find("geometry")
    if geometry is None:
        raise WorldError(f"<collision> of {where} has no <geometry>")
    for element in geometry:
        if element.tag in _SHAPES:
            return _SHAPES[element.tag](element, where)
        raise WorldError(
            f"<{element.tag}> in a <collision> of {where} is not supported; "
            f"expected one of {', '.join(_SHAPES)}"
        )
    return None


def _box(element: ET.Element, where: str) -> Shape:
    x, y, z = _sizes(element, "size", 3, where)
    return Box((x, y, z))


def _cylinder(element: ET.Element, where: str) -> Shape:
    return Cylinder(*_sizes(element, "radius", 1, where), *_sizes(element, "length", 1, where))


def _sphere(element: ET.Element, where: str) -> Shape:
    return Sphere(*_sizes(element, "radius", 1, where))


def _plane(element: ET.Element, where: str) -> Shape:
    x, y, z = _floats(element.find("normal"), 3, "0 0 1", where)
    return Plane((x, y, z))


_SHAPES: dict[str, Callable[[ET.Element, str], Shape]] = {
    "box": _box,
    "cylinder": _cylinder,
    "sphere": _sphere,
    "plane": _plane,
}


def _pose(element: ET.Element, where: str) -> Transform:
    return transform_from_xyz_rpy(*_floats(element.find("pose"), 6, "0 0 0 0 0 0", where))


def _text(element: ET.Element, tag: str, default: str) -> str:
    return (element.findtext(tag) or default).strip()


def _sizes(element: ET.Element, tag: str, count: int, where: str) -> list[float]:
    child = element.find(tag)
    if child is None:
        raise WorldError(f"<{element.tag}> of {where} has no <{tag}>")
    values = _floats(child, count, "", where)
    if min(values) <= 0.0:
        raise WorldError(f"<{tag}> of {where} is '{child.text}'; it must be positive")
    return values


def _floats(element: ET.Element | None, count: int, default: str, where: str) -> list[float]:
    text = default if element is None else (element.text or "")
    try:
        values = [float(word) for word in text.split()]
    except ValueError:
        values = []
    if len(values) != count:
        tag = "" if element is None else element.tag
        raise WorldError(f"<{tag}> of {where} is '{text}'; expected {count} numbers")
    return values
