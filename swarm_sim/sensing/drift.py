"""Uncertainty of a robot's odometry, by the error model from which its readings are drawn."""

from __future__ import annotations

from swarm_common.model.records import CONTROL_PERIOD, RobotSpec, Twist
from swarm_common.model.sensors import SensorErrors

LEAST = 1e-9  # [m²], [rad²], ... of odometry that does not err: filters take 0 for unknown
Variances = tuple[float, float, float]


class Drift:
    """Variances of the odometry of one robot since it began.

    The biases are those of robots of this model, as no robot knows its own. They grow with the way
    and the net turn, slip and noise of the gyro with their roots. Across the way the error is that
    of the heading, which is spread over both axes.
    """

    def __init__(self, errors: SensorErrors, spec: RobotSpec) -> None:
        """Begin with odometry that is right."""
        self._odometry, self._imu = errors.odometry, errors.imu
        self._width = spec.wheel_separation
        self._way = self._turn = self._time = 0.0
        self.of_twist: Variances = (LEAST, LEAST, LEAST)

    def add(self, twist: Twist) -> None:
        """Record the twist of a control period."""
        speed = abs(twist.vx) + abs(twist.vy)
        self._way += speed * CONTROL_PERIOD
        self._turn += twist.wz * CONTROL_PERIOD
        self._time += CONTROL_PERIOD
        along = self._along(speed, 0.0)
        turning = self._turning(twist.wz, (speed, 0.0), (1.0, 1.0 / CONTROL_PERIOD))
        self.of_twist = (LEAST + along, LEAST + along, LEAST + turning)

    @property
    def of_pose(self) -> Variances:
        """Variances of x, y [m²] and yaw [rad²]."""
        yaw = self._turning(self._turn, (self._way, self._way), (self._time, self._time))
        place = LEAST + self._along(self._way, self._way) + yaw * self._way**2 / 3.0
        return place, place, LEAST + yaw

    def _along(self, way: float, slipped: float) -> float:
        """Return the variance of the mean of both sides' ways; `slipped` is the way with slip."""
        bias = self._odometry.wheel_bias * way
        return 0.5 * (bias * bias + self._odometry.slip**2 * slipped)

    def _turning(self, turn: float, ways: tuple[float, float], times: tuple[float, float]) -> float:
        """Variance of a turn, from wheels or gyro.

        Args:
            ways: [m] with the biases of the wheels, and with slip.
            times: [s] with the bias of the gyro, and with its noise.
        """
        odometry, imu = self._odometry, self._imu
        if odometry.heading == "wheels":
            sides = 2.0 * ((odometry.wheel_bias * ways[0]) ** 2 + odometry.slip**2 * ways[1])
            return (odometry.separation_bias * turn) ** 2 + sides / self._width**2
        gyro = (imu.gyro_bias * times[0]) ** 2 + (imu.gyro_scale * turn) ** 2
        return gyro + imu.gyro_noise**2 * times[1]
