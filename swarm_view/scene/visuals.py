"""Visuals of the links of a URDF: meshes in their colours, and spokes on plain wheels."""

from __future__ import annotations

import logging
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import trimesh

from swarm_common.model.errors import SwarmError
from swarm_common.model.records import FloatArray
from swarm_describe.files.meshes import open_mesh
from swarm_describe.files.packages import PackageFinder
from swarm_view.scene.wheels import Axle

GREY = (0.6, 0.6, 0.6, 1.0)
BRIGHT, DARK = (0.75, 0.75, 0.75, 1.0), (0.25, 0.25, 0.25, 1.0)  # spokes
SPOKE_WIDTH = 0.22  # of the radius
SPOKE_HEIGHT = 0.0015  # [m] by which spokes stick out of a wheel
LOG = logging.getLogger(__name__)


@dataclass(frozen=True, slots=True)
class VisualMesh:
    """A mesh in the frame of its link."""

    link: str
    mesh: Any


def visuals(robot: Any) -> list[VisualMesh]:
    """Return what a yourdfpy robot shows; what cannot be read is left out and logged."""
    materials = {material.name: material for material in robot.materials}
    return [
        VisualMesh(link.name, mesh.apply_transform(_origin(visual)))
        for link in robot.links
        for visual in link.visuals
        for mesh in _meshes(visual, materials)
    ]


def _origin(visual: Any) -> FloatArray:
    origin: FloatArray = np.eye(4) if visual.origin is None else visual.origin
    return origin


def _meshes(visual: Any, materials: dict[str, Any]) -> list[Any]:
    geometry, make = visual.geometry, trimesh.creation
    rgba = _color(visual.material, materials)
    if geometry.box is not None:
        mesh = make.box(geometry.box.size)
    elif geometry.cylinder is not None:
        mesh = make.cylinder(geometry.cylinder.radius, geometry.cylinder.length)
    elif geometry.sphere is not None:
        mesh = make.icosphere(subdivisions=2, radius=geometry.sphere.radius)
    else:
        return [] if geometry.mesh is None else _loaded(geometry.mesh, rgba)
    return [painted(mesh, rgba or GREY)]


def spokes(robot: Any, axle: Axle) -> list[VisualMesh]:
    """Return spokes of plain wheels, which make it visible that they turn."""
    materials = {material.name: material for material in robot.materials}
    beams = []
    for visual in next(link for link in robot.links if link.name == axle.links[0]).visuals:
        cylinder, place = visual.geometry.cylinder, _origin(visual)
        if cylinder is None or not axle.runs_along(place):
            continue
        width, across = SPOKE_WIDTH * cylinder.radius, 2.0 * (cylinder.radius + SPOKE_HEIGHT)
        rgba = _color(visual.material, materials) or GREY
        paint = BRIGHT if sum(rgba[:3]) < 1.5 else DARK
        for size in ((across, width), (width, across)):
            beam = trimesh.creation.box((*size, cylinder.length + 2.0 * SPOKE_HEIGHT))
            beam.apply_transform(place)
            beams.append(VisualMesh(axle.links[0], painted(beam, paint)))
    return beams


def _loaded(mesh: Any, rgba: tuple[float, ...] | None) -> list[Any]:
    try:
        scene, unit = open_mesh(PackageFinder().resolve(mesh.filename, Path.cwd()))
    except SwarmError as error:
        LOG.warning("a mesh is not drawn: %s", error)
        return []
    scale = unit * np.broadcast_to(1.0 if mesh.scale is None else mesh.scale, 3)
    parts = scene.dump()
    for part in parts:
        part.apply_transform(np.diag([*scale, 1.0]))
    return [part if rgba is None else painted(part, rgba) for part in parts]


def _color(material: Any, materials: dict[str, Any]) -> tuple[float, ...] | None:
    if material is None:
        return None
    if material.color is None:
        material = materials.get(material.name, material)
    return None if material.color is None else tuple(material.color.rgba)


def painted(mesh: Any, rgba: tuple[float, ...]) -> Any:
    """Give a mesh a colour; returns it."""
    paint = trimesh.visual.material.PBRMaterial(
        baseColorFactor=[round(255 * value) for value in rgba],
        metallicFactor=0.1,
        roughnessFactor=0.7,
    )
    mesh.visual = trimesh.visual.TextureVisuals(material=paint)
    return mesh
