"""Reading of a robot's sensor errors: the section `sensors:` of robot.yaml, checked."""

from __future__ import annotations

import dataclasses

from swarm_common.files.convert import convert, over
from swarm_common.model.errors import ConfigError, SwarmError
from swarm_common.model.sensors import IDEAL, SensorErrors


def sensor_errors(
    data: object,
    where: str,
    base: SensorErrors = IDEAL,
    error: type[SwarmError] = ConfigError,
) -> SensorErrors:
    """Return `base` with the values that a tree of keys overrides."""
    return convert(over(dataclasses.asdict(base), data), SensorErrors, where, error)
