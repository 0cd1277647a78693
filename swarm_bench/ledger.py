"""The books of a run: when goals were sent and settled, who waited how long."""

from __future__ import annotations

import statistics
from collections.abc import Collection, Sequence
from typing import Any

import numpy as np

from swarm_bench.invariant import Invariant
from swarm_bench.result import RobotResult, RunResult, finite
from swarm_bench.stage import RunOptions, Stage
from swarm_commander.itinerary import Itinerary
from swarm_common.beacon import MODE_HOLD, BeaconArray
from swarm_common.records import CONTROL_PERIOD
from swarm_nav.goals import Status
from swarm_sim.world import World

STANDING_SPEED = 0.02  # [m/s] below which, and
STANDING_TURN = 0.1  # [rad/s] below which a robot stands
NO_GOAL = 1 << 60


class Ledger:
    """Kept by the harness, tick by tick."""

    def __init__(self, itineraries: Sequence[Itinerary]) -> None:
        """Begin with nothing sent."""
        count = len(itineraries)
        self._tick = 0
        self._open_since = np.full(count, NO_GOAL)  # start tick of the goal in hand
        self._waits = np.zeros(count, np.int64)
        self._longest = [0] * count
        self._durations: list[int] = []
        self._last_settled = [0] * count

    def note(self, beacons: BeaconArray) -> None:
        """Count who waits in this tick."""
        twists = np.abs(beacons["twist"])
        waits = (twists[:, 0] < STANDING_SPEED) & (twists[:, 1] < STANDING_TURN)
        waits |= beacons["mode"] == MODE_HOLD
        waits &= self._open_since <= self._tick
        self._waits += waits
        self._tick += 1

    def open(self, index: int, start_tick: int) -> None:
        """A goal was sent."""
        self._open_since[index] = start_tick

    def settle(self, index: int, tick: int, is_reached: bool) -> None:
        """A goal has ended."""
        duration = int(tick - self._open_since[index])
        self._open_since[index] = NO_GOAL
        if is_reached:
            self._durations.append(duration)
            self._longest[index] = max(self._longest[index], duration)
            self._last_settled[index] = tick

    def result(
        self,
        options: RunOptions,
        stage: Stage,
        dead: Collection[int],
        invariant: Invariant,
        durations: Sequence[float],
        wall_time: float,
    ) -> RunResult:
        """Return the result of a run that is over."""
        alive = [index for index in range(len(stage.drivers)) if index not in dead]
        statuses = {index: stage.drivers[index].status() for index in alive}
        robots = {
            stage.world.names[index]: self._robot(index, stage, statuses[index]) for index in alive
        }
        verdict = stage.world.verdict
        sent = sum(stage.itineraries[index].total for index in alive)
        reached = sum(robot.goals_reached for robot in robots.values())
        last = max((self._last_settled[index] for index in alive), default=0) * CONTROL_PERIOD
        waits = [robot.wait_time for robot in robots.values()]
        goal_times = self._durations or [0]
        middle = statistics.median(goal_times)
        times = np.asarray(durations, np.float64) * 1e6
        counters: dict[str, Any] = {
            name: sum(getattr(status, name) for status in statuses.values())
            for name in ("pushes", "retreats", "deadlocks_resolved", "replans")
        }
        return RunResult(
            scenario=options.scenario.name,
            method=options.method,
            robots=options.robots,
            seed=options.seed,
            engine=options.engine,
            conditions=conditions(options),
            goals_sent=sent,
            goals_reached=reached,
            goals_failed=sent - reached,
            robot_robot=verdict.robot_robot,
            robot_world=verdict.robot_world,
            first_collision=first_collision(stage.world),
            near_misses=verdict.near_misses,
            min_clearance=finite(verdict.min_clearance),
            min_held_gap=finite(invariant.gap),
            min_held_slack=finite(invariant.slack),
            makespan=last if reached == sent else None,
            throughput_per_minute=60.0 * reached / last if last else 0.0,
            sim_time=verdict.sim_time,
            hold_time=sum(robot.hold_time for robot in robots.values()),
            wait_median=statistics.median(waits) if waits else 0.0,
            wait_worst=max(waits, default=0.0),
            fairness=max(goal_times) / middle if middle else None,
            longest_goal=max(goal_times) * CONTROL_PERIOD,
            recoveries=sum(status.number_of_recoveries for status in statuses.values()),
            wall_time=wall_time,
            tick_us_median=float(np.median(times)) if len(times) else None,
            tick_us_p99=float(np.percentile(times, 99)) if len(times) else None,
            trajectory_sha256=verdict.trajectory_sha256,
            per_robot=robots,
            **counters,
        )

    def _robot(self, index: int, stage: Stage, status: Status) -> RobotResult:
        itinerary = stage.itineraries[index]
        truth = stage.world.verdict.robots[stage.world.names[index]]
        reached = sum(outcome.reached for outcome in itinerary.outcomes)
        is_done = reached == itinerary.total
        return RobotResult(
            goals_reached=reached,
            goals_failed=itinerary.total - reached,
            finish_time=self._last_settled[index] * CONTROL_PERIOD if is_done else None,
            hold_time=status.hold_time,
            wait_time=float(self._waits[index] * CONTROL_PERIOD),
            longest_goal=self._longest[index] * CONTROL_PERIOD,
            distance=truth.distance,
            collisions=truth.collisions,
            min_clearance=finite(truth.min_clearance),
        )


def conditions(options: RunOptions) -> dict[str, Any]:
    """Return what a run depends on beside scenario, size, seed, method and engine."""
    scenario = options.scenario
    return {
        "loss": scenario.loss,
        "delay": scenario.delay,
        "lidar": scenario.with_lidar,
        **options.parameters,
    }


def first_collision(world: World) -> str:
    """Return one line about the first collision, empty if there was none."""
    if not world.collisions:
        return ""
    first = world.collisions[0]
    partners = " and ".join((*first.robots, *([first.obstacle] if first.obstacle else [])))
    return f"{partners} at ({first.x:.2f}, {first.y:.2f}), {first.sim_time:.2f} s"
