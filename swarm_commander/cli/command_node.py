"""The node of a command that works with a running swarm, and completions by TAB.

Completions are read from the latest run here; nothing is asked of a running swarm: a shell must
not wait for DDS.
"""

from __future__ import annotations

import json
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import rclpy
from rclpy.node import Node

from swarm_common.files.resources import LATEST, RUNS
from swarm_common.middleware.rclpy_compat import join_graph
from swarm_common.model.robot_names import FLEET_COMMANDS
from swarm_run.domain import check_swarm, domain_id


@contextmanager
def command_node(name: str) -> Iterator[Node]:
    """Join the graph of a running swarm; at its end the command gives its robots back.

    Raises:
        NoSwarmError: If there is no swarm.
    """
    check_swarm(domain_id())
    node = join_graph(name)
    try:
        yield node
    finally:
        node.destroy_node()
        rclpy.try_shutdown()


def robots() -> list[str]:
    """Return the robots of the latest run."""
    return [str(robot["name"]) for robot in _world().get("robots", [])]


def stations() -> list[str]:
    """Return the stations of the latest run."""
    from swarm_common.files.sites_io import load_sites

    path = _world().get("sites")
    return list(load_sites(Path(path)).stations) if path else []


def first_words() -> list[str]:
    """Return what may follow `swarm-commander`."""
    return [*robots(), *FLEET_COMMANDS]


def _world() -> dict[str, Any]:
    try:
        content = json.loads((RUNS / LATEST / "config" / "world.json").read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return {}
    return content if isinstance(content, dict) else {}
