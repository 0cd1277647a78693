"""Number of navigators that share a process."""

from __future__ import annotations

import os

from swarm_common.middleware.ros_env import MOST_PARTICIPANTS, TERMINALS, participants_of
from swarm_common.model.errors import ConfigError

AUTO = "auto"
ROBOTS_PER_CORE = 10  # up to which each navigator has a process of its own, with `AUTO`


def most_processes(robots: int) -> int:
    """Return the number of navigator processes that DDS has ids for on one host."""
    return MOST_PARTICIPANTS - TERMINALS - participants_of(robots, 0)


def parse_pack(text: str | int | None, robots: int, most: int, cores: int | None = None) -> int:
    """Return --pack as a number of navigators per process.

    `auto` gives each navigator its own process while there are few for this machine, and beyond
    that each core one process: a tick ends with the last answer, so more processes only wait.

    Args:
        text: Text that was typed, None for a process each.
        most: Processes that DDS has ids for.
        cores: Processors that this process may use; None asks the system.

    Raises:
        ConfigError: If it is neither `auto` nor a positive integer.
    """
    if text is None:
        return 1
    if text == AUTO:
        cores = cores or len(os.sched_getaffinity(0))
        processes = robots if robots <= ROBOTS_PER_CORE * cores else cores
        return -(-robots // max(1, min(processes, most)))
    try:
        pack = int(text)
    except ValueError:
        pack = 0
    if pack < 1:
        raise ConfigError(f"--pack is '{text}'; expected {AUTO} or a positive integer like 10")
    return pack
