"""Completions by TAB: robots and stations of the latest run here, subcommands.

Nothing is asked of a running swarm: a shell must not wait for DDS.
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from swarm_common.files.run_folders import LATEST, RUNS
from swarm_common.model.robot_names import FLEET_COMMANDS


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
