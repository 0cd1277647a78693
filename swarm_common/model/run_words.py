"""Words that terminal and report.html share about a run, from the fields of report.json."""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import Any

_NAMED = re.compile(r"for (\w+)[,:]")  # as `announcement` of swarm_nav says it
_SERVED = re.compile(r"makes way for (\w+)")
MOST_LOST = 5  # topics in a line
OPEN = "goals are open"  # instead of a makespan
SERIES_FIELDS = (  # of report.json, worked out from the time series
    "stations", "throughput", "state_shares", "bottleneck", "headline", "lost", "ideal_times",
    "longest_stop", "waited_for",
)  # fmt: skip


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


def duration_text(seconds: float) -> str:
    """Return a long time in its largest unit."""
    for unit, length in (("years", 31_557_600.0), ("days", 86_400.0), ("h", 3600.0), ("min", 60.0)):
        if seconds >= length:
            return f"{seconds / length:.1f} {unit}"
    return f"{seconds:.1f} s"


def lost_text(lost: Mapping[str, int]) -> str:
    """Return how many messages a recording lacks, and of which topics; empty if it lacks none."""
    if not lost:
        return ""
    most = sorted(lost.items(), key=lambda item: -item[1])
    topics = [f"{count} of {topic}" for topic, count in most[:MOST_LOST]]
    more = [f"others of {len(most) - MOST_LOST} topics"] if len(most) > MOST_LOST else []
    return f"the recording lacks {sum(lost.values())} messages: {', '.join([*topics, *more])}"


def waits_for(state: str, detail: str) -> str:
    """Return the name of the robot that a status says to wait for, empty for none.

    Making way for a robot is not waiting for it.
    """
    text = detail if state == "waiting" else detail.partition("waits ")[2]
    found = _NAMED.match(text)
    return found[1] if found is not None else ""


def stopped_by(state: str, detail: str) -> str:
    """Return the name of the robot that a status says to wait for or to make way for."""
    served = _SERVED.match(detail)
    return waits_for(state, detail) or (served[1] if served is not None else "")
