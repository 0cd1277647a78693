"""All robots in the scene: batches per model, and a mark in the colour of the state below each.

A mark is a disc with a nose where its robot's front is. Each page sees it at least `MARK_PIXELS`
wide, however far away; the bodies keep their size, so that gaps between robots are what they seem.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import viser
from numpy.typing import NDArray

from swarm_common.model.palette import BLACK, RGB, UNKNOWN, linear, state_color
from swarm_common.model.records import FloatArray
from swarm_view.scene.bodies import AWAY, Bodies
from swarm_view.scene.robot_mesh import RobotMesh, robot_mesh
from swarm_view.scene.shapes import Mesh, lifted, pointer, quaternions
from swarm_view.scene.views import Camera
from swarm_view.state.decode import ReportedState

MARK_HEIGHT, RIM_HEIGHT = 0.012, 0.008  # [m]
RIM = 1.16  # of a mark's size
MARK_PIXELS = 26.0  # least width of a mark on a page, without its nose
PALE = 0.15  # share of white in a mark, so that its robot stands out
COARSE = 0.04  # largest relative error of a mark's size
NEAR = 6.0  # [m] from a page's camera within which a robot is drawn as it looks
NEAR_ROBOTS = 16  # robots drawn so, at most; all others cost less
Sizes = NDArray[np.float32]


class DrawnFleet:
    """The robots' bodies.

    Attributes:
        names: Robots that are drawn, in the order of all arrays.
        meshes: Model of each robot, as far as it is known.
        radius: [m] of a mark at its own size.
        revision: Grows when other robots are drawn.
    """

    def __init__(self, scene: viser.SceneApi, root: str = "") -> None:
        """Draw no robot yet."""
        self.names: list[str] = []
        self.meshes: dict[str, RobotMesh] = {}
        self.revision = 0
        self._scene = scene
        self._root = root
        self._models: dict[str, RobotMesh] = {}
        self._bodies: list[Bodies] = []
        self.radius = 0.2
        self._middles: FloatArray = np.zeros((0, 2))  # of the bodies, in their own frames
        self._marks: list[Any] = []  # fill and rim
        self._colors: list[RGB] = []

    @property
    def marks(self) -> tuple[str, str]:
        """Names of the nodes of all marks and of their rims."""
        return f"{self._root}/marks", f"{self._root}/rims"

    def assemble(self, names: list[str], urdfs: Mapping[str, str]) -> None:
        """Draw these robots from now on; a robot without a description is only a mark."""
        self.remove()
        self.names = list(names)
        self.meshes.clear()
        groups: dict[str, list[int]] = {}
        for index, name in enumerate(names):
            if name in urdfs:
                groups.setdefault(urdfs[name], []).append(index)
        for number, (urdf, members) in enumerate(groups.items()):
            if urdf not in self._models:
                self._models[urdf] = robot_mesh(urdf)
            mesh = self._models[urdf]
            self.meshes.update((names[index], mesh) for index in members)
            name = f"{self._root}/robots/{number}"
            self._bodies.append(Bodies(self._scene, name, mesh, np.array(members), NEAR_ROBOTS))
        self._draw_marks(len(names))
        self.revision += 1

    def remove(self) -> None:
        """Draw no robot any more."""
        for drawn in (*self._bodies, *self._marks):
            drawn.remove()
        self._bodies, self._marks, self._colors = [], [], []

    def _draw_marks(self, count: int) -> None:
        boxes = {name: _box(mesh) for name, mesh in self.meshes.items()}
        self.radius = max([radius for _, radius in boxes.values()], default=0.2)
        self._middles = np.array([boxes[n][0] if n in boxes else (0.0, 0.0) for n in self.names])
        self._colors = [UNKNOWN] * count
        if not count:
            return
        fill, rim = self.marks
        self._marks = [
            self._add_mark(fill, pointer(self.radius), np.array(self._colors, np.uint8)),
            self._add_mark(rim, pointer(RIM * self.radius), np.full((count, 3), BLACK, np.uint8)),
        ]

    def _add_mark(self, name: str, mesh: Mesh, colors: NDArray[np.uint8]) -> Any:
        count = len(colors)
        return self._scene.add_batched_meshes_simple(
            name,
            *mesh,
            batched_wxyzs=quaternions(np.zeros(count)),
            batched_positions=np.full((count, 3), AWAY),
            batched_scales=np.ones(count, np.float32),
            batched_colors=colors,
            lod="off",
            side="double",
            cast_shadow=False,
            receive_shadow=False,
        )

    def look_from(self, cameras: Sequence[FloatArray], poses: FloatArray) -> bool:
        """Draw robots near cameras (3,) as they look; return whether those are others."""
        if not cameras or len(poses) != len(self.names):
            return False
        places = lifted(poses[:, :2], 0.0)
        gaps = np.min([np.linalg.norm(places - camera, axis=1) for camera in cameras], axis=0)
        nearest = np.argsort(gaps, kind="stable")[:NEAR_ROBOTS]
        near = nearest[gaps[nearest] < NEAR]
        return any([bodies.look_at(near) for bodies in self._bodies])

    def move(self, poses: FloatArray) -> None:
        """Put the robots at poses (n, 3) in map."""
        if not self._marks or len(poses) != len(self._colors):
            return
        for bodies in self._bodies:
            bodies.move(poses)
        turns = quaternions(poses[:, 2]).astype(np.float32)
        middles = self.middles(poses)
        for mark, height in zip(self._marks, (MARK_HEIGHT, RIM_HEIGHT), strict=True):
            mark.batched_positions = lifted(middles, height).astype(np.float32)
            mark.batched_wxyzs = turns

    def middles(self, poses: FloatArray) -> FloatArray:
        """Return the middles (n, 2) of the bodies at poses (n, 3), in map."""
        cos, sin = np.cos(poses[:, 2]), np.sin(poses[:, 2])
        x, y = self._middles.T
        turned = np.column_stack([cos * x - sin * y, sin * x + cos * y])
        middles: FloatArray = poses[:, :2] + turned
        return middles

    def color(self, names: list[str], states: Mapping[str, ReportedState]) -> None:
        """Give each robot and its mark the colour of its state."""
        colors = [
            linear(state_color(states[name].state)) if name in states else UNKNOWN for name in names
        ]
        if self._marks and colors != self._colors and len(colors) == len(self._colors):
            self._colors = colors
            values = np.array(colors, np.uint8)
            self._marks[0].batched_colors = np.array([_pale(color) for color in colors], np.uint8)
            for bodies in self._bodies:
                bodies.color(values)

    def mark_sizes(self, camera: Camera, poses: FloatArray) -> Sizes:
        """Return by how much to enlarge each mark (n,) on a page with a camera."""
        wanted = 0.5 * MARK_PIXELS * camera.sizes(lifted(poses[:, :2], 0.0))
        return np.maximum(1.0, wanted / self.radius).astype(np.float32)


def _box(mesh: RobotMesh) -> tuple[FloatArray, float]:
    """Return the middle (2,) of a body seen from above, and how far it reaches from there [m]."""
    low, high = (bound(mesh.shape[0][:, :2], axis=0) for bound in (np.min, np.max))
    return 0.5 * (low + high), 0.5 * float(np.linalg.norm(high - low))


def _pale(color: RGB) -> RGB:
    red, green, blue = (round((1.0 - PALE) * value + PALE * 255) for value in color)
    return red, green, blue


def are_alike(one: Sizes, other: Sizes | None) -> bool:
    """Return whether nobody sees the difference between two lists of sizes."""
    if other is None or len(one) != len(other):
        return False
    return bool((np.abs(one - other) <= COARSE * other).all())
