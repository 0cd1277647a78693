"""Finds the machine's own `ros2`, which is better than ours where it exists."""

from __future__ import annotations

import os
from collections.abc import Mapping
from pathlib import Path

MARKER = b"swarm_ros2"  # in the script that pip writes for our entry point


def find_real_ros2(environ: Mapping[str, str]) -> Path | None:
    """Return the first `ros2` on PATH that is not this one."""
    for folder in environ.get("PATH", "").split(os.pathsep):
        candidate = Path(folder or ".") / "ros2"
        if os.access(candidate, os.X_OK) and candidate.is_file() and not _is_ours(candidate):
            return candidate
    return None


def clean_environment(environ: Mapping[str, str], prefix: Path) -> dict[str, str]:
    """Return the environment without what the ROS 2 wheels put there at start-up.

    The libraries of this environment must not get in the way of those of the real ROS 2.
    """
    cleaned = dict(environ)
    cleaned.pop("_ROS_WHEELS_BOOTSTRAP_COMPLETE", None)
    folders = cleaned.pop("LD_LIBRARY_PATH", "").split(os.pathsep)
    kept = [folder for folder in folders if folder and not Path(folder).is_relative_to(prefix)]
    if kept:
        cleaned["LD_LIBRARY_PATH"] = os.pathsep.join(kept)
    return cleaned


def _is_ours(script: Path) -> bool:
    try:
        with script.open("rb") as file:
            return MARKER in file.read(4096)
    except OSError:
        return True
