"""Reading of a robot's sensor errors: the section `sensors:` of robot.yaml, checked."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping
from typing import Any

from swarm_common.files.yaml_io import check_keys, number
from swarm_common.model.errors import ConfigError, SwarmError
from swarm_common.model.sensors import IDEAL, SensorErrors

HEADINGS = ("gyro", "wheels")
MOST_SHARE = 0.5  # of the measured value, by which a sensor may be off
_SHARES = ("sigma_share", "dropout", "wheel_bias", "separation_bias", "gyro_scale")
Unchecked = Mapping[str, Any]


def sensor_errors(
    data: object,
    where: str,
    base: SensorErrors = IDEAL,
    error: type[SwarmError] = ConfigError,
) -> SensorErrors:
    """Return `base` with the values that a tree of keys overrides.

    Args:
        base: Values of the keys that are missing.
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
