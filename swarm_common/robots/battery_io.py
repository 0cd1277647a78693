"""Reading of a robot's battery: the section `battery:` of robot.yaml or of a fleet's group."""

from __future__ import annotations

import dataclasses
from typing import Any

from swarm_common.files.yaml_io import check_keys, number, numbers
from swarm_common.model.battery import BatterySpec
from swarm_common.model.errors import ConfigError, SwarmError

FIELDS = dataclasses.fields(BatterySpec)
KNOWN = tuple(item.name for item in FIELDS)
REQUIRED = tuple(item.name for item in FIELDS if item.default is dataclasses.MISSING)


def parse_battery(
    data: object,
    where: str,
    base: BatterySpec | None = None,
    error: type[SwarmError] = ConfigError,
) -> BatterySpec:
    """Return a battery; keys that are missing are those of `base`.

    Args:
        base: Battery of the robot's model; None if it has none.
    """
    if not isinstance(data, dict):
        raise error(f"{where} is {data!r}; expected {', '.join(REQUIRED)}")
    check_keys(data, KNOWN, where)
    missing = [name for name in REQUIRED if base is None and name not in data]
    if missing:
        raise error(f"{where} lacks {', '.join(missing)}")
    values: dict[str, Any] = {
        name: _share(value, f"{where}.{name}", error)
        if name == "initial"
        else number(value, f"{where}.{name}", error)
        for name, value in data.items()
    }
    try:
        return BatterySpec(**values) if base is None else dataclasses.replace(base, **values)
    except ConfigError as cause:
        raise error(f"{where}.{cause}") from None


def _share(value: object, what: str, error: type[SwarmError]) -> tuple[float, float]:
    """Return the least and the most of a share, which may be one number."""
    if isinstance(value, (list, tuple)):
        low, high = numbers(list(value), 2, what, error)
        return low, high
    share = number(value, what, error)
    return share, share
