"""Errors of a robot's sensors: the section `sensors:` of robot.yaml, all zero if ideal.

A value that is called bias or scale is the standard deviation over robots of an error that each
robot keeps for a whole run; the others describe noise that is drawn independently for every
reading.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Annotated, Literal

from msgspec import Meta

from swarm_common.model.schema import NotNegative

SensorShare = Annotated[float, Meta(ge=0.0, le=0.5)]  # of the measured value


@dataclass(frozen=True, slots=True, kw_only=True)
class LidarErrors:
    """Errors of a LiDAR, beside `sigma` of its section `lidar:`; `sensors.lidar`."""

    sigma_share: SensorShare = 0.0  # standard deviation of a range, as a share of it
    dropout: SensorShare = 0.0  # share of the rays that measure nothing (NaN)
    ray_time: bool = False  # each ray at its own time of the revolution, the last one at the stamp


@dataclass(frozen=True, slots=True, kw_only=True)
class OdometryErrors:
    """Errors of the odometry from wheels; `sensors.odometry`."""

    heading: Literal["gyro", "wheels"] = "gyro"  # what it comes from: gyro | wheels
    wheel_bias: SensorShare = 0.0  # of the radius of each side's wheels, as a share of it
    separation_bias: SensorShare = 0.0  # of the distance between the sides, as a share of it
    slip: NotNegative = 0.0  # [m] of each side after a metre; grows with the root of the way


@dataclass(frozen=True, slots=True, kw_only=True)
class ImuErrors:
    """Errors of gyro and accelerometer; `sensors.imu`."""

    gyro_noise: NotNegative = 0.0  # [rad/s/√Hz]
    gyro_bias: NotNegative = 0.0  # [rad/s] that is left after the calibration at rest
    gyro_scale: SensorShare = 0.0  # of the turning rate, as a share of it
    accel_noise: NotNegative = 0.0  # [m/s²/√Hz]
    accel_bias: NotNegative = 0.0  # [m/s²]


@dataclass(frozen=True, slots=True, kw_only=True)
class SensorErrors:
    """All of one robot's."""

    lidar: LidarErrors = field(default_factory=LidarErrors)
    odometry: OdometryErrors = field(default_factory=OdometryErrors)
    imu: ImuErrors = field(default_factory=ImuErrors)


IDEAL = SensorErrors()
