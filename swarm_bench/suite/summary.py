"""Many runs of one scenario and size as one row."""

from __future__ import annotations

import statistics
from collections.abc import Iterable
from dataclasses import dataclass

from swarm_bench.runs.episode import RunOptions
from swarm_bench.runs.methods import OF_NAVIGATORS
from swarm_bench.runs.result_builder import conditions
from swarm_bench.runs.scenario import Scenario, Target, load_scenario, scenario_names
from swarm_bench.statistics import bootstrap_mean
from swarm_run.record.run_record import RunRecord


@dataclass(frozen=True, slots=True)
class Row:
    """The runs of one scenario, method, engine, size and set of conditions."""

    runs: tuple[RunRecord, ...]  # at least one, in order of seeds
    scenario: Scenario | None  # as shipped; None for one of the user's

    @property
    def first(self) -> RunRecord:
        """The first run; used for the properties that all runs share."""
        return self.runs[0]

    @property
    def label(self) -> str:
        """Name of the scenario, and what was other than it says."""
        changes = [
            f"{name} {value:g}" if _is_number(value) else f"{name} {value}"
            for name, value in self._changes()
        ]
        return ", ".join([self.first.scenario, *changes])

    def _changes(self) -> list[tuple[str, object]]:
        if self.scenario is None:
            return []
        usual = conditions(RunOptions(scenario=self.scenario, robots=self.first.robots))
        return [
            (name, value)
            for name, value in self.first.conditions.items()
            if usual.get(name) != value and name != "lidar"
        ]

    @property
    def collisions(self) -> int:
        """Contact episodes of any kind."""
        return sum(run.robot_robot + run.robot_world for run in self.runs)

    @property
    def collisions_text(self) -> str:
        """Contact episodes between robots + with the environment."""
        return f"{self.total('robot_robot')}+{self.total('robot_world')}"

    @property
    def deadlocks_text(self) -> str:
        """Deadlocks that the simulator saw; - where it did not look."""
        seen = [run.ground_truth.deadlocks for run in self.runs if run.ground_truth is not None]
        return str(sum(seen)) if seen else "-"

    @property
    def goals_sent(self) -> int:
        """Goals asked for."""
        return sum(run.goals_sent for run in self.runs)

    @property
    def goals_reached(self) -> int:
        """Goals reached in time."""
        return sum(run.goals_reached for run in self.runs)

    @property
    def goals_text(self) -> str:
        """Goals reached, of those asked for."""
        return f"{self.goals_reached}/{self.goals_sent}"

    @property
    def is_flawless(self) -> bool:
        """Whether each run was."""
        return all(run.is_flawless for run in self.runs)

    @property
    def makespans(self) -> list[float]:
        """Makespans of the complete runs [s], sorted."""
        return sorted(run.makespan for run in self.runs if run.makespan is not None)

    @property
    def makespan_median(self) -> float | None:
        """Median makespan of the complete runs [s]; None if none is complete."""
        return statistics.median(self.makespans) if self.makespans else None

    @property
    def makespan_text(self) -> str:
        """Median and range of the complete runs, and how many were not complete."""
        known = self.makespans
        if not known:
            return "-"
        text = f"{statistics.median(known):.0f} [{known[0]:.0f}..{known[-1]:.0f}]"
        missing = len(self.runs) - len(known)
        return f"{text}, {missing} incomplete" if missing else text

    @property
    def mean_text(self) -> str:
        """Mean of the complete runs' makespans, with its interval if there are several."""
        known = self.makespans
        if not known:
            return "-"
        mean = bootstrap_mean(known)
        ends = f" [{mean.low:.0f}..{mean.high:.0f}]" if mean.is_known else ""
        return f"{mean.estimate:.0f}{ends}"

    @property
    def target_text(self) -> str:
        """Target of the scenario for the median makespan, and whether it is met."""
        targets = self.scenario.targets if self.scenario else {}
        target, median = targets.get(self.first.robots, Target()), self.makespan_median
        if target.release is None:
            return "-"
        text = f"≤ {target.release:.0f}"
        if target.stretch is not None:
            text += f", stretch {target.stretch:.0f}"
        if median is None or median > target.release:
            return f"{text}: missed"
        is_stretched = target.stretch is not None and median <= target.stretch
        return f"{text}: {'stretch met' if is_stretched else 'met'}"

    @property
    def worst_wait(self) -> float | None:
        """Longest that a robot waited and held [s]; None for methods that do not count it."""
        worst = self.most("wait_worst")
        return worst if worst or self.first.method in OF_NAVIGATORS else None

    @property
    def wait_ratio(self) -> float | None:
        """Worst over median wait of a run's robots, in the median of the runs."""
        ratios = [run.wait_worst / run.wait_median for run in self.runs if run.wait_median]
        return statistics.median(ratios) if ratios else None

    def total(self, name: str) -> int:
        """Return the sum of a counter over the runs.

        Args:
            name: A field of `RunRecord`; None counts as 0.
        """
        return sum(getattr(run, name) or 0 for run in self.runs)

    def least(self, name: str) -> float | None:
        """Return the smallest value of a field in any run, None if no run has one.

        Args:
            name: A field of `RunRecord`.
        """
        return min(self._values(name), default=None)

    def most(self, name: str) -> float | None:
        """Return the largest value of a field in any run, None if no run has one."""
        return max(self._values(name), default=None)

    def median(self, name: str) -> float | None:
        """Return the median over the runs of a field, None if no run has one."""
        values = self._values(name)
        return statistics.median(values) if values else None

    def _values(self, name: str) -> list[float]:
        values = [getattr(run, name) for run in self.runs]
        return [value for value in values if value is not None]


def summarise(results: Iterable[RunRecord]) -> list[Row]:
    """Return a row per scenario, method, engine, size and conditions, in order of appearance."""
    groups: dict[tuple[object, ...], list[RunRecord]] = {}
    for result in results:
        key = (
            result.scenario,
            result.method,
            result.engine,
            result.robots,
            tuple(sorted(result.conditions.items())),
        )
        groups.setdefault(key, []).append(result)
    known = {name: load_scenario(name) for name in scenario_names()}
    return [
        Row(tuple(sorted(runs, key=lambda run: run.seed)), known.get(runs[0].scenario))
        for runs in groups.values()
    ]


def _is_number(value: object) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool)
