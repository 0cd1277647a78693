"""Mesh of a robot: the visuals of its URDF as GLB, also without its wheels."""

from __future__ import annotations

import io
import itertools
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import trimesh
import yourdfpy
from scipy.spatial import QhullError

from swarm_common.model.records import FloatArray
from swarm_view.scene.shapes import Mesh
from swarm_view.scene.visuals import GREY, VisualMesh, painted, spokes, visuals
from swarm_view.scene.wheels import Axle, axles

FALLBACK_RADIUS, FALLBACK_HEIGHT = 0.15, 0.15  # [m] of a robot without visuals
FAR_FACES = 48  # of a part, from which on a simpler one is seen from afar
DIRECTIONS = np.array([way for way in itertools.product((-1.0, 0.0, 1.0), repeat=3) if any(way)])


@dataclass(frozen=True, slots=True)
class Wheel:
    """Wheel of a robot, to be drawn."""

    glb: bytes  # binary glTF in the wheel's own frame
    root_from_wheel: FloatArray  # (4, 4), the joint at zero
    axis: FloatArray  # (3,) about which it turns, in its own frame
    turns: FloatArray  # (3,) by how much on a way of its robot; see `Axle.turns`


@dataclass(frozen=True, slots=True)
class RobotMesh:
    """A model to draw."""

    glb: bytes  # binary glTF in the frame of the root link, joints at zero
    links: dict[str, FloatArray]  # root_from_link (4, 4) by link
    body: bytes  # the same as `glb` without the wheels
    wheels: tuple[Wheel, ...]
    shape: Mesh  # vertices (n, 3) and faces (m, 3) of all of it, simpler, to be drawn in one colour


def robot_mesh(urdf: str) -> RobotMesh:
    """Return what a URDF text shows; what cannot be read is left out and logged."""
    robot = yourdfpy.URDF.load(
        io.BytesIO(urdf.encode()), build_scene_graph=False, load_meshes=False
    ).robot
    links = _link_frames(robot)
    shown = visuals(robot)
    if not shown:
        cylinder = trimesh.creation.cylinder(FALLBACK_RADIUS, FALLBACK_HEIGHT)
        cylinder.apply_translation((0.0, 0.0, 0.5 * FALLBACK_HEIGHT))
        shown = [VisualMesh("", painted(cylinder, GREY))]
    ground = float(_scene(shown, links).bounds[0, 2])
    found = [axle for axle in axles(robot, links) if _stands(axle, shown, links, ground)]
    shape = _shape(_scene(shown, links))
    shown += [spoke for axle in found for spoke in spokes(robot, axle)]
    whole = _scene(shown, links)

    rolling = {link for axle in found for link in axle.links}
    body = [visual for visual in shown if visual.link not in rolling]
    wheels = []
    if body and found:
        center = np.mean([axle.root_from_wheel[:2, 3] for axle in found], axis=0)
        wheels = [_wheel(axle, shown, links, axle.turns(ground, center)) for axle in found]
    bare = _glb(_scene(body, links)) if wheels else b""
    return RobotMesh(_glb(whole), links, bare, tuple(wheels), shape)


def _wheel(
    axle: Axle, shown: Sequence[VisualMesh], links: dict[str, FloatArray], turns: FloatArray
) -> Wheel:
    wheel_from_root = np.linalg.inv(axle.root_from_wheel)
    frames = {link: np.round(wheel_from_root @ links[link], 9) for link in axle.links}
    own = [visual for visual in shown if visual.link in axle.links]
    return Wheel(_glb(_scene(own, frames)), axle.root_from_wheel, axle.axis, turns)


def _stands(
    axle: Axle, shown: Sequence[VisualMesh], links: dict[str, FloatArray], ground: float
) -> bool:
    own = [visual for visual in shown if visual.link in axle.links]
    return bool(own) and axle.stands(float(_scene(own, links).bounds[0, 2]), ground)


def _scene(shown: Sequence[VisualMesh], frames: dict[str, FloatArray]) -> Any:
    """Return the meshes in one frame, each at its place.

    A transform of their own would be applied twice by viser where two have the same shape.
    """
    scene = trimesh.Scene()
    for visual in shown:
        mesh = visual.mesh.copy()
        scene.add_geometry(mesh.apply_transform(frames.get(visual.link, np.eye(4))))
    return scene


def _glb(scene: Any) -> bytes:
    return bytes(scene.export(file_type="glb"))


def _shape(scene: Any) -> Mesh:
    """Return what is seen from afar: of parts with many faces the hull of few points."""
    parts = [trimesh.Trimesh(part.vertices, part.faces) for part in scene.dump()]
    mesh = trimesh.util.concatenate(
        [part if len(part.faces) <= FAR_FACES else _outermost(part) for part in parts]
    )
    return np.asarray(mesh.vertices, np.float32), np.asarray(mesh.faces, np.uint32)


def _outermost(part: Any) -> Any:
    """Return the convex hull of the points of a mesh that lie farthest out in 26 directions."""
    points = np.asarray(part.vertices)[np.argmax(part.vertices @ DIRECTIONS.T, axis=0)]
    try:
        return trimesh.convex.convex_hull(points)
    except QhullError:  # it is flat
        return part


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
