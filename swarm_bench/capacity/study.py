"""Which runs come next, until all intervals are narrow or the time is up."""

from __future__ import annotations

import dataclasses
import math
import time
from collections.abc import Callable, Sequence

from rich.console import Console

from swarm_bench.capacity.axes import SweepVariant
from swarm_bench.capacity.curve import Curve, Point, curve_of
from swarm_bench.execution.executor import share_of
from swarm_bench.runs.episode import RunOptions
from swarm_bench.runs.result import FailedRun
from swarm_bench.suite.sweep import Outcome, RunSweep
from swarm_run.record.run_record import RunRecord

FIRST_SEEDS = 3  # of each size, before anything is refined
MOST_SEEDS = 50  # of each size
NEAR_KNEE = 0.1  # share of the knee to which the sizes around it close in


class Study:
    """The runs of all variants, sizes and seeds.

    Attributes:
        results: So far.
        failed: Runs without a result.
        planned: Cost of all runs that are planned so far: robots times simulated seconds.
        done: Cost of the runs that have ended.
    """

    def __init__(
        self,
        variants: Sequence[SweepVariant],
        sizes: Sequence[int],
        seeds: Sequence[int],
        *,
        precision: float | None = None,
        budget: float | None = None,
        shard: str | None = None,
    ) -> None:
        """Begin.

        Args:
            seeds: Seeds of each size; with precision or budget, further ones follow.
            precision: Half-width of intervals of throughput, as a share of it, at which no more
                seeds are added; None: exactly the sizes and seeds given.
            budget: Wall time [s] in which the study has to end; None for any.
            shard: Share of the runs, like 2/8; None for all.
        """
        self._variants = variants
        self._sizes = sorted(set(sizes))
        self._seeds = list(seeds)
        self._precision = precision
        self._shard = shard
        self._deadline = math.inf if budget is None else time.monotonic() + budget
        self.results: list[list[RunRecord]] = [[] for _ in variants]
        self.failed: list[FailedRun] = []
        self.planned = self.done = 0.0
        self._asked: set[tuple[int, int, int]] = set()  # variant, size, seed
        self._left = 0  # runs that were to come when the time was up

    @property
    def curves(self) -> list[Curve]:
        """A curve of each variant."""
        return [
            curve_of(variant.label, results)
            for variant, results in zip(self._variants, self.results, strict=True)
        ]

    @property
    def cut(self) -> str:
        """Words for the missing part of a sweep that was cut; empty if none is missing."""
        ended = len(self.failed) + sum(map(len, self.results))
        planned = len(self._asked) + self._left
        if ended < planned:
            return f"The sweep was cut: {ended} of {planned} planned runs have ended."
        return f"These are the runs of share {self._shard} only." if self._shard else ""

    @property
    def is_late(self) -> bool:
        """Whether the budget is used up."""
        return time.monotonic() >= self._deadline

    def all_runs(self) -> list[RunOptions]:
        """Return the runs that are asked for, as far as they are known before the first."""
        return self._options(self._first_round())

    def run(
        self,
        sweep: Callable[[Sequence[RunOptions]], RunSweep],
        console: Console,
        tell: Callable[[], None] = lambda: None,
    ) -> None:
        """Run until nothing is left to be refined, or the time is up.

        Args:
            sweep: Makes the sweep of a round.
            console: For a line per run.
        """
        todo = share_of(self._first_round(), self._shard)
        while todo and not self.is_late:
            self._asked.update(todo)
            options = self._options(todo)
            self.planned += sum(map(_cost, options))
            tell()
            self._round(sweep(options), [variant for variant, _, _ in todo], console, tell)
            todo = self._next_round()
        self._left = len(todo)

    def _round(
        self, sweep: RunSweep, places: Sequence[int], console: Console, tell: Callable[[], None]
    ) -> None:
        def watch(index: int, outcome: Outcome) -> bool:
            if isinstance(outcome, RunRecord):
                self.results[places[index]].append(outcome)
            else:
                self.failed.append(outcome)
            self.done += _cost(sweep.items[index])
            tell()
            return not self.is_late

        sweep.run(console, watch=watch)

    def _options(self, todo: Sequence[tuple[int, int, int]]) -> list[RunOptions]:
        return [
            dataclasses.replace(self._variants[variant].base, robots=size, seed=seed)
            for variant, size, seed in todo
        ]

    def _first_round(self) -> list[tuple[int, int, int]]:
        """Return the runs given; of an adaptive study those of the first seeds, seed by seed."""
        seeds = self._seeds if self._precision is None else self._seeds[:FIRST_SEEDS]
        return [
            (variant, size, seed)
            for seed in seeds
            for variant in range(len(self._variants))
            for size in self._sizes
        ]

    def _next_round(self) -> list[tuple[int, int, int]]:
        """Return what makes wide intervals narrow, and sizes that close in on the knee."""
        if self._precision is None:
            return []
        todo = []
        for variant, curve in enumerate(self.curves):
            for point in curve.points:
                todo += [(variant, point.robots, seed) for seed in self._more_seeds(point)]
            middles = self._around_knee(curve)
            first = self._seed_list(FIRST_SEEDS)
            todo += [(variant, size, seed) for size in middles for seed in first]
        return [one for one in dict.fromkeys(todo) if one not in self._asked]

    def _more_seeds(self, point: Point) -> list[int]:
        """Return the seeds of a size up to as many as its interval needs, at most twice as many."""
        wanted, count = self._precision or math.inf, len(point.runs)
        relative = point.throughput.relative
        if relative <= wanted or count >= MOST_SEEDS:
            return []
        needed = 2 * count
        if math.isfinite(relative):
            needed = min(needed, math.ceil(count * (relative / wanted) ** 2))
        return self._seed_list(min(MOST_SEEDS, max(count + 1, needed)))

    def _seed_list(self, count: int) -> list[int]:
        further = range(max(self._seeds) + 1, max(self._seeds) + 1 + count)
        return [*self._seeds, *further][:count]

    def _around_knee(self, curve: Curve) -> list[int]:
        """Return sizes in the middle between the knee and the sizes next to it."""
        knee = curve.knee
        if knee is None:
            return []
        below = max((size for size in curve.sizes if size < knee.robots), default=knee.robots)
        above = min((size for size in curve.sizes if size > knee.robots), default=knee.robots)
        if above - below <= max(2, round(NEAR_KNEE * knee.robots)):
            return []
        middles = {(below + knee.robots) // 2, knee.robots, -(-(above + knee.robots) // 2)}
        return sorted(middles - {below, above})


def _cost(options: RunOptions) -> float:
    return options.robots * options.scenario.limit_of(options.robots)
