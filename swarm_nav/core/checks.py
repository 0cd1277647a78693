"""Checks of numbers in a configuration; each raises ConfigError naming the parameter."""

from __future__ import annotations

import math

from swarm_common.model.errors import ConfigError


def positive(owner: str, config: object, *names: str) -> None:
    """Refuse values that are not finite and positive.

    Args:
        owner: Prefix of the names in messages, like `planner.`; empty for none.

    Raises:
        ConfigError: Naming the first parameter that is refused.
    """
    for name in names:
        value = getattr(config, name)
        if not (math.isfinite(value) and value > 0):
            raise ConfigError(f"{owner}{name} is {value}; it must be positive")


def not_negative(owner: str, config: object, *names: str) -> None:
    """Refuse values that are not finite or are negative.

    Args:
        owner: Prefix of the names in messages, like `planner.`; empty for none.

    Raises:
        ConfigError: Naming the first parameter that is refused.
    """
    for name in names:
        value = getattr(config, name)
        if not (math.isfinite(value) and value >= 0):
            raise ConfigError(f"{owner}{name} is {value}; it must be 0 or more")


def at_most(owner: str, config: object, name: str, limit: float) -> None:
    """Refuse values above a limit.

    Args:
        owner: Prefix of the name in messages, like `planner.`; empty for none.
        name: Name of the attribute, which holds a number.

    Raises:
        ConfigError: Naming the parameter and the limit.
    """
    value = getattr(config, name)
    if value > limit:
        raise ConfigError(f"{owner}{name} is {value}; it must be at most {limit}")
