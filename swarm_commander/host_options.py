"""Options of a run on several hosts, checked once: --role, --robots, --connect, --bind."""

from __future__ import annotations

import os
import socket
from collections.abc import Mapping
from enum import StrEnum
from pathlib import Path
from typing import Any

from swarm_commander.domain import domain_id
from swarm_commander.robots_run import RobotsPlan
from swarm_common.addresses import address_of, address_towards, own_address, own_addresses
from swarm_common.dds_profile import MOST_PROCESSES, check_environment
from swarm_common.errors import ConfigError

MOST = 1000  # highest number of a robot


class Role(StrEnum):
    """What a host of a swarm is there for."""

    WORLD = "world"
    ROBOTS = "robots"


# On the robots' side: own options, and what may be stated of the world's side to be compared.
OWN = frozenset({"role", "robots", "connect", "bind", "pack", "run_dir", "headless", "over_limit"})
STATED = frozenset({"world", "seed", "robot", "swarm_size"})


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


def robots_plan(
    robots: str,
    connect: str,
    bind: str | None,
    pack: int,
    run_dir: Path | None,
    typed: Mapping[str, Any],
) -> RobotsPlan:
    """Return the plan of a robots' host.

    Args:
        robots: As typed.
        connect: Name or address of the world's host.
        bind: Own address or interface; None for the one on the way there.
        pack: Navigators per process.
        run_dir: --run-dir.
        typed: Every option that was typed, by its name.

    Raises:
        ConfigError: For the first thing that is wrong with the input.
    """  # fmt: skip
    for name in typed:
        if name not in OWN | STATED:
            flag = name.strip("_").replace("_", "-")
            raise ConfigError(f"--{flag} belongs to the world's host: give it with --role world")
    if pack < 1:
        raise ConfigError(f"--pack is {pack}; it must be 1 or more")
    check_environment(os.environ)
    world_address = address_of(connect)
    own = own_address(bind) if bind is not None else address_towards(world_address)
    plan = RobotsPlan(
        robots=parse_robots(robots),
        pack=pack,
        own_address=own,
        world_address=world_address,
        domain=domain_id(),
        label=f"{socket.gethostname()} ({own})",
        stated={name: value for name, value in typed.items() if name in STATED},
        run_dir=run_dir,
    )
    if plan.processes > MOST_PROCESSES:
        least = -(-len(plan.robots) // MOST_PROCESSES)
        raise ConfigError(
            f"--robots {robots} makes {plan.processes} processes; one host can have"
            f" {MOST_PROCESSES} of them in DDS: put several robots in each with --pack {least},"
            " or use more hosts"
        )
    return plan


def parse_robots(text: str) -> tuple[str, ...]:
    """Return the names that --robots means, like 1-50 or 1-3,7.

    Raises:
        ConfigError: If it is no list of numbers and ranges.
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
    return tuple(f"Srobot{number}" for number in sorted(numbers))
