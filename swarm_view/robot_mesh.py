"""What a robot looks like: the visuals of its URDF, joints at zero, as one GLB."""

from __future__ import annotations

import io
import logging
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import trimesh
import yourdfpy

from swarm_common.errors import SwarmError
from swarm_common.packages import PackageFinder
from swarm_common.records import FloatArray

GREY = (0.6, 0.6, 0.6, 1.0)
FALLBACK_RADIUS, FALLBACK_HEIGHT = 0.15, 0.15  # [m] of a robot without visuals
LOG = logging.getLogger(__name__)


@dataclass(frozen=True, slots=True)
class RobotMesh:
    """A model to draw.

    Attributes:
        glb: Binary glTF in the frame of the root link.
        radius: [m] of a circle around the root link that holds all of it.
        height: [m] of its highest point.
        links: root_from_link (4, 4) by link.
    """

    glb: bytes
    radius: float
    height: float
    links: dict[str, FloatArray]


def robot_mesh(urdf: str) -> RobotMesh:
    """Return what a URDF text shows; what cannot be read is left out and logged."""
    robot = yourdfpy.URDF.load(
        io.BytesIO(urdf.encode()), build_scene_graph=False, load_meshes=False
    ).robot
    links = _link_frames(robot)
    materials = {material.name: material for material in robot.materials}
    scene = trimesh.Scene()
    for link in robot.links:
        for visual in link.visuals:
            origin = np.eye(4) if visual.origin is None else visual.origin
            for mesh in _meshes(visual, materials):
                scene.add_geometry(mesh, transform=links[link.name] @ origin)
    if scene.is_empty:
        body = trimesh.creation.cylinder(FALLBACK_RADIUS, FALLBACK_HEIGHT)
        body.apply_translation((0.0, 0.0, 0.5 * FALLBACK_HEIGHT))
        scene.add_geometry(_painted(body, GREY))
    corners = trimesh.bounds.corners(scene.bounds)
    radius = float(np.hypot(corners[:, 0], corners[:, 1]).max())
    glb = scene.export(file_type="glb")
    return RobotMesh(glb, radius, float(scene.bounds[1, 2]), links)


def _link_frames(robot: Any) -> dict[str, FloatArray]:
    children = {joint.child for joint in robot.joints}
    frames = {link.name: np.eye(4) for link in robot.links if link.name not in children}
    waiting = list(robot.joints)
    while waiting:
        ready = [joint for joint in waiting if joint.parent in frames]
        if not ready:
            break  # a loop, which the world would have refused
        for joint in ready:
            origin = np.eye(4) if joint.origin is None else joint.origin
            frames[joint.child] = frames[joint.parent] @ origin
        waiting = [joint for joint in waiting if joint.child not in frames]
    return frames


def _meshes(visual: Any, materials: dict[str, Any]) -> list[Any]:
    geometry = visual.geometry
    rgba = _color(visual.material, materials)
    if geometry.box is not None:
        return [_painted(trimesh.creation.box(geometry.box.size), rgba or GREY)]
    if geometry.cylinder is not None:
        shape = geometry.cylinder
        return [_painted(trimesh.creation.cylinder(shape.radius, shape.length), rgba or GREY)]
    if geometry.sphere is not None:
        ball = trimesh.creation.icosphere(subdivisions=2, radius=geometry.sphere.radius)
        return [_painted(ball, rgba or GREY)]
    if geometry.mesh is not None:
        return _loaded(geometry.mesh, rgba)
    return []


def _loaded(mesh: Any, rgba: tuple[float, ...] | None) -> list[Any]:
    try:
        path = PackageFinder().resolve(mesh.filename, Path.cwd())
    except SwarmError as error:
        LOG.warning("a mesh is not drawn: %s", error)
        return []
    try:
        parts = trimesh.load_scene(path).dump()
    except Exception as error:  # whatever a reader raises at a damaged file
        LOG.warning("mesh %s cannot be read: %s; it is not drawn", path, error)
        return []
    scale = np.ones(3) if mesh.scale is None else np.broadcast_to(mesh.scale, 3)
    for part in parts:
        part.apply_transform(np.diag([*scale, 1.0]))
    return [part if rgba is None else _painted(part, rgba) for part in parts]


def _color(material: Any, materials: dict[str, Any]) -> tuple[float, ...] | None:
    if material is None:
        return None
    if material.color is None:
        material = materials.get(material.name, material)
    return None if material.color is None else tuple(material.color.rgba)


def _painted(mesh: Any, rgba: tuple[float, ...]) -> Any:
    paint = trimesh.visual.material.PBRMaterial(
        baseColorFactor=[round(255 * value) for value in rgba],
        metallicFactor=0.1,
        roughnessFactor=0.7,
    )
    mesh.visual = trimesh.visual.TextureVisuals(material=paint)
    return mesh
