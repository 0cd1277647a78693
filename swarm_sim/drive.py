"""Between commands and wheels: which speeds robots aim at, and what their odometry makes of it."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from swarm_common.records import CONTROL_PERIOD, Odometry, Pose, RobotSpec, Twist, wrap_angle

FloatArray = NDArray[np.float64]
_STOP = (0.0, 0.0)
COMMAND_TIMEOUT = 0.5  # [s] of simulated time after which a robot without a command stops


class CommandBuffer:
    """Holds the last command of each robot, within its limits, until it is too old."""

    def __init__(self, specs: Sequence[RobotSpec]) -> None:
        """Start with everybody standing."""
        self._limits = np.array([[spec.max_vel_x, spec.max_vel_theta] for spec in specs])
        self._targets = np.zeros((len(specs), 2))
        self._ages = np.zeros(len(specs), np.int64)
        self._max_age = round(COMMAND_TIMEOUT / CONTROL_PERIOD)

    def update(self, commands: Sequence[Twist | None]) -> FloatArray:
        """Return the speeds (n, 2) to aim at: vx [m/s], wz [rad/s].

        Args:
            commands: One per robot; None from a robot that sent none. A command that is not
                finite means stop.
        """
        speeds = [_STOP if c is None else (c.vx, c.wz) for c in commands]
        is_silent = np.array([command is None for command in commands], np.bool_)
        self._ages = np.where(is_silent, self._ages + 1, 0)
        is_held = is_silent & (self._ages < self._max_age)
        commanded = np.array(speeds).reshape(-1, 2)
        commanded[~np.isfinite(commanded).all(axis=1)] = 0.0
        self._targets[~is_held] = commanded[~is_held]
        np.clip(self._targets, -self._limits, self._limits, out=self._targets)
        return self._targets


class Odometer:
    """Odometry as a TurtleBot3 does it: distance from the wheels, heading from the gyro."""

    def __init__(self, count: int) -> None:
        """Start all robots at the origins of their odom frames."""
        self._poses = np.zeros((count, 3))
        self._travels = np.zeros(count)
        self._yaws = np.zeros(count)

    def update(self, travels: FloatArray, yaws: FloatArray) -> None:
        """Take in a control period, in which each robot drove an arc.

        Args:
            travels: (n,) [m] that the wheels report since the start.
            yaws: (n,) [rad] that the gyro reports since the start, not wrapped.
        """
        turned = yaws - self._yaws
        chords = (travels - self._travels) * np.sinc(turned / (2.0 * np.pi))
        headings = self._yaws + 0.5 * turned
        self._poses[:, 0] += chords * np.cos(headings)
        self._poses[:, 1] += chords * np.sin(headings)
        self._poses[:, 2] = yaws
        self._travels[:] = travels
        self._yaws[:] = yaws

    def readings(self, tick: int, twists: FloatArray) -> list[Odometry]:
        """Return the odometry of all robots; `twists` is (n, 2): vx, wz."""
        return [
            Odometry(tick, Pose(x, y, wrap_angle(yaw)), Twist(vx, 0.0, wz))
            for (x, y, yaw), (vx, wz) in zip(self._poses.tolist(), twists.tolist(), strict=True)
        ]
