"""One run of the study with its faults."""

from __future__ import annotations

import contextlib
import importlib
import time
from collections.abc import Iterator, Sequence
from typing import Any

from swarm_bench.runs.episode import RunOptions, build
from swarm_bench.runs.harness import Harness
from swarm_bench.runs.origin import bench_edition
from swarm_bench.study.bounds import least_makespan
from swarm_bench.study.experiments import Settings, StudyRun, is_constant, settings_text
from swarm_bench.study.lines import STEP, StudyLine
from swarm_common.model.beacon import BEACON_SIZE
from swarm_common.model.errors import WorldError
from swarm_common.model.records import CONTROL_PERIOD
from swarm_common.model.shapes import Box, Part, transform_from_xyz_rpy
from swarm_describe.worlds.scene import Body
from swarm_run.loop import InjectedFaults
from swarm_run.record.run_record import RunRecord
from swarm_sim.world.changing_world import ChangingWorld
from swarm_sim.world.object_placement import check_object_place
from swarm_sim.world.world import World

HEIGHT = 1.0  # [m] of a box in the way
BASELINES = "swarm_bench.baselines"


def run_one(item: tuple[StudyRun, RunOptions]) -> StudyLine:
    """Run once.

    Args:
        item: A run and its options, for which files were read where the command runs.

    Raises:
        SwarmError: If a file or a value is unusable.
    """
    started = time.process_time()
    run, options = item
    cell = run.cell
    with _constants(run.settings):
        episode = build(options, world_class=ChangingWorld if cell.blocked else World)
        is_lifelong = options.scenario.duration > 0.0
        bound = None if cell.dead or is_lifelong else least_makespan(options, episode)
        if episode.centre is not None and cell.outage:
            first, end = cell.span()
            episode.centre.outage = first, end - 1
        harness = _BlockedHarness if cell.blocked else Harness
        result = harness(options, episode=episode, faults=run.faults(), **_box(run)).run()
    centre, steady = result.centre, result.steady
    radio = BEACON_SIZE / CONTROL_PERIOD
    if centre is not None:
        radio = centre["bytes_up_per_robot_second"] + centre["bytes_down_per_robot_second"]
    created, done = _orders(result)
    return StudyLine(
        experiment=run.experiment,
        cell=cell.name,
        method=run.method,
        seed=run.seed,
        settings=settings_text(run.settings),
        edition=bench_edition(),
        goals_sent=result.goals_sent,
        goals_reached=result.goals_reached,
        robot_robot=result.robot_robot,
        robot_world=result.robot_world,
        makespan=None if result.makespan is None else round(result.makespan, 1),
        stopped=options.scenario.limit_of(cell.robots),
        bound=None if bound is None else round(bound, 1),
        per_hour=None if steady is None else round(steady.per_hour, 1),
        lead_time=None if steady is None or not steady.lead_time else round(steady.lead_time, 1),
        batches=None if steady is None else list(steady.finished),
        created=created,
        done=done,
        cpu=round(time.process_time() - started, 1),
        sim_time=result.sim_time,
        cpu_ms_per_robot_second=round(result.cpu_ms_per_robot_second or 0.0, 3),
        tick_us_p99=None if result.tick_us_p99 is None else round(result.tick_us_p99, 1),
        longest_decision_ms=None if centre is None else round(centre["longest_decision_ms"], 1),
        bytes_per_robot_second=round(radio, 1),
        trajectory_sha256=result.trajectory_sha256,
    )


def _orders(result: RunRecord) -> tuple[list[int] | None, list[int] | None]:
    """Return how many orders came and were done in each `STEP` of the run."""
    if result.orders is None:
        return None, None
    counts = []
    for field in ("created", "done"):
        times = [record[field] for record in result.orders["orders"]]
        bins = [0] * (int(result.sim_time / STEP) + 1)
        for at in times:
            if at is not None:
                bins[int(at / STEP)] += 1
        counts.append(bins)
    return counts[0], counts[1]


@contextlib.contextmanager
def _constants(settings: Settings) -> Iterator[None]:
    """Set constants of baselines, like orca.HORIZON, for one run."""
    with contextlib.ExitStack() as stack:
        for name, value in settings:
            if is_constant(name):
                module, _, constant = name.rpartition(".")
                place = importlib.import_module(f"{BASELINES}.{module}")
                stack.callback(setattr, place, constant, getattr(place, constant))
                setattr(place, constant, value)
        yield


def _box(run: StudyRun) -> dict[str, Any]:
    if not run.cell.blocked:
        return {}
    return {"box": run.cell.blocked, "first": run.cell.span()[0], "end": run.cell.span()[1]}


class _BlockedHarness(Harness):
    """A run in which a box stands in the way for a time, from when there is room for it."""

    def __init__(
        self,
        options: Any,
        *,
        episode: Any,
        faults: InjectedFaults,
        box: Sequence[float],
        first: int,
        end: int,
    ) -> None:
        super().__init__(options, episode=episode, faults=faults)
        x, y, width, depth = box
        part = Part(Box((width, depth, HEIGHT)), transform_from_xyz_rpy(0, 0, 0, 0, 0, 0))
        place = transform_from_xyz_rpy(x, y, 0.5 * HEIGHT, 0, 0, 0)
        self._box = Body("box::link", place, (part,))
        self._span = first, end
        self._place = -1

    def begin(self, tick: int) -> None:
        super().begin(tick)
        world = self.world
        assert isinstance(world, ChangingWorld)
        first, end = self._span
        if self._place < 0 and first <= tick < end:
            with contextlib.suppress(WorldError):  # somebody is there: it comes later
                check_object_place(world, self._box)
                self._place = world.add_object(self._box)
        elif self._place >= 0 and tick >= end:
            world.remove_object(self._place)
            self._place, self._span = -1, (end, end)


def line_text(line: StudyLine) -> str:
    """Return one line about a run for the terminal."""
    end = f"{line.makespan:.1f} s" if line.makespan is not None else "not finished"
    if line.per_hour is not None:
        end = f"{line.per_hour:.0f} per hour"
    return (
        f"{line.experiment}: {line.cell}, {line.method}, seed {line.seed}: "
        f"goals {line.goals_reached}/{line.goals_sent}, {end}, contacts {line.contacts}"
    )
