"""What is wrong with a robot's sensors: the section `sensors:` of robot.yaml, all zero if ideal.

A value that is called bias or scale is the standard deviation over robots of an error that each
robot keeps for a whole run; the others describe noise that is drawn anew for every reading.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from swarm_common.errors import ConfigError, SwarmError
from swarm_common.yaml_io import check_keys, number

HEADINGS = ("gyro", "wheels")
MOST_SHARE = 0.5  # of what is measured, by which a sensor may be off
Unchecked = Mapping[str, Any]


@dataclass(frozen=True, slots=True, kw_only=True)
class LidarErrors:
    """Of a LiDAR, beside `sigma` of its section `lidar:`; `sensors.lidar`."""

    sigma_share: float = 0.0  # standard deviation of a range, as a share of it
    dropout: float = 0.0  # share of the rays that measure nothing (NaN)
    ray_time: bool = False  # each ray at its own time of the revolution, the last one at the stamp


@dataclass(frozen=True, slots=True, kw_only=True)
class OdometryErrors:
    """Of what wheels tell; `sensors.odometry`."""

    heading: str = "gyro"  # what it comes from: gyro | wheels
    wheel_bias: float = 0.0  # of the radius of each side's wheels, as a share of it
    separation_bias: float = 0.0  # of the distance between the sides, as a share of it
    slip: float = 0.0  # [m] of each side after a metre; grows with the root of the way


@dataclass(frozen=True, slots=True, kw_only=True)
class ImuErrors:
    """Of gyro and accelerometer; `sensors.imu`."""

    gyro_noise: float = 0.0  # [rad/s/√Hz]
    gyro_bias: float = 0.0  # [rad/s] that is left after the calibration at rest
    gyro_scale: float = 0.0  # of the turning rate, as a share of it
    accel_noise: float = 0.0  # [m/s²/√Hz]
    accel_bias: float = 0.0  # [m/s²]


@dataclass(frozen=True, slots=True, kw_only=True)
class SensorErrors:
    """All of one robot's."""

    lidar: LidarErrors = field(default_factory=LidarErrors)
    odometry: OdometryErrors = field(default_factory=OdometryErrors)
    imu: ImuErrors = field(default_factory=ImuErrors)


IDEAL = SensorErrors()
_SHARES = ("sigma_share", "dropout", "wheel_bias", "separation_bias", "gyro_scale")


def sensor_errors(
    data: object,
    where: str,
    base: SensorErrors = IDEAL,
    error: type[SwarmError] = ConfigError,
) -> SensorErrors:
    """Return `base` with what a tree of keys says in its place.

    Args:
        data: Groups of keys, as in robot.yaml; it is checked.
        where: For messages.
        base: What holds where nothing is said.
        error: Class of the exception to raise.

    Raises:
        SwarmError: If a key is unknown or a value impossible.
    """
    groups = _mapping(data, where, error)
    check_keys(dict(groups), [item.name for item in dataclasses.fields(SensorErrors)], where)
    changed: dict[str, Any] = {}
    for name, content in groups.items():
        old = getattr(base, name)
        values = _mapping(content, f"{where}.{name}", error)
        check_keys(dict(values), [f.name for f in dataclasses.fields(old)], f"{where}.{name}")
        changed[name] = dataclasses.replace(
            old,
            **{
                key: _checked(key, value, getattr(old, key), f"{where}.{name}.{key}", error)
                for key, value in values.items()
            },
        )
    return dataclasses.replace(base, **changed)


def _mapping(data: object, where: str, error: type[SwarmError]) -> Unchecked:
    if not isinstance(data, Mapping):
        raise error(f"{where} is {data!r}; expected 'key: value' lines")
    return data


def _checked(key: str, value: object, old: object, what: str, error: type[SwarmError]) -> object:
    if isinstance(old, bool):
        if not isinstance(value, bool):
            raise error(f"{what} is {value!r}; expected true or false")
        return value
    if isinstance(old, str):
        if value not in HEADINGS:
            raise error(f"{what} is {value!r}; expected {' or '.join(HEADINGS)}")
        return value
    result = number(value, what, error)
    most = MOST_SHARE if key in _SHARES else math.inf
    if not 0.0 <= result <= most:
        limits = f"from 0 to {most}" if math.isfinite(most) else "0 or more"
        raise error(f"{what} is {result}; it must be {limits}")
    return result
