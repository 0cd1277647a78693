"""All robots of one model: those nearby as they look, the others in the colour of their state."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import viser
from numpy.typing import NDArray

from swarm_common.model.records import FloatArray
from swarm_view.scene.robot_mesh import RobotMesh
from swarm_view.scene.shapes import lifted, quaternions
from swarm_view.scene.wheels import WheelHubs, rolled

AWAY = -100.0  # [m] height of hidden bodies
PLAIN = 100_000  # [bytes] of a mesh up to which a simpler one is not worth drawing
Rows = NDArray[np.intp]
Colors = NDArray[np.uint8]


class Bodies:
    """Batches of the same meshes; `members` are the rows of their robots among all."""

    def __init__(
        self, scene: viser.SceneApi, name: str, mesh: RobotMesh, members: Rows, near: int
    ) -> None:
        """Draw the robots far away; at most `near` of them are nearby at a time."""
        self.members = members
        self._scene = scene
        self._name = name
        self._mesh = mesh
        self._room = min(near, len(members))
        self._whole = _Batch(
            scene.add_batched_meshes_simple, name, len(members), *mesh.shape,
            batched_colors=np.full((len(members), 3), 255, np.uint8),
            flat_shading=True, side="double", lod="off",
        )  # fmt: skip
        self._body: _Batch | None = None
        self._wheels: list[tuple[_Batch, list[int]]] = []
        self._near: Rows = np.zeros(0, np.intp)
        self._poses: FloatArray | None = None
        self._turns = np.array([wheel.turns for wheel in mesh.wheels]).reshape(-1, 3)
        self._hubs = WheelHubs([(wheel.root_from_wheel, wheel.axis) for wheel in mesh.wheels])
        self._angles = np.zeros((len(members), len(mesh.wheels)))

    def remove(self) -> None:
        """Remove all bodies."""
        for batch in (self._whole, self._body, *(batch for batch, _ in self._wheels)):
            if batch is not None:
                batch.remove()

    def look_at(self, near: Rows) -> bool:
        """Draw these of all robots as they look; return whether that is new."""
        own = np.flatnonzero(np.isin(self.members, near))
        if np.array_equal(own, self._near):
            return False
        self._near = own
        if self._body is None:
            self._draw_parts()
        return True

    def _draw_parts(self) -> None:
        mesh, room = self._mesh, self._room
        self._body = self._add(f"{self._name}_body", mesh.body or mesh.glb, room)
        alike: dict[bytes, list[int]] = {}
        for number, wheel in enumerate(mesh.wheels):
            alike.setdefault(wheel.glb, []).append(number)
        for glb, numbers in alike.items():
            name = f"{self._name}_wheel{numbers[0]}"
            self._wheels.append((self._add(name, glb, room * len(numbers)), numbers))

    def _add(self, name: str, glb: bytes, count: int) -> _Batch:
        lod = "off" if len(glb) < PLAIN else "auto"
        return _Batch(self._scene.add_batched_glb, name, count, glb, lod=lod)

    def move(self, poses: FloatArray) -> None:
        """Put the robots at poses (n, 3) of all robots, in map."""
        own, near = poses[self.members], self._near
        if self._poses is not None:
            self._angles += rolled(self._poses, own) @ self._turns.T
            self._angles %= 2.0 * np.pi
        self._poses = own
        places, turns = lifted(own[:, :2], 0.0), quaternions(own[:, 2])
        if self._body is not None:
            self._body.move(places[near], turns[near])
            hubs, rolls = self._hubs.placed(own[near], self._angles[near])
            for batch, numbers in self._wheels:
                batch.move(hubs[:, numbers].reshape(-1, 3), rolls[:, numbers].reshape(-1, 4))
        places[near, 2] = AWAY
        self._whole.move(places, turns)

    def color(self, colors: Colors) -> None:
        """Give the robots far away the colours (n, 3) of all robots."""
        self._whole.color(colors[self.members])


class _Batch:
    """Instances of a mesh; those without a place are far below the floor."""

    def __init__(
        self, add: Callable[..., Any], name: str, count: int, *shape: Any, **look: Any
    ) -> None:
        """Draw `count` instances with `add`, none of them at a place."""
        self._places = np.full((count, 3), AWAY, np.float32)
        self._turns = quaternions(np.zeros(count)).astype(np.float32)
        self._handle = add(
            name, *shape, batched_positions=self._places.copy(), batched_wxyzs=self._turns.copy(),
            cast_shadow=False, receive_shadow=False, **look,
        )  # fmt: skip

    def move(self, places: FloatArray, turns: FloatArray) -> None:
        """Put the first instances there, and the others away."""
        count = len(places)
        self._places[:count], self._places[count:] = places, AWAY
        self._turns[:count] = turns
        self._handle.batched_positions = self._places
        self._handle.batched_wxyzs = self._turns

    def color(self, colors: Colors) -> None:
        """Give each instance its colour (n, 3)."""
        self._handle.batched_colors = colors

    def remove(self) -> None:
        """Draw it no more."""
        self._handle.remove()
