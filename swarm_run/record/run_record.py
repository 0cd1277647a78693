"""`RunRecord`: what is known of a run that is over, the same of every track."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import msgspec

from swarm_common.model.breaches import Collision, Count, MissedGoal, UnfinishedGoal
from swarm_run.record.figures import Steady, rounded

SCHEMA = 1


class Merits(msgspec.Struct, frozen=True, kw_only=True):
    """Figures of a run, and of each of its robots; None is unknown. See `RunRecord`."""

    hold_time: float  # [s] of all robots
    wait_time: float  # [s] of all robots
    min_clearance: float | None  # [m] of any robot from anything
    near_misses: int | None = None  # episodes nearer than 0.03 m to something without contact
    pushes: int | None = None  # counter of the brains, likewise up to recoveries
    retreats: int | None = None
    deadlocks_resolved: int | None = None
    replans: int | None = None
    recoveries: int | None = None


COUNTERS = ("pushes", "retreats", "deadlocks_resolved", "replans", "recoveries")


class RobotRecord(Merits, frozen=True, kw_only=True):
    """One robot's share."""

    goals_reached: int
    goals_failed: int  # given up, or never reached in time
    finish_time: float | None = None  # [s] when its last goal was reached; None if one was missed
    goal_worst: float | None  # [s] that its slowest goal took; None without one
    distance: float | None  # [m] driven; None without a verdict, like the next
    collisions: int | None  # contact episodes
    restarts: int = 0  # of its navigator
    battery: Mapping[str, Any] | None = None  # as the world says; None without one


class StationShare(msgspec.Struct, frozen=True, kw_only=True):
    """Shares of the time after the warm-up that a station was in use."""

    occupied: float  # a robot stood there
    approached: float  # a robot stood there, or one on its way there was close


class GroundTruth(msgspec.Struct, frozen=True, kw_only=True):
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


class ResultOrigin(msgspec.Struct, frozen=True, kw_only=True):
    """Origin of one result: code, inputs and machine."""

    commit: str  # of the code, shortened; empty outside a repository
    edition: str  # version and a digest of the code
    inputs: str = ""  # hash of everything that the run was made from
    host: str  # name of the machine
    processor: str  # its model; equal trajectories are promised on one kind
    date: str  # ISO 8601, at the end of the run


class Goals(msgspec.Struct, frozen=True):
    """Goals of a run by what became of them."""

    sent: Count
    reached: Count
    failed: Count  # given up
    pending: Count  # neither; goals of the mission that were never sent included

    @property
    def total(self) -> int:
        """Goals asked for."""
        return self.reached + self.failed + self.pending


class Breaches(msgspec.Struct, frozen=True, kw_only=True):
    """Breaches of a run one by one, in order of time."""

    collisions: tuple[Collision, ...] = ()
    missed_goals: tuple[MissedGoal, ...] = ()
    unfinished_goals: tuple[UnfinishedGoal, ...] = ()  # under way when the run ended


class RunRecord(Merits, frozen=True, kw_only=True):
    """One run."""

    scenario: str = ""  # name
    method: str = ""  # what drove the robots
    robots: int  # swarm size
    seed: int  # seed of the run
    engine: str = ""  # physics
    conditions: Mapping[str, Any] = {}  # what differs from the scenario, like loss or a parameter
    goals_sent: int  # goals asked for
    goals_reached: int  # reached in time
    goals_failed: int  # given up or not reached in time
    robot_robot: int  # contact episodes between robots; contacts of a pair within 0.5 s are one
    robot_world: int  # likewise with walls, obstacles and people
    first_collision: str  # where and when; empty if there was none
    first_miss: str  # who missed which goal and why; empty if nobody did
    # [m] smallest distance between two robots with the space that they hold
    min_held_gap: float | None = None
    # [m] the same less the two safety radii; waffles touch at -0.094 m. For other methods it is the
    # gap between two bodies
    min_held_slack: float | None = None
    makespan: float | None  # [s] until the last goal was reached; None if one was missed
    throughput_per_minute: float  # until the last goal was settled
    sim_time: float  # [s] at the end
    wait_median: float | None  # [s] that a robot waited and held in total, median over robots
    wait_worst: float  # [s] likewise, of the robot that waited most
    goal_median: float | None  # [s] that a goal took
    goal_worst: float | None  # [s] that the slowest goal took
    fairness: float | None  # worst by median of these
    wall_time: float  # [s] of the run
    tick_us_median: float | None = None  # [µs] of a brain's tick
    tick_us_p99: float | None = None  # [µs] likewise
    trajectory_sha256: str  # hash of all true poses
    per_robot: Mapping[str, RobotRecord]  # by name
    # CPU [ms] of world and brains per robot and simulated second
    cpu_ms_per_robot_second: float | None = None
    # `median`, `p95`, `max` [m] of estimated against true positions, with sensors that err
    pose_error: Mapping[str, float] | None = None
    no_guarantee: str = ""  # conditions of liveness that did not hold before the run
    wait_circles: int | None = None  # circles of robots that waited for each other for 5 s or more
    longest_wait_circle: float | None = None  # [s] that the longest of them lasted
    # entries into keepout zones and speeds above limits, with times [s] of all robots; None in a
    # world without zones
    zones: Mapping[str, Any] | None = None
    # standing, deadlocks and use of stations in truth; None on the ROS graph
    ground_truth: GroundTruth | None = None
    # what was finished after the warm-up; None in a run without a duration
    steady: Steady | None = None
    origin: ResultOrigin | None = None  # code, inputs and machine; None in results of older files
    # figures as in report.json; None for a mission without orders
    orders: Mapping[str, Any] | None = None
    # what the method's centre cost: CPU [ms] and bytes per robot-second, and its longest decision
    # [ms]; None where each robot decides alone
    centre: Mapping[str, float] | None = None
    least_held_slack: float | None = None  # [m] that is proved for it; None where nothing is
    goals: Goals | None = None  # from here on in report.json only
    settled_time: float | None = None  # [s] at which the last goal was reached or given up
    waits: Mapping[str, Any] | None = None  # who waited for whom
    breaches: Breaches = Breaches()
    processes: Mapping[str, Any] = {}  # what report.json says beside all this

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
        """Return the line of a bench, with figures rounded to what they are worth."""
        data = msgspec.structs.asdict(self)
        for name in (*OF_REPORT, *(name for name in OPTIONAL if data[name] is None)):
            del data[name]
        data["per_robot"] = {
            name: {key: value for key, value in msgspec.structs.asdict(robot).items()
                   if key != "battery" or value is not None}
            for name, robot in self.per_robot.items()
        }  # fmt: skip
        line: dict[str, Any] = rounded(data)
        return {"schema": SCHEMA, **line}


# Fields that are in report.json only, and those that a line has only if they are known.
OF_REPORT = ("goals", "settled_time", "waits", "breaches", "processes")
OPTIONAL = ("zones", "orders", "ground_truth", "steady", "origin", "centre", "least_held_slack")


def record_from_json(data: Mapping[str, Any]) -> RunRecord:
    """Return the record in a line of `RunRecord.as_json` without its schema.

    Raises:
        ValueError: If a field is missing, or of another type.
    """
    return msgspec.convert(data, RunRecord)
