"""Breaches in a run, with place and time: collisions and goals that are not reached."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import Annotated, Any

from msgspec import Meta

MISSED = "missed its goal: "  # begins what a robot says of itself that gave its goal up
SHOWN = 10  # breaches of a kind that the summary spells out
LARGEST = 10**12  # of numbers in reports, which somebody may have changed
Number = Annotated[float, Meta(ge=-float(LARGEST), le=float(LARGEST))]
Count = Annotated[int, Meta(ge=0, le=LARGEST)]


@dataclass(frozen=True, slots=True)
class Collision:
    """A contact episode, from the judge of the world to the report."""

    robots: tuple[str, ...]  # names of the one or two robots in it
    obstacle: str  # name of the object that the robot touched; empty if two robots met
    x: Number  # [m] in map, where it began
    y: Number  # [m] in map, where it began
    sim_time: Number  # [s] when it began

    @classmethod
    def from_json(cls, item: Mapping[str, Any]) -> Collision:
        """Return the episode in an item of a report or of a verdict."""
        place = (float(item["x"]), float(item["y"]))
        return cls(tuple(item["robots"]), item["obstacle"], *place, float(item["sim_time"]))

    def __str__(self) -> str:
        members = [*self.robots, *([self.obstacle] if self.obstacle else [])]
        place = f"({self.x:.2f}, {self.y:.2f})"
        return f"collision of {' and '.join(members)} at {place}, t = {self.sim_time:.1f} s"


@dataclass(frozen=True, slots=True)
class MissedGoal:
    """A goal that was given up."""

    robot: str  # its name
    goal: str  # name of the station or place
    sim_time: Number  # [s] when it was given up
    reason: str  # error code and message, as far as known

    def __str__(self) -> str:
        why = f": {self.reason}" if self.reason else ""
        return f"{self.robot} missed {self.goal} at t = {self.sim_time:.1f} s{why}"


@dataclass(frozen=True, slots=True)
class UnfinishedGoal:
    """A goal that a robot had not reached yet when the run ended."""

    robot: str  # its name
    goal: str  # name of the station or place; empty if no goal had been sent
    state: str  # of the robot, and what it waited for

    def __str__(self) -> str:
        return f"{self.robot} did not get to {self.goal or 'its goal'}: {self.state or 'silent'}"


def breaches_json(
    collisions: Sequence[Collision],
    missed: Sequence[MissedGoal],
    unfinished: Sequence[UnfinishedGoal],
) -> dict[str, Any]:
    """Return the `breaches` of a report.

    Args:
        unfinished: Goals that were under way at the end of the run, or never sent.
    """
    return {
        "collisions": [asdict(item) | {"robots": list(item.robots)} for item in collisions],
        "missed_goals": [asdict(item) for item in missed],
        "unfinished_goals": [asdict(item) for item in unfinished],
    }


def breach_lines(
    breaches: Mapping[str, Sequence[Mapping[str, Any]]], *, had_to_finish: bool
) -> list[str]:
    """Return the `breaches` of a report in words, the first of each kind.

    Args:
        had_to_finish: True if goals under way at the end of the run count as missed.
    """
    kinds: dict[str, list[Collision] | list[MissedGoal] | list[UnfinishedGoal]] = {
        "collisions": [Collision.from_json(item) for item in breaches["collisions"]],
        "missed goals": [MissedGoal(**item) for item in breaches["missed_goals"]],
    }
    if had_to_finish:
        unfinished = [UnfinishedGoal(**item) for item in breaches["unfinished_goals"]]
        kinds["unfinished goals"] = unfinished
    lines: list[str] = []
    for name, items in kinds.items():
        lines += shortened([str(item) for item in items], name)
    return lines


def broken_lines(report: Mapping[str, Any]) -> list[str]:
    """Return in words which robots of a run were broken from its start; nothing if none was."""
    names = report.get("broken") or []
    if not names:
        return []
    verb = "robot is" if len(names) == 1 else "robots are"
    return [f"{len(names)} {verb} broken: {', '.join(names)}"]


def recording_lines(report: Mapping[str, Any]) -> list[str]:
    """Return in words that a recording cannot be shown; nothing if it can."""
    missing = report.get("recording", {}).get("missing")
    return [f"the recording has no {', '.join(missing)}"] if missing else []


def shortened(lines: Sequence[str], kind: str) -> list[str]:
    """Return the first `SHOWN` lines, and one that says how many more of their kind there are."""
    if len(lines) <= SHOWN:
        return list(lines)
    return [*lines[:SHOWN], f"and {len(lines) - SHOWN} more {kind}; all are in the report"]
