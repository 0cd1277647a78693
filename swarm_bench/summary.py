"""Many runs of one scenario and size as one row."""

from __future__ import annotations

import statistics
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

from swarm_bench.result import RunResult


@dataclass(frozen=True, slots=True, kw_only=True)
class Row:
    """What the runs of one scenario, method and size have in common; counts are sums.

    Attributes:
        makespans: [s] of the complete runs, sorted.
        wait_worst: [s] that any robot waited in one run.
        min_clearance: [m] over all runs.
        min_held_gap: [m] over all runs.
        tick_us: [µs] median of the runs' medians.
    """

    name: str
    method: str
    robots: int
    runs: int
    collisions: int
    goals_reached: int
    goals_sent: int
    makespans: tuple[float, ...]
    deadlocks_resolved: int
    pushes: int
    retreats: int
    wait_worst: float
    min_clearance: float | None
    min_held_gap: float | None
    min_held_slack: float | None
    tick_us: float | None

    @property
    def is_flawless(self) -> bool:
        """Whether all goals were reached without a collision."""
        return self.collisions == 0 and self.goals_reached == self.goals_sent

    @property
    def makespan_text(self) -> str:
        """Median and range of the complete runs, and how many were not complete."""
        if not self.makespans:
            return "-"
        middle = statistics.median(self.makespans)
        text = f"{middle:.0f} [{self.makespans[0]:.0f}..{self.makespans[-1]:.0f}]"
        missing = self.runs - len(self.makespans)
        return f"{text}, {missing} incomplete" if missing else text


def summarise(results: Iterable[RunResult]) -> list[Row]:
    """Return a row per scenario, method, engine and size, in order of first appearance."""
    groups: dict[tuple[str, str, str, int, str], list[RunResult]] = {}
    for result in results:
        key = (
            result.scenario, result.method, result.engine, result.robots,
            repr(sorted(result.conditions.items())),
        )  # fmt: skip
        groups.setdefault(key, []).append(result)
    return [_row(group) for group in groups.values()]


def _row(runs: Sequence[RunResult]) -> Row:
    first = runs[0]
    return Row(
        name=first.scenario,
        method=first.method,
        robots=first.robots,
        runs=len(runs),
        collisions=sum(run.robot_robot + run.robot_world for run in runs),
        goals_reached=sum(run.goals_reached for run in runs),
        goals_sent=sum(run.goals_sent for run in runs),
        makespans=tuple(sorted(run.makespan for run in runs if run.makespan is not None)),
        deadlocks_resolved=sum(run.deadlocks_resolved or 0 for run in runs),
        pushes=sum(run.pushes or 0 for run in runs),
        retreats=sum(run.retreats or 0 for run in runs),
        wait_worst=max(run.wait_worst for run in runs),
        min_clearance=_least(run.min_clearance for run in runs),
        min_held_gap=_least(run.min_held_gap for run in runs),
        min_held_slack=_least(run.min_held_slack for run in runs),
        tick_us=_middle(run.tick_us_median for run in runs),
    )


def _least(values: Iterable[float | None]) -> float | None:
    return min((value for value in values if value is not None), default=None)


def _middle(values: Iterable[float | None]) -> float | None:
    known = [value for value in values if value is not None]
    return statistics.median(known) if known else None
