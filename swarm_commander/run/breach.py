"""What must not happen, with place and time, as records and in words: contacts and missed goals."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import Any

SHOWN = 10  # breaches of a kind that the summary spells out


@dataclass(frozen=True, slots=True)
class Crash:
    """A contact episode, as the world saw it.

    Attributes:
        robots: The one or two robots in it.
        obstacle: What the one robot touched; empty if two robots met.
        x: [m] in map.
        y: [m] in map.
        sim_time: [s] at which it began.
    """

    robots: tuple[str, ...]
    obstacle: str
    x: float
    y: float
    sim_time: float

    @classmethod
    def of(cls, event: Mapping[str, Any]) -> Crash:
        """Return the episode in an event, or in the world's verdict."""
        place = (float(event["x"]), float(event["y"]))
        return cls(tuple(event["robots"]), event["obstacle"], *place, float(event["sim_time"]))

    def __str__(self) -> str:
        members = [*self.robots, *([self.obstacle] if self.obstacle else [])]
        place = f"({self.x:.2f}, {self.y:.2f})"
        return f"collision of {' and '.join(members)} at {place}, t = {self.sim_time:.1f} s"


@dataclass(frozen=True, slots=True)
class Miss:
    """A goal that was given up.

    Attributes:
        robot: Whose.
        goal: Name of the station or place.
        sim_time: [s] at which it was given up.
        reason: Error code and message, as far as known.
    """

    robot: str
    goal: str
    sim_time: float
    reason: str

    @classmethod
    def of(cls, event: Mapping[str, Any]) -> Miss:
        """Return the miss in an event about a goal."""
        return cls(event["robot"], event["name"], float(event["sim_time"]), event["reason"])

    def __str__(self) -> str:
        why = f": {self.reason}" if self.reason else ""
        return f"{self.robot} missed {self.goal} at t = {self.sim_time:.1f} s{why}"


@dataclass(frozen=True, slots=True)
class Unfinished:
    """A robot that was still under way to a goal when the run ended.

    Attributes:
        robot: Name.
        goal: Where to; empty if no goal had been sent.
        state: Its state, and whom or what it waited for.
    """

    robot: str
    goal: str
    state: str

    def __str__(self) -> str:
        return f"{self.robot} did not get to {self.goal or 'its goal'}: {self.state or 'silent'}"


def as_json(
    crashes: Sequence[Crash], misses: Sequence[Miss], unfinished: Sequence[Unfinished]
) -> dict[str, Any]:
    """Return the `breaches` of a report."""
    return {
        "collisions": [asdict(crash) | {"robots": list(crash.robots)} for crash in crashes],
        "missed_goals": [asdict(miss) for miss in misses],
        "unfinished_goals": [asdict(rest) for rest in unfinished],
    }


def breach_lines(
    breaches: Mapping[str, Sequence[Mapping[str, Any]]], *, had_to_finish: bool
) -> list[str]:
    """Return the `breaches` of a report in words, the first of each kind.

    Args:
        breaches: Of the report.
        had_to_finish: Whether goals under way at the end of the run count as missed.
    """
    kinds: dict[str, list[Crash] | list[Miss] | list[Unfinished]] = {
        "collisions": [Crash.of(item) for item in breaches["collisions"]],
        "missed goals": [Miss(**item) for item in breaches["missed_goals"]],
    }
    if had_to_finish:
        kinds["unfinished goals"] = [Unfinished(**item) for item in breaches["unfinished_goals"]]
    lines: list[str] = []
    for name, items in kinds.items():
        lines += shortened([str(item) for item in items], name)
    return lines


def shortened(lines: Sequence[str], kind: str) -> list[str]:
    """Return the first lines, and how many more of their kind there are."""
    if len(lines) <= SHOWN:
        return list(lines)
    return [*lines[:SHOWN], f"and {len(lines) - SHOWN} more {kind}; all are in the report"]
