"""Between commands and wheels: which speeds robots aim at, and what their odometry makes of it."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from swarm_common.model.records import (
    CONTROL_PERIOD,
    FloatArray,
    Odometry,
    Pose,
    RobotSpec,
    Twist,
    wrap_angle,
)

_STOP = (0.0, 0.0, 0.0)
COMMAND_TIMEOUT = 0.5  # [s] of simulated time after which a robot without a command stops


class CommandBuffer:
    """Holds the last command of each robot, within its limits, until it is too old."""

    def __init__(self, specs: Sequence[RobotSpec]) -> None:
        self._limits = np.array([[s.max_vel_x, s.max_vel_theta, s.max_vel_y] for s in specs])
        self._targets = np.zeros((len(specs), 3))
        self._ages = np.zeros(len(specs), np.int64)
        self._max_age = round(COMMAND_TIMEOUT / CONTROL_PERIOD)

    def add(self, spec: RobotSpec) -> None:
        """Add a robot, which stands still."""
        limits = [spec.max_vel_x, spec.max_vel_theta, spec.max_vel_y]
        self._limits = np.vstack([self._limits, limits])
        self._targets = np.vstack([self._targets, _STOP])
        self._ages = np.append(self._ages, 0)

    def stop(self, robot: int) -> None:
        """Forget the last command of a robot."""
        self._targets[robot] = _STOP

    def update(self, commands: Sequence[Twist | None]) -> FloatArray:
        """Return the speeds (n, 3) to aim at: vx [m/s], wz [rad/s], vy [m/s].

        Args:
            commands: One per robot; None from a robot that sent none. A command that is not
                finite means stop.
        """
        speeds = [_STOP if c is None else (c.vx, c.wz, c.vy) for c in commands]
        is_silent = np.array([command is None for command in commands], np.bool_)
        self._ages = np.where(is_silent, self._ages + 1, 0)
        is_held = is_silent & (self._ages < self._max_age)
        commanded = np.array(speeds).reshape(-1, 3)
        commanded[~np.isfinite(commanded).all(axis=1)] = 0.0
        self._targets[~is_held] = commanded[~is_held]
        np.clip(self._targets, -self._limits, self._limits, out=self._targets)
        return self._targets


class Wheels:
    """Relation between the rates of a robot's driven wheels and its motion, in both directions."""

    def __init__(self, spec: RobotSpec) -> None:
        """Lay out the wheels: the left ones from front to rear, then the right ones."""
        self.names = (*spec.wheels_left, *spec.wheels_right)
        self._radius = spec.wheel_radius
        half = spec.wheel_separation / 2.0
        # of mecanum wheels, rollers at 45 degrees: they make an X seen from above
        lever = half + spec.wheel_base / 2.0 if spec.is_omni else half
        sides = [-1.0] * len(spec.wheels_left) + [1.0] * len(spec.wheels_right)
        self._arms = np.array(sides) * lever
        self._slides = np.array([0.0] * len(sides))
        if spec.is_omni and len(sides) == 4:
            self._slides = np.array([-1.0, 1.0, 1.0, -1.0])
        self._levers = list(zip(self._arms.tolist(), self._slides.tolist(), strict=True))

    def rates(self, vx: float, wz: float, vy: float) -> FloatArray:
        """Return the turning rates (w,) [rad/s] of the wheels at a motion of base_footprint.

        With distances in place of speeds, the angles are returned.

        Args:
            vy: [m/s] to the left; drives that cannot move sideways ignore it.
        """
        rates: FloatArray = (vx + self._arms * wz + self._slides * vy) / self._radius
        return rates

    def plain_rates(self, vx: float, wz: float, vy: float) -> list[float]:
        """Return the same as `rates`, to the bit, in less time for plain numbers."""
        return [(vx + arm * wz + slide * vy) / self._radius for arm, slide in self._levers]

    def travel(self, angles: FloatArray) -> tuple[float, float]:
        """Return the way [m] forwards and to the left that wheels turned by `angles` report.

        Args:
            angles: (w,) [rad] in the order of `names`, positive forwards.
        """
        count = len(angles)
        forwards = angles.sum() / count * self._radius
        return float(forwards), float((self._slides * angles).sum() / count * self._radius)


def travelled(before: FloatArray, after: FloatArray) -> FloatArray:
    """Return the way (2,) [m] forwards and to the left between two poses (3,), along an arc.

    Args:
        before: Pose x, y, yaw [m, rad].
        after: Pose x, y, yaw [m, rad], less than half a turn later.

    Returns:
        The way in the frame of the robot halfway between the two.
    """
    turned = after[2] - before[2]
    turned -= 2.0 * np.pi * np.round(turned / (2.0 * np.pi))
    middle = before[2] + 0.5 * turned
    cos, sin = np.cos(middle), np.sin(middle)
    x, y = (after[:2] - before[:2]) / np.sinc(turned / (2.0 * np.pi))
    return np.array([cos * x + sin * y, cos * y - sin * x])


class Odometer:
    """Odometry as a TurtleBot3 does it: distance from the wheels, heading from the gyro."""

    def __init__(self, count: int) -> None:
        self._poses = np.zeros((count, 3))
        self._travels = np.zeros((count, 2))
        self._yaws = np.zeros(count)

    def add(self) -> None:
        """Add a robot, at the origin of its odom frame."""
        self._poses = np.vstack([self._poses, np.zeros(3)])
        self._travels = np.vstack([self._travels, np.zeros(2)])
        self._yaws = np.append(self._yaws, 0.0)

    def restart(self, robot: int) -> None:
        """Begin again at the origin; the readings of wheels and gyro begin at 0, too."""
        self._poses[robot] = 0.0
        self._travels[robot] = 0.0
        self._yaws[robot] = 0.0

    def update(self, travels: FloatArray, yaws: FloatArray) -> None:
        """Update the odometry by a control period, in which each robot drove an arc."""
        turned = yaws - self._yaws
        chords = (travels - self._travels) * np.sinc(turned / (2.0 * np.pi))[:, None]
        headings = self._yaws + 0.5 * turned
        cos, sin = np.cos(headings), np.sin(headings)
        self._poses[:, 0] += chords[:, 0] * cos - chords[:, 1] * sin
        self._poses[:, 1] += chords[:, 0] * sin + chords[:, 1] * cos
        self._poses[:, 2] = yaws
        self._travels[:] = travels
        self._yaws[:] = yaws

    def readings(self, tick: int, twists: FloatArray) -> list[Odometry]:
        """Return the odometry of all robots."""
        return [
            Odometry(tick, Pose(x, y, wrap_angle(yaw)), Twist(vx, vy, wz))
            for (x, y, yaw), (vx, wz, vy) in zip(self._poses.tolist(), twists.tolist(), strict=True)
        ]
