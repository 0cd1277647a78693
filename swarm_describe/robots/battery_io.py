"""Reading of a robot's battery: the section `battery:` of robot.yaml or of a fleet's group."""

from __future__ import annotations

import dataclasses

from swarm_common.files.convert import convert, over
from swarm_common.model.battery import BatterySpec
from swarm_common.model.errors import ConfigError, SwarmError


def parse_battery(
    data: object,
    where: str,
    base: BatterySpec | None = None,
    error: type[SwarmError] = ConfigError,
) -> BatterySpec:
    """Return a battery; keys that are missing are those of `base`, that of the robot's model."""
    if isinstance(data, dict) and isinstance(data.get("initial"), int | float):
        data = data | {"initial": [data["initial"]] * 2}
    known = {} if base is None else dataclasses.asdict(base)
    return convert(over(known, data), BatterySpec, where, error)
