"""Reading of a robot's sensor errors: the section `sensors:` of robot.yaml, checked."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping
from typing import Any

from swarm_common.files.yaml_io import check_keys, field_values
from swarm_common.model.errors import ConfigError, SwarmError
from swarm_common.model.sensors import IDEAL, SensorErrors

HEADINGS = ("gyro", "wheels")
MOST_SHARE = 0.5  # of the measured value, by which a sensor may be off
_SHARES = ("sigma_share", "dropout", "wheel_bias", "separation_bias", "gyro_scale")


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

    def heading(value: object, what: str) -> object:
        if value not in HEADINGS:
            raise error(f"{what} is {value!r}; expected {' or '.join(HEADINGS)}")
        return value

    if not isinstance(data, Mapping):
        raise error(f"{where} is {data!r}; expected 'key: value' lines")
    check_keys(dict(data), [item.name for item in dataclasses.fields(SensorErrors)], where)
    changed: dict[str, Any] = {}
    for name, content in data.items():
        old = getattr(base, name)
        values = field_values(
            type(old), content, f"{where}.{name}", error, readers={"heading": heading}
        )
        for key, value in values.items():
            most = MOST_SHARE if key in _SHARES else math.inf
            if key != "heading" and not 0.0 <= value <= most:
                limits = f"from 0 to {most}" if math.isfinite(most) else "0 or more"
                raise error(f"{where}.{name}.{key} is {value}; it must be {limits}")
        changed[name] = dataclasses.replace(old, **values)
    return dataclasses.replace(base, **changed)
