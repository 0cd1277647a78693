"""Rounds of runs and learning, and what the lanes gain on seeds that they were not made on."""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
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
Throughput = dict[str, dict[int, float]]  # [1/h] by mission and seed


@dataclass(frozen=True, slots=True)
class Candidate:
    """Lanes of one round.

    Attributes:
        costs: (h, w) extra cost per metre.
        throughput: With them.
    """

    costs: FloatArray
    throughput: Throughput

    def gain_on(self, first: Candidate) -> float:
        """Return the throughput as a share of another's, the mean over missions."""
        shares = [
            sum(mine.values()) / max(1e-9, sum(first.throughput[mission].values()))
            for mission, mine in self.throughput.items()
        ]
        return float(np.mean(shares))


@dataclass(frozen=True, slots=True)
class Gain:
    """Gain of lanes on held-out seeds.

    Attributes:
        without: Throughput without lanes.
        with_lanes: Throughput with them.
        contacts: Contacts with them.
    """

    without: Throughput
    with_lanes: Throughput
    contacts: int

    def of(self, mission: str) -> Paired:
        """Return throughput [1/h] with lanes less that without, of one mission."""
        return paired(self.with_lanes[mission], self.without[mission])


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
    """Makes lanes for one world and swarm size, and for one mission or some.

    Attributes:
        rounds: What was tried, first no lanes.
        setup: The world.
        missions: The missions.
    """

    def __init__(self, options: Sequence[RunOptions], executor: Executor, folder: Path) -> None:
        """Read the inputs.

        Args:
            options: A run to be learned from for each mission; the seed does not count.
            folder: Where lanes under trial are written.

        Raises:
            SwarmError: If a file or a value is unusable.
        """
        self.rounds: list[Candidate] = []
        self._options, self._executor, self._folder = options, executor, folder
        prepared = [prepare(_with_lanes(each, NO_LANES)) for each in options]
        self.setup = prepared[0][0]
        self.missions = [mission for _, mission in prepared if mission is not None]

    def train(self, seeds: Sequence[int], rounds: int, tell: Callable[[Candidate], None]) -> Grid:
        """Learn in some rounds; return the lanes of the best one, all 0 where none is better.

        Each round's lanes are the mean of those before and what was lost with them, of all missions
        alike.
        """
        configs = [nav_config(self._options[0], spec) for spec in self.setup.specs]
        speed = float(np.mean([config.controller.max_vel_x for config in configs]))
        resolution = self.setup.grid.resolution
        costs = np.zeros(self.setup.grid.cells.shape)
        for number in range(rounds + 1):
            runs = self._run(self._write(costs, number), seeds)
            self.rounds.append(Candidate(costs, _throughput(runs)))
            tell(self.rounds[-1])
            of_missions = [
                lost_time(list(of_seeds.values()), speed, resolution) for of_seeds in runs.values()
            ]
            lost = WEIGHT * np.mean(of_missions, axis=0)
            costs = lost if number == 0 else 0.5 * (costs + lost)
        best = max(self.rounds, key=lambda tried: tried.gain_on(self.rounds[0]))
        return lanes_of(best.costs, self.setup.grid)

    def compare(self, lanes: Path, seeds: Sequence[int]) -> Gain:
        """Return what lanes gain on seeds that they were not made on."""
        without, runs = self._run(NO_LANES, seeds), self._run(str(lanes), seeds)
        contacts = sum(run.contacts for of_seeds in runs.values() for run in of_seeds.values())
        return Gain(_throughput(without), _throughput(runs), contacts)

    def _write(self, costs: FloatArray, number: int) -> str:
        if not costs.any():
            return NO_LANES
        path = self._folder / f"round_{number}.yaml"
        save_mask(lanes_of(costs, self.setup.grid), path)
        return str(path)

    def _run(self, lanes: str, seeds: Sequence[int]) -> dict[str, dict[int, Traffic]]:
        """Return the traffic of all runs by mission and seed."""
        items = [
            replace(_with_lanes(options, lanes), seed=seed)
            for options in self._options
            for seed in seeds
        ]
        found: dict[str, dict[int, Traffic]] = {
            options.scenario.mission: {} for options in self._options
        }
        with contextlib.closing(self._executor.run(watch, items, None)) as ended:
            for done in ended:
                item = items[done.index]
                mission = item.scenario.mission
                if done.error:
                    raise ConfigError(f"mission {mission}, seed {item.seed}: {done.error}")
                found[mission][item.seed] = done.value
        return {mission: dict(sorted(of_seeds.items())) for mission, of_seeds in found.items()}


def _throughput(runs: Mapping[str, Mapping[int, Traffic]]) -> Throughput:
    return {
        mission: {seed: run.throughput for seed, run in of_seeds.items()}
        for mission, of_seeds in runs.items()
    }


def _with_lanes(options: RunOptions, lanes: str) -> RunOptions:
    """Return the run with other lanes: a file, or `NO_LANES`."""
    return replace(options, scenario=replace(options.scenario, lanes=lanes))
