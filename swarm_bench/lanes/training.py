"""Rounds of runs and learning, and what the lanes gain on seeds that they were not made on."""

from __future__ import annotations

import contextlib
import dataclasses
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from swarm_bench.execution.task import Executor
from swarm_bench.lanes.learning import Traffic, lanes_of, lost_time
from swarm_bench.runs.episode import RunOptions, build, nav_config, prepare
from swarm_bench.runs.harness import Harness
from swarm_bench.statistics import Paired, paired
from swarm_common.files.map_io import save_mask
from swarm_common.model.errors import ConfigError
from swarm_common.model.grid import Grid
from swarm_common.model.records import CONTROL_PERIOD, FloatArray
from swarm_run.spec import NO_LANES

WEIGHT = 0.9  # extra cost per metre of a place where robots lose the free driving time once


@dataclass(frozen=True, slots=True)
class Candidate:
    """Lanes of one round.

    Attributes:
        costs: (h, w) extra cost per metre.
        throughput: [1/h] with them, by training seed.
    """

    costs: FloatArray
    throughput: dict[int, float]

    @property
    def mean(self) -> float:
        """Mean throughput [1/h]."""
        return float(np.mean(list(self.throughput.values())))


@dataclass(frozen=True, slots=True)
class Gain:
    """Gain of lanes on held-out seeds.

    Attributes:
        without: [1/h] without lanes, by seed.
        with_lanes: [1/h] with them.
        contacts: Contacts with them.
        difference: The second less the first.
    """

    without: dict[int, float]
    with_lanes: dict[int, float]
    contacts: int
    difference: Paired


class _Counter:
    """Counts where robots are, and how far they drive, once the warm-up is over."""

    def __init__(self, grid: Grid, warm_up: float) -> None:
        self._grid, self._first = grid, round(warm_up / CONTROL_PERIOD)
        self._last: FloatArray | None = None
        self.seconds, self.metres = np.zeros(grid.cells.shape), np.zeros(grid.cells.shape)
        self.hours = 0.0

    def look(self, tick: int, poses: FloatArray) -> None:
        """Count one tick.

        Args:
            poses: (n, 3) x, y [m], yaw [rad] in map.
        """
        places, last = poses[:, :2].copy(), self._last
        self._last = places
        if tick < self._first or last is None or len(last) != len(places):
            return
        grid = self._grid
        columns, rows = np.floor(
            (places - (grid.origin_x, grid.origin_y)) / grid.resolution
        ).T.astype(np.int64)
        is_on = (rows >= 0) & (rows < grid.height) & (columns >= 0) & (columns < grid.width)
        at = rows[is_on], columns[is_on]
        np.add.at(self.seconds, at, CONTROL_PERIOD)
        np.add.at(self.metres, at, np.hypot(*(places - last)[is_on].T))
        self.hours += len(places) * CONTROL_PERIOD / 3600.0


def watch(options: RunOptions) -> Traffic:
    """Run a scenario once, and return where its robots lost time."""
    episode = build(options)
    counter = _Counter(episode.setup.grid, options.scenario.warm_up)
    harness = Harness(
        options, episode=episode, on_tick=lambda world, *_: counter.look(world.tick, world.poses)
    )
    record = harness.run()
    assert record.steady is not None  # a run with a duration
    return Traffic(
        record.steady.per_hour,
        record.robot_robot + record.robot_world,
        counter.hours,
        counter.seconds,
        counter.metres,
    )


class Training:
    """Makes lanes for one world, mission and swarm size.

    Attributes:
        rounds: What was tried, first no lanes.
    """

    def __init__(self, options: RunOptions, executor: Executor, folder: Path) -> None:
        """Read the inputs.

        Args:
            options: Run to be learned from; its seed does not count.
            folder: Where lanes under trial are written.

        Raises:
            SwarmError: If a file or a value is unusable.
        """
        self.rounds: list[Candidate] = []
        self._options, self._executor, self._folder = options, executor, folder
        self.setup, self.mission = prepare(self.with_lanes(NO_LANES))

    def with_lanes(self, lanes: str) -> RunOptions:
        """Return the run with other lanes: a file, or `NO_LANES`."""
        scenario = dataclasses.replace(self._options.scenario, lanes=lanes)
        return dataclasses.replace(self._options, scenario=scenario)

    def train(self, seeds: Sequence[int], rounds: int, tell: Callable[[Candidate], None]) -> Grid:
        """Learn in some rounds; return the lanes of the best one, all 0 where none is better.

        Each round's lanes are the mean of those before and what was lost with them.
        """
        configs = [nav_config(self._options, spec) for spec in self.setup.specs]
        speed = float(np.mean([config.controller.max_vel_x for config in configs]))
        costs = np.zeros(self.setup.grid.cells.shape)
        for number in range(rounds + 1):
            runs = self._run(self._write(costs, number), seeds)
            throughput = {seed: run.throughput for seed, run in zip(seeds, runs, strict=True)}
            self.rounds.append(Candidate(costs, throughput))
            tell(self.rounds[-1])
            lost = WEIGHT * lost_time(runs, speed, self.setup.grid.resolution)
            costs = lost if number == 0 else 0.5 * (costs + lost)
        return lanes_of(max(self.rounds, key=lambda tried: tried.mean).costs, self.setup.grid)

    def compare(self, lanes: Path, seeds: Sequence[int]) -> Gain:
        """Return what lanes gain on seeds that they were not made on."""
        without, runs = self._run(NO_LANES, seeds), self._run(str(lanes), seeds)
        first, second = (
            {seed: run.throughput for seed, run in zip(seeds, each, strict=True)}
            for each in (without, runs)
        )
        contacts = sum(run.contacts for run in runs)
        return Gain(first, second, contacts, paired(second, first))

    def _write(self, costs: FloatArray, number: int) -> str:
        if not costs.any():
            return NO_LANES
        path = self._folder / f"round_{number}.yaml"
        save_mask(lanes_of(costs, self.setup.grid), path)
        return str(path)

    def _run(self, lanes: str, seeds: Sequence[int]) -> list[Traffic]:
        options = self.with_lanes(lanes)
        items = [dataclasses.replace(options, seed=seed) for seed in seeds]
        found: dict[int, Traffic] = {}
        with contextlib.closing(self._executor.run(watch, items, None)) as ended:
            for done in ended:
                if done.error:
                    raise ConfigError(f"seed {items[done.index].seed}: {done.error}")
                found[done.index] = done.value
        return [found[index] for index in range(len(items))]
