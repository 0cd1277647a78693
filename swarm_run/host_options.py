"""Options of a run on several hosts, checked once: --role, --robots, --connect, --bind."""

from __future__ import annotations

from enum import StrEnum

from swarm_common.middleware.addresses import own_addresses
from swarm_common.model.errors import ConfigError

MOST = 1000  # highest number of a robot


class Role(StrEnum):
    """Role of a host of a swarm."""

    WORLD = "world"
    ROBOTS = "robots"


def check_combination(
    role: Role | None, robots: str | None, connect: str | None, bind: str | None
) -> None:
    """Refuse options that do not go together.

    Raises:
        ConfigError: For the first mistake.
    """
    if role is None:
        for flag, value in (("--robots", robots), ("--connect", connect), ("--bind", bind)):
            if value is not None:
                raise ConfigError(f"{flag} is for several hosts; it needs --role world or robots")
    elif role is Role.WORLD:
        for flag, value in (("--robots", robots), ("--connect", connect)):
            if value is not None:
                raise ConfigError(f"{flag} belongs to the robots' hosts: --role robots")
        if bind is None:
            listed = ", ".join(f"{a} ({interface})" for a, interface in own_addresses().items())
            raise ConfigError(
                "--role world needs --bind with the address that the robots' hosts reach;"
                f" this host has {listed}"
            )
    elif robots is None or connect is None:
        missing = "--robots, like 1-50" if robots is None else "--connect with the world's host"
        raise ConfigError(f"--role robots needs {missing}")


def parse_robots(text: str) -> tuple[int, ...]:
    """Return the numbers that --robots means, like 1-50 or 1-3,7.

    Raises:
        ConfigError: If it is not a list of numbers and ranges.
    """
    numbers: set[int] = set()
    for part in text.split(","):
        first, dash, last = part.strip().partition("-")
        low, high = first.strip(), last.strip() if dash else first.strip()
        if not (low.isdecimal() and high.isdecimal() and 1 <= int(low) <= int(high) <= MOST):
            raise ConfigError(
                f"--robots is '{text}'; expected numbers from 1 to {MOST}, like 1-50 or 1-3,7"
            )
        numbers.update(range(int(low), int(high) + 1))
    return tuple(sorted(numbers))
