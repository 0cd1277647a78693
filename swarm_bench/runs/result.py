"""Result of a run: counted by the harness, the same fields for every method."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import msgspec

from swarm_bench.runs.json_lines import rounded
from swarm_bench.runs.origin import ResultOrigin


@dataclass(frozen=True, slots=True, kw_only=True)
class RobotResult:
    """One robot's share."""

    goals_reached: int  # of its mission
    goals_failed: int  # given up, or never reached in time
    finish_time: float | None  # [s] when its last goal was reached; None if one was missed
    hold_time: float  # [s] in the holding pattern
    wait_time: float  # [s] of standing on its way because of other robots
    goal_worst: float | None  # [s] that its slowest goal took; None without one
    distance: float  # [m] driven
    collisions: int  # contact episodes
    min_clearance: float | None  # [m] from anything; None if nothing was near
    battery: Mapping[str, Any] | None = None  # as in report.json; None without one


@dataclass(frozen=True, slots=True, kw_only=True)
class StationShare:
    """Shares of the time after the warm-up that a station was in use."""

    occupied: float  # a robot stood there
    approached: float  # a robot stood there, or one on its way there was close


@dataclass(frozen=True, slots=True, kw_only=True)
class GroundTruth:
    """Behaviour of robots as the simulator sees it: by true poses and the goals sent to them.

    A robot stands if it has a goal to go to and, for a second, neither moves nor turns.
    """

    stood_time: float  # [s] of standing, of all robots
    stood_worst: float  # [s] of the longest time that one robot stood
    stood_share: float  # of the robots' time after the warm-up
    circles: int  # of robots that stood in each other's way for 5 s or more
    longest_circle: float  # [s]
    deadlocks: int  # circles of 30 s or more, and times of 60 s in which nobody came nearer a goal
    stations: Mapping[str, StationShare]  # by name


@dataclass(frozen=True, slots=True, kw_only=True)
class Steady:
    """Work finished in the time after the warm-up of a run of fixed duration."""

    warm_up: float  # [s] that do not count
    seconds: float  # [s] that count
    finished: tuple[int, ...]  # goals or orders, in batches of equal length
    lead_times: tuple[float, ...]  # [s] mean lead time of those of each batch; 0 for none
    per_hour: float  # finished goals or orders
    lead_time: float | None  # [s] mean, of all; None if none was finished
    lead_p95: float | None  # [s] that 95 % took at most
    unit: str = "goals"  # what is counted


@dataclass(frozen=True, slots=True, kw_only=True)
class FailedRun:
    """A run without a result, and why; it is repeated when a bench goes on."""

    scenario: str
    method: str
    robots: int
    seed: int
    engine: str
    conditions: Mapping[str, Any]
    error: str  # in one line
    origin: ResultOrigin | None = None
    refused: bool = False  # whether the error is one of the user's input, such as a solver's plan

    def as_json(self) -> dict[str, Any]:
        """Return a dictionary for json.dump."""
        data = dataclasses.asdict(self)
        if not self.refused:
            del data["refused"]
        return {"schema": 1, **rounded(data)}


@dataclass(frozen=True, slots=True, kw_only=True)
class RunResult:
    """One run.

    Attributes:
        scenario: Name.
        method: What drove the robots.
        robots: Swarm size.
        seed: Seed of the run.
        engine: Physics.
        conditions: What differs from the scenario, like loss or a parameter.
        goals_sent: Goals asked for.
        goals_reached: Reached in time.
        goals_failed: Given up or not reached in time.
        robot_robot: Contact episodes between robots; contacts of a pair within 0.5 s are one.
        robot_world: Likewise with walls, obstacles and people.
        first_collision: Where and when; empty if there was none.
        first_miss: Who missed which goal and why; empty if nobody did.
        near_misses: Episodes nearer than 0.03 m to something without contact.
        min_clearance: [m] of any robot from anything.
        min_held_gap: [m] smallest distance between two robots with the space that they hold.
        min_held_slack: [m] the same less the two safety radii; waffles touch at -0.094 m. For other
            methods it is the gap between two bodies.
        least_held_slack: [m] that is proved for it; None where nothing is.
        makespan: [s] until the last goal was reached; None if one was missed.
        throughput_per_minute: Goals.
        sim_time: [s] at the end.
        hold_time: [s] of all robots.
        wait_time: [s] of all robots.
        wait_median: [s] that a robot waited and held in total, median over robots.
        wait_worst: [s] likewise, of the robot that waited most.
        goal_median: [s] that a goal took.
        goal_worst: [s] that the slowest goal took.
        fairness: Worst by median of these.
        pushes: Counter of the brains, likewise up to recoveries.
        wall_time: [s] of the run.
        tick_us_median: [µs] of a brain's tick.
        tick_us_p99: [µs] likewise.
        cpu_ms_per_robot_second: CPU [ms] of world and brains per robot and simulated second.
        pose_error: `median`, `p95`, `max` [m] of estimated against true positions, with sensors
            that err.
        trajectory_sha256: Hash of all true poses.
        per_robot: By name.
        wait_circles: Circles of robots that waited for each other for 5 s or more.
        longest_wait_circle: [s] that the longest of them lasted.
        zones: Entries into keepout zones and speeds above limits, with times [s] of all robots;
            None in a world without zones.
        ground_truth: Standing, deadlocks and use of stations in truth; None on the ROS graph.
        steady: What was finished after the warm-up; None in a run without a duration.
        origin: Code, inputs and machine; None in results of older files.
        orders: Figures as in report.json; None for a mission without orders.
        centre: What the method's centre cost: CPU [ms] and bytes per robot-second, and its longest
            decision [ms]; None where each robot decides alone.
        no_guarantee: Conditions of liveness that did not hold before the run.
    """

    scenario: str
    method: str
    robots: int
    seed: int
    engine: str
    conditions: Mapping[str, Any]
    goals_sent: int
    goals_reached: int
    goals_failed: int
    robot_robot: int
    robot_world: int
    first_collision: str
    first_miss: str
    near_misses: int | None
    min_clearance: float | None
    min_held_gap: float | None
    min_held_slack: float | None
    makespan: float | None
    throughput_per_minute: float
    sim_time: float
    hold_time: float
    wait_time: float
    wait_median: float | None
    wait_worst: float
    goal_median: float | None
    goal_worst: float | None
    fairness: float | None
    pushes: int | None
    retreats: int | None
    deadlocks_resolved: int | None
    replans: int | None
    recoveries: int | None
    wall_time: float
    tick_us_median: float | None
    tick_us_p99: float | None
    trajectory_sha256: str
    per_robot: Mapping[str, RobotResult]
    cpu_ms_per_robot_second: float | None = None
    pose_error: Mapping[str, float] | None = None
    no_guarantee: str = ""
    wait_circles: int | None = None
    longest_wait_circle: float | None = None
    zones: Mapping[str, Any] | None = None
    ground_truth: GroundTruth | None = None
    steady: Steady | None = None
    origin: ResultOrigin | None = None
    orders: Mapping[str, Any] | None = None
    centre: Mapping[str, float] | None = None
    least_held_slack: float | None = None

    @property
    def is_flawless(self) -> bool:
        """Whether all goals were reached without a collision, and the invariant held."""
        is_safe = not (self.robot_robot + self.robot_world) and self.keeps_apart
        return self.goals_reached == self.goals_sent and is_safe

    @property
    def keeps_apart(self) -> bool:
        """Whether no two robots came nearer than is proved."""
        slack, least = self.min_held_slack, self.least_held_slack
        return slack is None or least is None or slack >= least

    @property
    def breach(self) -> str:
        """Breach of the safety invariant, in words; empty for none."""
        if self.keeps_apart:
            return ""
        return f"held space {self.min_held_slack:.3f} m, at least {self.least_held_slack:.3f}"

    def as_json(self) -> dict[str, Any]:
        """Return a dictionary for json.dump, with figures rounded to what they are worth."""
        data = dataclasses.asdict(self)
        for name in (
            "zones",
            "orders",
            "ground_truth",
            "steady",
            "origin",
            "centre",
            "least_held_slack",
        ):
            if data[name] is None:
                del data[name]
        for robot in data["per_robot"].values():
            if robot["battery"] is None:
                del robot["battery"]
        return {"schema": 1, **rounded(data)}


def line_from_json(data: Mapping[str, Any]) -> RunResult | FailedRun:
    """Return what a line of a result file says.

    Args:
        data: Without its schema.

    Raises:
        ValueError: If a field is missing, or of another type.
    """
    return msgspec.convert(data, FailedRun) if "error" in data else result_from_json(data)


def result_from_json(data: Mapping[str, Any]) -> RunResult:
    """Return the result in a dictionary of `RunResult.as_json` without its schema.

    Args:
        data: Robots under `per_robot` by name.

    Raises:
        ValueError: If a field is missing, or of another type.
    """
    return msgspec.convert(data, RunResult)


def finite(value: float) -> float | None:
    """Return a number, or None for one that is not finite.

    Args:
        value: May be NaN or infinite.
    """
    return value if math.isfinite(value) else None
