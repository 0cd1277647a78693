"""Reading of a robot's battery: the section `battery:` of robot.yaml or of a fleet's group."""

from __future__ import annotations

import dataclasses

from swarm_common.files.yaml_io import field_values, number, numbers
from swarm_common.model.battery import BatterySpec
from swarm_common.model.errors import ConfigError, SwarmError


def parse_battery(
    data: object,
    where: str,
    base: BatterySpec | None = None,
    error: type[SwarmError] = ConfigError,
) -> BatterySpec:
    """Return a battery; keys that are missing are those of `base`, that of the robot's model."""

    def share(value: object, what: str) -> tuple[float, float]:
        """Return the least and the most of a share, which may be one number."""
        if isinstance(value, (list, tuple)):
            low, high = numbers(list(value), 2, what, error)
            return low, high
        return (number(value, what, error),) * 2

    values = field_values(
        BatterySpec, data, where, error, readers={"initial": share}, may_lack=base is not None
    )
    try:
        return BatterySpec(**values) if base is None else dataclasses.replace(base, **values)
    except ConfigError as cause:
        raise error(f"{where}.{cause}") from None
