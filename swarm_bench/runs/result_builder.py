"""From a run that is over to its result; the definitions are those of `report.json`."""

from __future__ import annotations

import dataclasses
import statistics
from collections.abc import Collection, Sequence
from dataclasses import asdict
from typing import Any

import numpy as np

from swarm_bench.runs.episode import Episode, RunOptions
from swarm_bench.runs.invariant import Invariant, least_slack
from swarm_bench.runs.result import RobotResult, RunResult, Steady, finite
from swarm_bench.runs.scenario import Scenario
from swarm_bench.runs.steady import steady_of
from swarm_common.model.breaches import MissedGoal, UnfinishedGoal
from swarm_common.model.records import CONTROL_PERIOD
from swarm_mission.fairness import fairness
from swarm_mission.itinerary import Itinerary, StopOutcome
from swarm_mission.orders.courier import Courier
from swarm_nav.core.goals import Status
from swarm_sim.world.verdict import RobotVerdict, Verdict
from swarm_sim.world.world import World

COUNTERS = ("pushes", "retreats", "deadlocks_resolved", "replans")


def compose_result(
    options: RunOptions,
    stage: Episode,
    dead: Collection[int],
    invariant: Invariant,
    durations: Sequence[float],
    wall_time: float,
) -> RunResult:
    """Return the result of a run that is over.

    Args:
        stage: World, drivers and missions at the end.
        dead: Indices of the robots whose goals are not asked for.
        durations: [s] of wall time of brains' ticks, of all or of some.
        wall_time: [s] of the run.
    """
    verdict = stage.world.verdict
    alive = [index for index in range(len(stage.drivers)) if index not in dead]
    statuses = [stage.drivers[index].status() for index in alive]
    robots = {
        stage.world.names[index]: _robot(
            stage.itineraries[index], verdict.robots[stage.world.names[index]], status
        )
        for index, status in zip(alive, statuses, strict=True)
    }
    reached = [o for i in alive for o in stage.itineraries[i].outcomes if o.reached]
    is_steady = options.scenario.duration > 0.0
    sent = sum(
        len(stage.itineraries[index].outcomes) if is_steady else stage.itineraries[index].total
        for index in alive
    )
    last = max((outcome.tick for outcome in reached), default=0) * CONTROL_PERIOD
    return RunResult(
        **identity(options),
        goals_sent=sent,
        goals_reached=len(reached),
        goals_failed=sent - len(reached),
        first_miss=_first_miss(stage, alive, with_unfinished=not is_steady),
        makespan=last if len(reached) == sent and not is_steady else None,
        throughput_per_minute=60.0 * len(reached) / last if last else 0.0,
        min_held_gap=finite(invariant.gap),
        min_held_slack=finite(invariant.slack),
        least_held_slack=least_slack(stage.drivers),
        wall_time=wall_time,
        per_robot=robots,
        steady=_steady(stage, options.scenario, reached) if is_steady else None,
        no_guarantee="; ".join(stage.conditions.findings) if stage.conditions else "",
        recoveries=sum(status.number_of_recoveries for status in statuses),
        **{name: sum(getattr(status, name) for status in statuses) for name in COUNTERS},
        orders=None if stage.orders is None else stage.orders.run.results(verdict.sim_time),
        **_truth(stage.world, verdict),
        **_service(list(robots.values()), [outcome.duration for outcome in reached]),
        **_pace(durations),
    )


def _steady(stage: Episode, scenario: Scenario, reached: Sequence[StopOutcome]) -> Steady:
    """Return what was finished after the warm-up: orders where there are any, else goals."""
    if stage.orders is not None:
        records = stage.orders.run.results(stage.world.verdict.sim_time)["orders"]
        done = [(each["done"], each["lead_time"]) for each in records if each["done"] is not None]
        return steady_of(done, scenario.warm_up, scenario.duration, "orders")
    finished = [(outcome.tick * CONTROL_PERIOD, outcome.duration) for outcome in reached]
    return steady_of(finished, scenario.warm_up, scenario.duration)


def identity(options: RunOptions) -> dict[str, Any]:
    """Return the fields that say which run it was."""
    return {
        "scenario": options.scenario.name,
        "method": options.method,
        "robots": options.robots,
        "seed": options.seed,
        "engine": options.engine,
        "conditions": conditions(options),
    }


def _truth(world: World, verdict: Verdict) -> dict[str, Any]:
    """Return what the world says."""
    return {
        "robot_robot": verdict.robot_robot,
        "robot_world": verdict.robot_world,
        "first_collision": str(world.collisions[0]) if world.collisions else "",
        "near_misses": verdict.near_misses,
        "min_clearance": finite(verdict.min_clearance),
        "sim_time": verdict.sim_time,
        "trajectory_sha256": verdict.trajectory_sha256,
        "zones": None if verdict.zones is None else dataclasses.asdict(verdict.zones),
    }


def _service(robots: Sequence[RobotResult], goal_times: Sequence[float]) -> dict[str, Any]:
    """Return how long robots waited and goals took [s]."""
    waits = [robot.hold_time + robot.wait_time for robot in robots]
    served = fairness(goal_times)
    return {
        "hold_time": sum(robot.hold_time for robot in robots),
        "wait_time": sum(robot.wait_time for robot in robots),
        "wait_median": statistics.median(waits) if waits else None,
        "wait_worst": max(waits, default=0.0),
        "goal_median": served.median,
        "goal_worst": served.worst,
        "fairness": served.ratio,
    }


def _pace(durations: Sequence[float]) -> dict[str, Any]:
    times = np.asarray(durations, np.float64) * 1e6
    if not len(times):
        return {"tick_us_median": None, "tick_us_p99": None}
    median, p99 = np.percentile(times, (50, 99))
    return {"tick_us_median": float(median), "tick_us_p99": float(p99)}


def conditions(options: RunOptions) -> dict[str, Any]:
    """Return what a run depends on beside scenario, size, seed, method and engine.

    Returns:
        By name: what the scenario says of radio, LiDAR and noise, and the parameters that were
        given.
    """
    scenario = options.scenario
    return {
        "loss": scenario.loss,
        "delay": scenario.delay,
        "lidar": scenario.with_lidar,
        "noise": scenario.noise,
        **({"laps": scenario.laps} if scenario.laps != 1 else {}),
        **({"duration": scenario.duration} if scenario.duration else {}),
        **({"warm_up": scenario.warm_up} if scenario.duration else {}),
        **({"dispatch": scenario.dispatch} if scenario.dispatch else {}),
        **({"realistic": True} if options.realistic else {}),
        **{
            name if pattern == "/**" else f"{pattern} {name}": value
            for pattern, values in options.sections.items()
            for name, value in values.items()
        },
        **options.parameters,
        **{f"central.{name}": value for name, value in options.central.items()},
    }


def _robot(itinerary: Itinerary | Courier, truth: RobotVerdict, status: Status) -> RobotResult:
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
        battery=None if truth.battery is None else asdict(truth.battery),
    )


def _first_miss(stage: Episode, alive: Sequence[int], *, with_unfinished: bool) -> str:
    """Return the first goal that a robot gave up, or else one that was still under way."""
    misses = [
        MissedGoal(stage.world.names[i], o.stop.name, o.tick * CONTROL_PERIOD, o.reason)
        for i in alive
        for o in stage.itineraries[i].outcomes
        if not o.reached
    ]
    if misses:
        return str(min(misses, key=lambda miss: miss.sim_time))
    for index in alive if with_unfinished else ():
        if stage.orders is None and not stage.itineraries[index].is_over:
            status = stage.drivers[index].status()
            goal = stage.itineraries[index].next_stop
            state = f"{status.state} {status.detail}".strip()
            return str(UnfinishedGoal(stage.world.names[index], goal, state))
    return ""
