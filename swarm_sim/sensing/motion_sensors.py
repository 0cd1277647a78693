"""Wheel encoders and IMUs of all robots: their readings of a motion, with errors."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from swarm_common.model.records import CONTROL_PERIOD, FloatArray, RobotSpec
from swarm_common.model.sensors import IDEAL, SensorErrors
from swarm_sim.scene.randomness import hash_words, normal

GRAVITY = 9.81  # [m/s²]
# What a random number is for.
SIDE_WORD, SEPARATION_WORD, SLIP_WORD, GYRO_WORD, SCALE_WORD, NOISE_WORD, ACCEL_WORD = range(
    211, 218
)

# Arrays that change as robots move, a row each.
STATE = (
    "_true_travels", "_true_yaws", "_travels", "_yaws", "_imu_yaws", "_imu_rates", "_twists",
    "_accelerations",
)  # fmt: skip


@dataclass(frozen=True, slots=True)
class Imu:
    """Reading of an IMU at a tick, in the robot's axes."""

    tick: int  # of the reading
    yaw: float  # [rad] integrated since the start
    yaw_rate: float  # [rad/s]
    acceleration: tuple[float, float, float]  # x, y, z [m/s²], gravity included


class MotionSensors:
    """Turns true motions into reported ones; without errors these are the true ones, bit by bit."""

    def __init__(
        self, specs: Sequence[RobotSpec], errors: Sequence[SensorErrors], seed: int
    ) -> None:
        """Draw the errors that each robot keeps for the whole run."""
        count = len(specs)
        robots = np.arange(count)
        self._seed = seed
        self._robots = robots
        self._has_errors = any(item != IDEAL for item in errors)
        odometry, imus = [item.odometry for item in errors], [item.imu for item in errors]
        sides = np.array([item.wheel_bias for item in odometry])[:, None]
        self._side_scales = 1.0 + sides * self._draw(SIDE_WORD, robots[:, None], np.arange(2))
        widths = np.array([item.separation_bias for item in odometry])
        self._width_scales = 1.0 + widths * self._draw(SEPARATION_WORD, robots)
        self._widths = np.array([spec.wheel_separation for spec in specs])
        self._slips = np.array([item.slip for item in odometry])
        self._by_wheels = np.array([item.heading == "wheels" for item in odometry], np.bool_)
        self._gyro_biases = np.array([i.gyro_bias for i in imus]) * self._draw(GYRO_WORD, robots)
        scales = np.array([item.gyro_scale for item in imus])
        self._gyro_scales = 1.0 + scales * self._draw(SCALE_WORD, robots)
        self._gyro_noises = np.array([item.gyro_noise for item in imus])
        accel_biases = np.array([item.accel_bias for item in imus])[:, None]
        self._accel_biases = accel_biases * self._draw(ACCEL_WORD, robots[:, None], np.arange(3))
        self._accel_noises = np.array([item.accel_noise for item in imus])
        self._true_travels, self._true_yaws = np.zeros((count, 2)), np.zeros(count)
        self._travels, self._yaws = np.zeros((count, 2)), np.zeros(count)
        self._imu_yaws, self._imu_rates = np.zeros(count), np.zeros(count)
        self._twists, self._accelerations = np.zeros((count, 3)), np.zeros((count, 2))

    def extended(
        self,
        specs: Sequence[RobotSpec],
        errors: Sequence[SensorErrors],
        travels: FloatArray,
        yaws: FloatArray,
    ) -> MotionSensors:
        """Return these sensors, as they are now, followed by those of further robots."""
        longer = MotionSensors(specs, errors, self._seed)
        known = len(self._robots)
        for name in STATE:
            getattr(longer, name)[:known] = getattr(self, name)
        if not self._has_errors:
            longer._true_travels[:known] = longer._travels[:known] = travels
            longer._true_yaws[:known] = longer._yaws[:known] = yaws
        return longer

    def restart(self, robot: int) -> None:
        """Restart the readings of a robot's wheels and gyro at 0."""
        for name in STATE:
            getattr(self, name)[robot] = 0.0

    def update(
        self, tick: int, travels: FloatArray, yaws: FloatArray, twists: FloatArray
    ) -> tuple[FloatArray, FloatArray]:
        """Update the sensors by a control period.

        Args:
            travels: (n, 2) [m] forwards and to the left, as perfect wheels report it.
            twists: (n, 3) true vx, wz, vy at the end of the period.

        Returns:
            Way (n, 2) [m] forwards and to the left, and heading (n,) [rad], not wrapped. Without
            errors these are the arguments; with errors both arrays are reused by the next call.
        """
        self._accelerate(twists)
        if not self._has_errors:
            self._imu_yaws[:], self._imu_rates[:] = yaws, twists[:, 1]
            return travels, yaws
        ways, turned = travels - self._true_travels, yaws - self._true_yaws
        self._true_travels[:], self._true_yaws[:] = travels, yaws
        half = self._widths / 2.0
        sides = ways[:, :1] + np.array([-1.0, 1.0]) * (half * turned)[:, None]
        slips = self._draw(SLIP_WORD, tick, self._robots[:, None], np.arange(2))
        slipped = self._slips[:, None] * np.sqrt(np.abs(sides)) * slips
        sides = sides * self._side_scales + slipped
        self._travels[:, 0] += sides.mean(axis=1)
        self._travels[:, 1] += ways[:, 1] * self._side_scales.mean(axis=1)
        wheel_turns = (sides[:, 1] - sides[:, 0]) / (self._widths * self._width_scales)
        noises = self._gyro_noises * self._draw(NOISE_WORD, tick, self._robots)
        errors = self._gyro_biases * CONTROL_PERIOD + noises * np.sqrt(CONTROL_PERIOD)
        gyro_turns = turned * self._gyro_scales + errors
        self._imu_yaws += gyro_turns
        self._imu_rates[:] = twists[:, 1] * self._gyro_scales + errors / CONTROL_PERIOD
        self._yaws += np.where(self._by_wheels, wheel_turns, gyro_turns)
        return self._travels, self._yaws

    def twists(self, true: FloatArray) -> FloatArray:
        """Return the twists that odometry reports.

        Returns:
            (n, 3) likewise; `true` itself without errors.
        """
        if not self._has_errors:
            return true
        sides = true[:, :1] + np.array([-1.0, 1.0]) * (self._widths / 2.0 * true[:, 1])[:, None]
        sides *= self._side_scales
        by_wheels = (sides[:, 1] - sides[:, 0]) / (self._widths * self._width_scales)
        rates = np.where(self._by_wheels, by_wheels, self._imu_rates)
        return np.column_stack(
            [sides.mean(axis=1), rates, true[:, 2] * self._side_scales.mean(axis=1)]
        )

    def imu(self, robot: int, tick: int) -> Imu:
        """Return the reading of one robot's IMU."""
        noises = self._draw(ACCEL_WORD, tick, robot, np.arange(3))
        noise = self._accel_noises[robot] / np.sqrt(CONTROL_PERIOD) * noises
        x, y, z = (
            np.array([*self._accelerations[robot], GRAVITY]) + self._accel_biases[robot] + noise
        ).tolist()
        return Imu(tick, float(self._imu_yaws[robot]), float(self._imu_rates[robot]), (x, y, z))

    def _accelerate(self, twists: FloatArray) -> None:
        changes = (twists - self._twists) / CONTROL_PERIOD
        self._accelerations[:, 0] = changes[:, 0] - twists[:, 1] * twists[:, 2]
        self._accelerations[:, 1] = changes[:, 2] + twists[:, 1] * twists[:, 0]
        self._twists[:] = twists

    def _draw(self, *coordinates: int | NDArray[np.int64]) -> FloatArray:
        return normal(hash_words(self._seed, *coordinates))
