"""All robots in the scene: batches per model, and a ring in the colour of the state."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import viser

from swarm_common.model.palette import UNKNOWN, linear, state_color
from swarm_common.model.records import FloatArray
from swarm_view.bodies import AWAY, Bodies
from swarm_view.decode import RobotState
from swarm_view.robot_mesh import RobotMesh, robot_mesh
from swarm_view.shapes import lifted, quaternions, ring

RING_HEIGHT = 0.012  # [m]
RING_WIDTH = 0.07  # [m]
NEAR = 6.0  # [m] from a page's camera within which turning wheels can be seen
NEAR_ROBOTS = 16  # robots whose wheels turn, at most; all others cost nothing


class Fleet:
    """The robots' bodies, shared by all pages.

    Attributes:
        names: Of the robots that are drawn, in the order of all arrays.
        meshes: Model of each robot, as far as it is known.
    """

    def __init__(self, server: viser.ViserServer) -> None:
        """Draw no robot yet."""
        self.names: list[str] = []
        self.meshes: dict[str, RobotMesh] = {}
        self._server = server
        self._models: dict[str, RobotMesh] = {}
        self._bodies: list[Bodies] = []
        self._rings: Any = None
        self._colors: list[tuple[int, int, int]] = []

    def assemble(self, names: list[str], urdfs: Mapping[str, str]) -> None:
        """Draw these robots from now on; a robot without a description is only a ring."""
        for bodies in self._bodies:
            bodies.remove()
        self._bodies = []
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
            scene, rows = self._server.scene, np.array(members)
            self._bodies.append(Bodies(scene, f"/robots/{number}", mesh, rows, NEAR_ROBOTS))
        self._draw_rings(names)

    def _draw_rings(self, names: list[str]) -> None:
        radius = max([mesh.radius for mesh in self.meshes.values()], default=0.2)
        vertices, faces = ring(radius, radius + RING_WIDTH)
        self._colors = [UNKNOWN] * len(names)
        if self._rings is not None:
            self._rings.remove()
            self._rings = None
        if names:
            self._rings = self._server.scene.add_batched_meshes_simple(
                "/rings", vertices, faces,
                batched_wxyzs=quaternions(np.zeros(len(names))),
                batched_positions=np.full((len(names), 3), AWAY),
                batched_colors=np.array(self._colors, np.uint8),
                lod="off", side="double", cast_shadow=False, receive_shadow=False,
            )  # fmt: skip

    def look_from(self, cameras: Sequence[FloatArray], poses: FloatArray) -> bool:
        """Let the wheels of robots near cameras (3,) turn; return whether those are others."""
        if not cameras or len(poses) != len(self.names):
            return False
        places = lifted(poses[:, :2], 0.0)
        gaps = np.min([np.linalg.norm(places - camera, axis=1) for camera in cameras], axis=0)
        nearest = np.argsort(gaps, kind="stable")[:NEAR_ROBOTS]
        near = nearest[gaps[nearest] < NEAR]
        return any([bodies.look_at(near) for bodies in self._bodies])

    def move(self, poses: FloatArray) -> None:
        """Put the robots at poses (n, 3) in map."""
        if self._rings is None or len(poses) != len(self._colors):
            return
        for bodies in self._bodies:
            bodies.move(poses)
        places = lifted(poses[:, :2], RING_HEIGHT)
        self._rings.batched_positions = places.astype(np.float32)

    def color(self, names: list[str], states: Mapping[str, RobotState]) -> None:
        """Give each ring the colour of its robot's state."""
        colors = [
            linear(state_color(states[name].state)) if name in states else UNKNOWN for name in names
        ]
        if self._rings is not None and colors != self._colors and len(colors) == len(self._colors):
            self._colors = colors
            self._rings.batched_colors = np.array(colors, np.uint8)
