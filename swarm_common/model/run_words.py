"""What terminal and report.html say of a run alike, from the fields of report.json."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

OPEN = "goals are open"  # instead of a makespan


def makespan(report: Mapping[str, Any]) -> float | None:
    """Return the time [s] in which all goals were settled; None if some are open or none was."""
    value: float | None = report.get("makespan")
    return None if report.get("goals", {}).get("pending") else value


def robots_text(report: Mapping[str, Any]) -> str:
    """Return how many robots the run began with, and how many came."""
    size = report["swarm_size"]
    came = max(0, len(report.get("robots") or ()) - size)
    text = f"{size} robot{'' if size == 1 else 's'}"
    return f"{text} and {came} that came" if came else text
