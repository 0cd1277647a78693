"""Geometry of collisions and visuals in an SDF file, and the colours of materials."""

from __future__ import annotations

import math
import xml.etree.ElementTree as ET
from collections.abc import Callable
from typing import Any

import numpy as np

from swarm_common.model.errors import WorldError
from swarm_common.model.shapes import Box, Color, Cylinder, Mesh, Plane, Shape, Sphere
from swarm_describe.files.values import color_of, floats_of, sizes_of

EMPTY = "empty"
# Colours of the materials that Gazebo brings along, by the end of their names.
NAMED_COLORS: dict[str, Color] = {
    "White": (1.0, 1.0, 1.0, 1.0),
    "Grey": (0.5, 0.5, 0.5, 1.0),
    "LightGrey": (0.75, 0.75, 0.75, 1.0),
    "DarkGrey": (0.3, 0.3, 0.3, 1.0),
    "Black": (0.05, 0.05, 0.05, 1.0),
    "FlatBlack": (0.05, 0.05, 0.05, 1.0),
    "Red": (0.9, 0.1, 0.1, 1.0),
    "Green": (0.1, 0.7, 0.1, 1.0),
    "Blue": (0.1, 0.1, 0.9, 1.0),
    "SkyBlue": (0.4, 0.7, 0.95, 1.0),
    "Yellow": (0.95, 0.9, 0.1, 1.0),
    "Orange": (1.0, 0.55, 0.1, 1.0),
    "Purple": (0.6, 0.1, 0.7, 1.0),
    "Turquoise": (0.1, 0.8, 0.8, 1.0),
    "Gold": (0.85, 0.65, 0.15, 1.0),
    "Wood": (0.6, 0.42, 0.25, 1.0),
    "WoodFloor": (0.65, 0.5, 0.33, 1.0),
    "WoodPallet": (0.7, 0.55, 0.35, 1.0),
    "Bricks": (0.6, 0.3, 0.23, 1.0),
    "Grass": (0.3, 0.5, 0.2, 1.0),
    "Residential": (0.7, 0.65, 0.6, 1.0),
}


def shape_of(element: ET.Element, where: str) -> Shape:
    """Return the shape in a child of `<geometry>`; not for meshes."""
    if element.tag not in _SHAPES:
        raise WorldError(
            f"<{element.tag}> in a <collision> of {where} is not supported; "
            f"expected one of {', '.join([*_SHAPES, 'mesh', EMPTY])}"
        )
    return _SHAPES[element.tag](element, where)


def is_known(tag: str) -> bool:
    """Return whether `shape_of` reads elements of this tag."""
    return tag in _SHAPES


def material_color(visual: ET.Element, where: str) -> Color | None:
    """Return red, green, blue, opacity (0 to 1) of a visual's material; None if there is none."""
    material = visual.find("material")
    if material is None:
        return None
    for tag in ("diffuse", "ambient"):
        color = color_of(material.find(tag), where)
        if color is not None:
            return color
    name = (material.findtext("script/name") or "").strip().rpartition("/")[2]
    return NAMED_COLORS.get(name)


def _box(element: ET.Element, where: str) -> Shape:
    x, y, z = sizes_of(element, "size", 3, where)
    return Box((x, y, z))


def _cylinder(element: ET.Element, where: str) -> Shape:
    return Cylinder(*sizes_of(element, "radius", 1, where), *sizes_of(element, "length", 1, where))


def _sphere(element: ET.Element, where: str) -> Shape:
    return Sphere(*sizes_of(element, "radius", 1, where))


def _plane(element: ET.Element, where: str) -> Shape:
    x, y, z = floats_of(element.find("normal"), 3, "0 0 1", where)
    if math.hypot(x, y, z) < 1e-6:
        raise WorldError(f"<normal> of {where} has length 0")
    return Plane((x, y, z))


def _capsule(element: ET.Element, where: str) -> Shape:
    from trimesh import creation  # slow to import, and rarely needed

    (radius,), (length,) = (sizes_of(element, tag, 1, where) for tag in ("radius", "length"))
    mesh = creation.capsule(height=length, radius=radius, count=(16, 24))
    return _mesh(mesh, "capsule", (0.0, 0.0, -length / 2.0))


def _cone(element: ET.Element, where: str) -> Shape:
    from trimesh import creation

    (radius,), (length,) = (sizes_of(element, tag, 1, where) for tag in ("radius", "length"))
    mesh = creation.cone(radius=radius, height=length, sections=24)
    return _mesh(mesh, "cone", (0.0, 0.0, -length / 2.0))


def _ellipsoid(element: ET.Element, where: str) -> Shape:
    from trimesh import creation

    mesh = creation.icosphere(subdivisions=3)
    mesh.apply_scale(sizes_of(element, "radii", 3, where))
    return _mesh(mesh, "ellipsoid", (0.0, 0.0, 0.0))


def _polyline(element: ET.Element, where: str) -> Shape:
    import shapely
    from trimesh import creation

    points = [floats_of(point, 2, "", where) for point in element.findall("point")]
    (height,) = sizes_of(element, "height", 1, where)
    outline = shapely.Polygon(points) if len(points) >= 3 else shapely.Polygon()
    if outline.is_empty or not outline.is_valid or outline.area < 1e-9:
        raise WorldError(
            f"<polyline> of {where} has {len(points)} points that bound no area, or cross; "
            "expected the corners of one polygon in order"
        )
    return _mesh(creation.extrude_polygon(outline, height), "polyline", (0.0, 0.0, 0.0))


def _mesh(mesh: Any, kind: str, offset: tuple[float, float, float]) -> Mesh:
    vertices = np.array(mesh.vertices, dtype=np.float64) + offset
    return Mesh(vertices, np.array(mesh.faces, dtype=np.int64), kind)


_SHAPES: dict[str, Callable[[ET.Element, str], Shape]] = {
    "box": _box,
    "cylinder": _cylinder,
    "sphere": _sphere,
    "plane": _plane,
    "capsule": _capsule,
    "cone": _cone,
    "ellipsoid": _ellipsoid,
    "polyline": _polyline,
}
