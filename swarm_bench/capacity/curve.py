"""The runs of one variant at all swarm sizes, as points with intervals."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from swarm_bench.capacity.knee import Knee, find_knee
from swarm_bench.statistics import Interval, mean_of_runs, student_mean
from swarm_run.record.figures import HOUR, Steady
from swarm_run.record.run_record import RunRecord

GROWS = 0.05  # share of the orders that came by which the backlog may grow; one order always may


@dataclass(frozen=True, slots=True)
class Demand:
    """Orders after the warm-up, in the mean of the runs."""

    came: float
    before: float  # orders that were open at the end of the warm-up
    after: float  # and at the end of the run

    @property
    def is_met(self) -> bool:
        """Whether the swarm does as many orders as come."""
        return self.after - self.before <= max(1.0, GROWS * self.came)


@dataclass
class Point:
    """The runs of one variant and size, each with another seed."""

    runs: tuple[RunRecord, ...]  # in the order of seeds

    @property
    def robots(self) -> int:
        """Swarm size."""
        return self.runs[0].robots

    @property
    def steady(self) -> list[Steady]:
        """Results after the warm-up, one per run that has them."""
        return [run.steady for run in self.runs if run.steady is not None]

    @cached_property
    def throughput(self) -> Interval:
        """Finished per hour."""
        per_batch = [
            [HOUR * count * len(run.finished) / run.seconds for count in run.finished]
            for run in self.steady
        ]
        return mean_of_runs([run.per_hour for run in self.steady], per_batch)

    @cached_property
    def demand(self) -> Demand | None:
        """Orders that came and that were left; None for goals, which robots give themselves."""
        found = [_open_orders(run) for run in self.runs if run.orders and run.steady]
        return Demand(*np.mean(found, axis=0).tolist()) if found else None

    @cached_property
    def lead_time(self) -> Interval | None:
        """Lead time [s]; None if a run finished nothing, without an interval if it grows."""
        if any(run.lead_time is None for run in self.steady):
            return None
        if self.demand is not None and not self.demand.is_met:
            return Interval(float(np.mean([run.lead_time for run in self.steady])))
        batches = [
            [lead for lead, count in zip(run.lead_times, run.finished, strict=True) if count]
            for run in self.steady
        ]
        return mean_of_runs([run.lead_time or 0.0 for run in self.steady], batches)

    @cached_property
    def stood(self) -> Interval | None:
        """Share of the robots' time that they stood on their way; None on the ROS graph."""
        found = [run.ground_truth.stood_share for run in self.runs if run.ground_truth]
        return student_mean(found) if found else None

    def station_use(self) -> dict[str, Interval]:
        """Return the share of time that each station was occupied or approached, most first."""
        shares: dict[str, list[float]] = {}
        for run in self.runs:
            for name, use in (run.ground_truth.stations if run.ground_truth else {}).items():
                shares.setdefault(name, []).append(use.approached)
        found = {name: student_mean(values) for name, values in shares.items()}
        return dict(sorted(found.items(), key=lambda item: -item[1].estimate))

    @property
    def clearance(self) -> float | None:
        """Smallest distance [m] of any robot from anything in any run."""
        known = [run.min_clearance for run in self.runs if run.min_clearance is not None]
        return min(known, default=None)

    @property
    def collisions(self) -> int:
        """Contact episodes in all runs."""
        return sum(run.robot_robot + run.robot_world for run in self.runs)

    @property
    def deadlocks(self) -> int | None:
        """Deadlocks in all runs, as the simulator sees them; None on the ROS graph."""
        found = [run.ground_truth.deadlocks for run in self.runs if run.ground_truth]
        return sum(found) if found else None


@dataclass
class Curve:
    """A variant at all sizes."""

    label: str  # how it differs from the other variants; empty if there is no other
    points: tuple[Point, ...] = field(default=())  # by size

    @property
    def sizes(self) -> list[int]:
        """The swarm sizes."""
        return [point.robots for point in self.points]

    @cached_property
    def knee(self) -> Knee | None:
        """Where more robots bring little more."""
        return find_knee(self.sizes, [point.throughput for point in self.points])

    @property
    def unit(self) -> str:
        """Unit that throughput counts, like goals."""
        return next((run.unit for point in self.points for run in point.steady), "goals")


def _open_orders(run: RunRecord) -> tuple[int, int, int]:
    """Return how many orders came after the warm-up, and how many were open before and after."""
    assert run.orders is not None
    assert run.steady is not None
    begin, end = run.steady.warm_up, run.steady.warm_up + run.steady.seconds
    times = [
        (one["created"], math.inf if one["done"] is None else one["done"])
        for one in run.orders["orders"]
    ]
    before, after = (sum(born <= t < done for born, done in times) for t in (begin, end))
    return sum(begin < born <= end for born, _ in times), before, after


def curve_of(label: str, results: Iterable[RunRecord]) -> Curve:
    """Return the curve of a variant.

    Args:
        results: Results of runs of fixed duration.
    """
    by_size: dict[int, list[RunRecord]] = {}
    for result in results:
        if result.steady is not None:
            by_size.setdefault(result.robots, []).append(result)
    return Curve(label, tuple(Point(_by_seed(by_size[size])) for size in sorted(by_size)))


def _by_seed(runs: Sequence[RunRecord]) -> tuple[RunRecord, ...]:
    return tuple(sorted(runs, key=lambda run: run.seed))
