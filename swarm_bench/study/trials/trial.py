"""One run of the study with its faults."""

from __future__ import annotations

import contextlib
import importlib
import statistics
import time
from collections.abc import Iterator, Mapping
from typing import Any

from swarm_bench.runs.episode import Episode, RunOptions, build
from swarm_bench.runs.harness import Harness
from swarm_bench.runs.methods import OF_NAVIGATORS, TEAMS
from swarm_bench.study.trials.bounds import least_makespan
from swarm_bench.study.trials.cell import Cell, Settings, StudyRun, is_constant, settings_text
from swarm_bench.study.trials.line import STEP, StudyLine, study_edition
from swarm_central.movingai import SolverError
from swarm_central.roadmap import RoadmapError
from swarm_common.model.beacon import BEACON_SIZE
from swarm_common.model.errors import WorldError
from swarm_common.model.records import CONTROL_PERIOD
from swarm_common.model.shapes import Box, Part, transform_from_xyz_rpy
from swarm_describe.worlds.scene import Body
from swarm_run.record.run_record import RunRecord
from swarm_sim.world.changing_world import ChangingWorld
from swarm_sim.world.object_placement import check_object_place
from swarm_sim.world.world import World

HEIGHT = 1.0  # [m] of a box in the way
BASELINES = "swarm_bench.baselines"
BEACON_RATE = BEACON_SIZE / CONTROL_PERIOD  # [bytes/s]


def run_one(item: tuple[StudyRun, RunOptions]) -> StudyLine:
    """Run once. A centre that gives up, or has no roadmap, has failed: that is a result, too.

    Args:
        item: A run and its options, for which files were read where the command runs.

    Raises:
        SwarmError: If a file or a value is unusable.
    """
    started = time.process_time()
    run, options = item
    cell, scenario = run.cell, options.scenario
    identity: dict[str, Any] = {
        "experiment": run.experiment,
        "cell": cell.name,
        "condition": cell.condition,
        "method": run.method,
        "seed": run.seed,
        "settings": settings_text(run.settings),
        "edition": study_edition(),
        "stopped": scenario.limit_of(cell.robots),
    }
    try:
        result, bound, blocked = _result(run, options)
    except (SolverError, RoadmapError) as error:
        return failed_line(identity, str(error), time.process_time() - started, cell)
    centre, steady, truth = result.centre, result.steady, result.ground_truth
    # Robots of a centre alone overhear its traffic; all others send beacons.
    radio = 0.0 if run.method in TEAMS and run.method not in OF_NAVIGATORS else BEACON_RATE
    if centre is not None:
        radio += centre["bytes_up_per_robot_second"] + centre["bytes_down_per_robot_second"]
    return StudyLine(
        **identity,
        goals_sent=result.goals_sent,
        goals_reached=result.goals_reached,
        robot_robot=result.robot_robot,
        robot_world=result.robot_world,
        makespan=_rounded(result.makespan, 1),
        bound=_rounded(bound, 1),
        blocked=blocked,
        per_hour=None if steady is None else round(steady.per_hour, 1),
        lead_time=None if steady is None else _rounded(steady.lead_time or None, 1),
        batches=None if steady is None else list(steady.finished),
        done=_done(result),
        worst_by_median=None if steady is None else _worst_by_median(result),
        stood_share=None if truth is None else round(truth.stood_share, 4),
        cpu=round(time.process_time() - started, 1),
        sim_time=result.sim_time,
        cpu_ms_per_robot_second=round(result.cpu_ms_per_robot_second or 0.0, 3),
        centre_ms_per_robot_second=_rounded(_of(centre, "cpu_ms_per_robot_second"), 4),
        tick_us_median=_rounded(result.tick_us_median, 1),
        tick_us_p99=_rounded(result.tick_us_p99, 1),
        longest_decision_ms=_rounded(_of(centre, "longest_decision_ms"), 1),
        p99_decision_ms=_rounded(_of(centre, "p99_decision_ms"), 2),
        bytes_per_robot_second=round(radio, 1),
        trajectory_sha256=result.trajectory_sha256,
    )


def _result(run: StudyRun, options: RunOptions) -> tuple[RunRecord, float | None, float | None]:
    """Return what became of a run, and two times [s], where they count.

    Returns:
        The run; the least time that it could take; how long a box stood in its way.
    """
    cell = run.cell
    with _constants(run.settings):
        episode = build(options, world_class=ChangingWorld if cell.blocked else World)
        has_route = cell.has_end and not cell.dead and episode.orders is None
        bound = least_makespan(options, episode) if has_route else None
        if episode.centre is not None and cell.outage:
            first, end = cell.span()
            episode.centre.outage = first, end - 1
        if not cell.blocked:
            return Harness(options, episode=episode, faults=run.faults()).run(), bound, None
        harness = _BlockedHarness(options, episode=episode, run=run)
        return harness.run(), bound, round(harness.blocked * CONTROL_PERIOD, 1)


def failed_line(identity: dict[str, Any], failure: str, cpu: float, cell: Cell) -> StudyLine:
    """Return the line of a run whose centre failed: nothing was done, and all time was needed."""
    return StudyLine(
        **identity, failure=failure, goals_sent=0, goals_reached=0, robot_robot=0, robot_world=0,
        makespan=None, bound=None, per_hour=None if cell.has_end else 0.0,
        batches=None if cell.has_end else [0], cpu=round(cpu, 1), cpu_ms_per_robot_second=0.0,
        tick_us_p99=None, longest_decision_ms=None, bytes_per_robot_second=None,
        trajectory_sha256="",
    )  # fmt: skip


def _of(figures: Mapping[str, float] | None, name: str) -> float | None:
    return None if figures is None else figures[name]


def _rounded(value: float | None, digits: int) -> float | None:
    return None if value is None else round(value, digits)


def _done(result: RunRecord) -> list[int] | None:
    """Return how many orders were done in each `STEP` of a run without end."""
    if result.orders is None or result.steady is None:
        return None
    bins = [0] * (int(result.sim_time / STEP) + 1)
    for record in result.orders["orders"]:
        if record["done"] is not None:
            bins[int(record["done"] / STEP)] += 1
    return bins


def _worst_by_median(result: RunRecord) -> float | None:
    """Return the goals of the robot with the fewest, by those of the median robot."""
    reached = [robot.goals_reached for robot in result.per_robot.values()]
    median = statistics.median(reached) if reached else 0
    return round(min(reached) / median, 3) if median else None


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


class _BlockedHarness(Harness):
    """A run in which a box stands in the way for a time, from when there is room for it."""

    def __init__(self, options: RunOptions, *, episode: Episode, run: StudyRun) -> None:
        super().__init__(options, episode=episode, faults=run.faults())
        x, y, width, depth = run.cell.blocked
        part = Part(Box((width, depth, HEIGHT)), transform_from_xyz_rpy(0, 0, 0, 0, 0, 0))
        place = transform_from_xyz_rpy(x, y, 0.5 * HEIGHT, 0, 0, 0)
        self._box = Body("box::link", place, (part,))
        self._span = run.cell.span()
        self._place = -1
        self.blocked = 0  # ticks with the box

    def begin(self, tick: int) -> None:
        super().begin(tick)
        world = self.world
        assert isinstance(world, ChangingWorld)
        first, end = self._span
        self.blocked += self._place >= 0
        if self._place < 0 and first <= tick < end:
            with contextlib.suppress(WorldError):  # somebody is there: it comes later
                check_object_place(world, self._box)
                self._place = world.add_object(self._box)
        elif self._place >= 0 and tick >= end:
            world.remove_object(self._place)
            self._place, self._span = -1, (end, end)


def line_text(line: StudyLine) -> str:
    """Return one line about a run for the terminal."""
    end = f"{line.makespan:.1f} s" if line.makespan is not None else line.failure or "not finished"
    if line.per_hour is not None:
        end = f"{line.per_hour:.0f} per hour"
    return (
        f"{line.experiment}: {line.cell}, {line.method}, seed {line.seed}: "
        f"goals {line.goals_reached}/{line.goals_sent}, {end}, contacts {line.contacts}"
    )
