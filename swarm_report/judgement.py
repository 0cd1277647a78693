"""The verdict on a run in words: good, bad, or open if it ended too early to say."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import msgspec

from swarm_common.model.breaches import broken_lines, recording_lines
from swarm_report.run import RunData, mission_goals
from swarm_run.record.run_record import Breaches

SHOWN = 12  # breaches in the verdict; the table below has all


@dataclass(frozen=True, slots=True)
class Judgement:
    """The verdict: `kind` is good, bad or open; `lines` say why."""

    kind: str
    headline: str
    lines: tuple[str, ...]


def judge(run: RunData) -> Judgement:
    """Return the verdict on a run."""
    report = run.report
    if not report:
        line = "the run has left no report.json: it was killed, or still goes on"
        return Judgement("open", "No verdict", (line, *_so_far(run)))
    broken = tuple(broken_lines(report))
    failures = [*report.get("failures", []), *recording_lines(report)]
    lines = [*broken, *failures, *breach_lines(report)]
    goals, crashes = report["goals"], report["collisions"]
    collided = (crashes["robot_robot"] or 0) + (crashes["robot_world"] or 0)
    total = _count(mission_goals(report), "goal")
    head = f"{goals['reached']} of {total} reached, {_count(collided, 'collision')}"
    code = report.get("exit_code")
    if collided or goals["failed"] or code in (1, 3) or failures:
        return Judgement("bad", f"Failed: {head}", _cut(lines))
    if goals["pending"]:
        return Judgement("open", f"Stopped early: {head}", broken)
    return Judgement("good", f"Passed: {head}", broken)


def breach_lines(report: Mapping[str, Any]) -> list[str]:
    """Return each collision and each missed goal in words."""
    found = msgspec.convert(report.get("breaches", {}), Breaches)
    unfinished = found.unfinished_goals if report.get("exit_code") == 1 else ()
    return [str(breach) for breach in (*found.collisions, *found.missed_goals, *unfinished)]


def _so_far(run: RunData) -> list[str]:
    reached = sum(event.outcome == "reached" for event in run.goals)
    failed = sum(event.outcome == "failed" for event in run.goals)
    return [
        f"known until t = {run.end:.1f} s: {_count(reached, 'goal')} reached, {failed} missed;"
        " collisions are not known"
    ]


def _count(number: int, noun: str) -> str:
    return f"{number or 'no'} {noun}{'' if number == 1 else 's'}"


def _cut(lines: list[str]) -> tuple[str, ...]:
    if len(lines) <= SHOWN:
        return tuple(lines)
    return (*lines[:SHOWN], f"and {len(lines) - SHOWN} more, listed below")
