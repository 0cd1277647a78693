"""The checked input of `swarm-up --role robots`."""

from __future__ import annotations

import os
import socket
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from swarm_common.middleware.addresses import address_of, address_towards, own_address
from swarm_common.middleware.dds_profile import MOST_PROCESSES, check_environment
from swarm_common.middleware.secret import FILE_VARIABLE, VARIABLE
from swarm_common.model.errors import ConfigError
from swarm_run.domain import domain_id
from swarm_run.host_options import parse_robots
from swarm_run.packing import parse_pack
from swarm_run.spec import RunSpec

# On the robots' side: own options, and what may be stated of the world's side to be compared.
OWN = frozenset({"role", "robots", "connect", "bind", "pack", "run_dir", "headless"})
OWN |= {"over_limit", "restart"}
STATED = frozenset({"world", "seed", "robot", "swarm_size"})


@dataclass(frozen=True, slots=True, kw_only=True)
class RobotsPlan:
    """The checked input of a robots' host."""

    robots: tuple[int, ...]  # numbers of those that it is to serve
    pack: int  # navigators per process
    own_address: str  # address to bind to
    world_address: str  # of the world's host
    domain: int  # ROS domain
    label: str  # name and address of this host, for people
    secret: str = field(repr=False)  # that this host shares with the world's
    # options of the user about the run, to be compared; see `RunDescription.facts`
    stated: Mapping[str, Any] = field(default_factory=dict)
    run_dir: str | None = None  # --run-dir
    restart: bool = True  # whether navigators that died are restarted

    @property
    def processes(self) -> int:
        """Number of processes that the navigators share."""
        return -(-len(self.robots) // self.pack)


def robots_plan(spec: RunSpec, stated: Mapping[str, Any], secret: str) -> RobotsPlan:
    """Return the plan of a robots' host.

    Args:
        spec: Its numbers of robots, address of the world's host, and own address; None for that
            on the way there.
        stated: Every option that was typed, by its name.
        secret: Secret that the user gave; empty for none.

    Raises:
        ConfigError: For the first thing that is wrong with the input.
    """
    connect, robots = spec.connect or "", spec.robots or ""
    for name in stated:
        if name not in OWN | STATED:
            flag = name.replace("_", "-")
            raise ConfigError(f"--{flag} belongs to the world's host: give it with --role world")
    check_environment(os.environ)
    if not secret:
        raise ConfigError(
            f"--role robots needs the secret of the world's host in {VARIABLE}, or in a file that"
            f" {FILE_VARIABLE} names; swarm-up --role world shows it"
        )
    world_address = address_of(connect)
    own = own_address(spec.bind) if spec.bind is not None else address_towards(world_address)
    numbers = parse_robots(robots)
    plan = RobotsPlan(
        robots=numbers,
        pack=parse_pack(spec.pack, len(numbers), MOST_PROCESSES),
        own_address=own,
        world_address=world_address,
        domain=domain_id(),
        label=f"{socket.gethostname()} ({own})",
        secret=secret,
        stated={name: value for name, value in stated.items() if name in STATED},
        run_dir=spec.run_dir,
        restart=spec.restart,
    )
    if plan.processes > MOST_PROCESSES:
        least = -(-len(plan.robots) // MOST_PROCESSES)
        raise ConfigError(
            f"--robots {robots} makes {plan.processes} processes; one host can have"
            f" {MOST_PROCESSES} of them in DDS: put several robots in each with --pack {least},"
            " or use more hosts"
        )
    return plan
