"""Wheels that roll: which joints are wheels, and how far each turns on a way of its robot."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from viser.transforms import SO3

from swarm_common.model.records import FloatArray
from swarm_describe.robots.drive_tags import is_omni
from swarm_describe.robots.drive_train import GROUND

UPRIGHT = 0.1  # sine of the largest tilt of an axle
LEAST_RADIUS = 0.005  # [m]
SAME = 1e-3  # [m] and of a cosine, between two axes that are one


@dataclass(frozen=True, slots=True)
class Axle:
    """A joint that turns without end about a level axis."""

    links: tuple[str, ...]  # what turns with it; the first is the one that it moves
    root_from_wheel: FloatArray  # (4, 4) of the first link, the joint at zero
    axis: FloatArray  # (3,) of unit length, in the first link's frame
    is_mecanum: bool = False  # whether its wheel has rollers at 45 degrees

    def turns(self, ground: float, center: FloatArray) -> FloatArray:
        """Return by how much it turns as its robot moves without slipping.

        Args:
            ground: Height of the floor in the root link's frame.
            center: (2,) between all wheels, in that frame.

        Returns:
            (3,): [rad/m] forwards, [rad/m] to the left, [rad/rad] as the root link turns.
        """
        x, y, height = self.root_from_wheel[:3, 3]
        axis = self.root_from_wheel[:3, :3] @ self.axis
        rolled = np.array([axis[1], -axis[0]])  # where it goes to when it turns forwards
        if self.is_mecanum:  # seen from above the rollers make an X
            side = -np.sign((x - center[0]) * (y - center[1]))
            rolled = rolled + side * np.array([-rolled[1], rolled[0]])
        ahead, left = rolled / (height - ground)
        return np.array([ahead, left, left * x - ahead * y])

    def stands(self, lowest: float, ground: float) -> bool:
        """Return whether the turning part, which ends at a height [m], stands on the ground."""
        return lowest < ground + GROUND and self.root_from_wheel[2, 3] > ground + LEAST_RADIUS

    def runs_along(self, wheel_from_part: FloatArray) -> bool:
        """Return whether the axle lies along the z axis of a part (4, 4), in either direction."""
        lever = np.cross(self.axis, wheel_from_part[:3, 3])
        along = abs(self.axis @ wheel_from_part[:3, 2])
        return bool(along > 1.0 - SAME and np.abs(lever).max() < SAME)


def axles(robot: Any, frames: Mapping[str, FloatArray]) -> list[Axle]:
    """Return the joints of a yourdfpy robot that may be wheels."""
    found = []
    moved = {joint.child for joint in robot.joints}
    still = _carried([link for link in frames if link not in moved], robot, only_fixed=True)
    for joint in robot.joints:
        if joint.type != "continuous" or joint.parent not in still or joint.child not in frames:
            continue
        axis = np.asarray(joint.axis, float) / np.linalg.norm(joint.axis)
        place = frames[joint.child]
        if abs((place[:3, :3] @ axis)[2]) > UPRIGHT:
            continue
        links = _carried([joint.child], robot, only_fixed=False)
        is_mecanum = is_omni(f"{robot.name} {joint.name} {joint.child}")
        found.append(Axle(tuple(links), place, axis, is_mecanum))
    return found


def _carried(links: list[str], robot: Any, *, only_fixed: bool) -> list[str]:
    """Return links with all links that they carry."""
    found = list(links)
    for link in found:  # grows
        found += [
            joint.child
            for joint in robot.joints
            if joint.parent == link and joint.child not in found
            if joint.type == "fixed" or not only_fixed
        ]
    return found


class WheelHubs:
    """Where the wheels of robots of one model are."""

    def __init__(self, wheels: Sequence[tuple[FloatArray, FloatArray]]) -> None:
        """Store root_from_wheel (4, 4) and axis (3,), in the wheel's frame, of each."""
        self._places = np.array([place[:3, 3] for place, _ in wheels]).reshape(-1, 3)
        still = [SO3.from_matrix(place[:3, :3]) for place, _ in wheels]
        half = [SO3(np.array([0.0, *axis])) for _, axis in wheels]  # a turn by 180 degrees
        self._still = np.array([turn.wxyz for turn in still]).reshape(-1, 4)
        self._half = np.array([(s @ h).wxyz for s, h in zip(still, half, strict=True)])
        self._half = self._half.reshape(-1, 4)

    def placed(self, poses: FloatArray, angles: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return places (n, k, 3) and quaternions (n, k, 4), w first.

        `poses` (n, 3) are x, y, yaw of the robots, `angles` (n, k) the turns of their wheels.
        """
        places = np.empty((*angles.shape, 3))
        cos, sin = np.cos(poses[:, 2:]), np.sin(poses[:, 2:])
        x, y, z = self._places.T
        places[..., 0] = poses[:, :1] + cos * x - sin * y
        places[..., 1] = poses[:, 1:2] + sin * x + cos * y
        places[..., 2] = z
        half = 0.5 * angles[..., None]
        own = np.cos(half) * self._still + np.sin(half) * self._half
        cos, sin = (f(0.5 * poses[:, 2])[:, None, None] for f in (np.cos, np.sin))
        across = own[..., [3, 2, 1, 0]] * [-1.0, -1.0, 1.0, 1.0]  # the turn by 180 degrees about z
        turns: FloatArray = cos * own + sin * across
        return places, turns


def rolled(before: FloatArray, after: FloatArray) -> FloatArray:
    """Return the ways (n, 3) of robots between poses (n, 3), in their own frames.

    Forwards [m], to the left [m], turned to the left [rad].
    """
    step = after - before
    turn = (step[:, 2] + np.pi) % (2.0 * np.pi) - np.pi
    yaw = before[:, 2] + 0.5 * turn
    cos, sin = np.cos(yaw), np.sin(yaw)
    ahead = cos * step[:, 0] + sin * step[:, 1]
    left = cos * step[:, 1] - sin * step[:, 0]
    return np.column_stack([ahead, left, turn])
