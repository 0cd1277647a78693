"""From a run that is over to its result; the definitions are those of `report.json`."""

from __future__ import annotations

import statistics
from collections.abc import Collection, Sequence
from typing import Any

import numpy as np

from swarm_bench.invariant import Invariant
from swarm_bench.result import RobotResult, RunResult, finite
from swarm_bench.stage import RunOptions, Stage
from swarm_commander.breach import Crash, Miss, Unfinished
from swarm_commander.fairness import fairness
from swarm_commander.itinerary import Itinerary
from swarm_common.records import CONTROL_PERIOD
from swarm_nav.goals import Status
from swarm_sim.verdict import RobotVerdict
from swarm_sim.world import World

COUNTERS = ("pushes", "retreats", "deadlocks_resolved", "replans")


def compose_result(
    options: RunOptions,
    stage: Stage,
    dead: Collection[int],
    invariant: Invariant,
    durations: Sequence[float],
    wall_time: float,
) -> RunResult:
    """Return the result of a run that is over.

    Args:
        options: What was run.
        stage: World, drivers and missions at the end.
        dead: Indices of the robots whose goals are not asked for.
        invariant: As watched.
        durations: [s] of wall time of each tick of each brain.
        wall_time: [s] of the run.
    """
    verdict = stage.world.verdict
    alive = [index for index in range(len(stage.drivers)) if index not in dead]
    statuses = [stage.drivers[index].status() for index in alive]
    names = [stage.world.names[index] for index in alive]
    robots = {
        name: _robot(stage.itineraries[index], verdict.robots[name], status)
        for index, name, status in zip(alive, names, statuses, strict=True)
    }
    reached = [o for i in alive for o in stage.itineraries[i].outcomes if o.reached]
    sent = sum(stage.itineraries[index].total for index in alive)
    last = max((outcome.tick for outcome in reached), default=0) * CONTROL_PERIOD
    waits = [robot.hold_time + robot.wait_time for robot in robots.values()]
    served = fairness([outcome.duration for outcome in reached])
    times = np.asarray(durations, np.float64) * 1e6
    return RunResult(
        scenario=options.scenario.name,
        method=options.method,
        robots=options.robots,
        seed=options.seed,
        engine=options.engine,
        conditions=conditions(options),
        goals_sent=sent,
        goals_reached=len(reached),
        goals_failed=sent - len(reached),
        robot_robot=verdict.robot_robot,
        robot_world=verdict.robot_world,
        first_collision=_first_collision(stage.world),
        first_miss=_first_miss(stage, alive),
        near_misses=verdict.near_misses,
        min_clearance=finite(verdict.min_clearance),
        min_held_gap=finite(invariant.gap),
        min_held_slack=finite(invariant.slack),
        makespan=last if len(reached) == sent else None,
        throughput_per_minute=60.0 * len(reached) / last if last else 0.0,
        sim_time=verdict.sim_time,
        hold_time=sum(robot.hold_time for robot in robots.values()),
        wait_time=sum(robot.wait_time for robot in robots.values()),
        wait_median=statistics.median(waits) if waits else 0.0,
        wait_worst=max(waits, default=0.0),
        goal_median=served.median,
        goal_worst=served.worst,
        fairness=served.ratio,
        recoveries=sum(status.number_of_recoveries for status in statuses),
        wall_time=wall_time,
        tick_us_median=float(np.median(times)) if len(times) else None,
        tick_us_p99=float(np.percentile(times, 99)) if len(times) else None,
        trajectory_sha256=verdict.trajectory_sha256,
        per_robot=robots,
        **{name: sum(getattr(status, name) for status in statuses) for name in COUNTERS},
    )


def conditions(options: RunOptions) -> dict[str, Any]:
    """Return what a run depends on beside scenario, size, seed, method and engine."""
    scenario = options.scenario
    return {
        "loss": scenario.loss,
        "delay": scenario.delay,
        "lidar": scenario.with_lidar,
        "noise": scenario.noise,
        **options.parameters,
    }


def _robot(itinerary: Itinerary, truth: RobotVerdict, status: Status) -> RobotResult:
    reached = [outcome for outcome in itinerary.outcomes if outcome.reached]
    is_done = len(reached) == itinerary.total
    return RobotResult(
        goals_reached=len(reached),
        goals_failed=itinerary.total - len(reached),
        finish_time=reached[-1].tick * CONTROL_PERIOD if is_done and reached else None,
        hold_time=status.hold_time,
        wait_time=status.wait_time,
        goal_worst=max((outcome.duration for outcome in reached), default=None),
        distance=truth.distance,
        collisions=truth.collisions,
        min_clearance=finite(truth.min_clearance),
    )


def _first_collision(world: World) -> str:
    if not world.collisions:
        return ""
    first = world.collisions[0]
    return str(Crash(first.robots, first.obstacle, first.x, first.y, first.sim_time))


def _first_miss(stage: Stage, alive: Sequence[int]) -> str:
    """Return who gave up a goal first, or else who was still under way."""
    misses = [
        Miss(stage.world.names[i], o.stop.name, o.tick * CONTROL_PERIOD, o.reason)
        for i in alive
        for o in stage.itineraries[i].outcomes
        if not o.reached
    ]
    if misses:
        return str(min(misses, key=lambda miss: miss.sim_time))
    for index in alive:
        if not stage.itineraries[index].is_over:
            status = stage.drivers[index].status()
            goal = stage.itineraries[index].next_stop
            state = f"{status.state} {status.detail}".strip()
            return str(Unfinished(stage.world.names[index], goal, state))
    return ""
