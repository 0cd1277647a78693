"""What is known of a run while it goes: events of the processes added up."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from typing import Any

from swarm_commander.mission.itinerary import LOST_REASON
from swarm_commander.run.breach import Crash, Miss, Unfinished

HOLDING = "holding"
# What robots count themselves: of a status event -> of the report
COUNTS = {
    "pushes": "pushes",
    "retreats": "retreats",
    "deadlocks_resolved": "deadlocks_resolved",
    "replans": "replans",
    "number_of_recoveries": "recoveries",
}


class Meters:
    """Figures that a navigator counts up from zero, and a new one of its robot once more."""

    def __init__(self) -> None:
        """Begin with zero."""
        self._latest: dict[str, float] = {}
        self._before: dict[str, float] = {}

    def count(self, name: str, value: float) -> float:
        """Take a reading; return the sum over all navigators that the robot has had."""
        latest = self._latest.get(name, 0.0)
        if value < latest:
            self._before[name] = self._before.get(name, 0.0) + latest
        self._latest[name] = value
        return self._before.get(name, 0.0) + value


@dataclass(slots=True)
class RobotTally:
    """Of one robot.

    Attributes:
        restarts: Times that its navigator was started anew.
        left: Whether it was taken out of the world.
        goal: Name of the goal under way; empty without one.
        durations: [s] that each goal took which was reached, by simulated time.
        counts: By the report's names, see `COUNTS`.
        meters: What its navigators counted.
    """

    active: bool = False
    died: bool = False
    restarts: int = 0
    left: bool = False
    state: str = ""
    detail: str = ""
    hold_time: float = 0.0
    wait_time: float = 0.0
    sent: int = 0
    reached: int = 0
    failed: int = 0
    goal: str = ""
    durations: list[float] = field(default_factory=list)
    counts: dict[str, int] = field(default_factory=lambda: dict.fromkeys(COUNTS.values(), 0))
    meters: Meters = field(default_factory=Meters)


@dataclass(slots=True)
class Tally:
    """Of all; `apply` is told every event.

    Attributes:
        robots: By name.
        has_mission: Whether goals are counted from our mission; else from what robots report.
        total: Goals of the mission; 0 while unknown.
        is_done: Whether the mission is over.
        sim_time: [s] latest known.
        real_time_factor: Latest known.
        robot_robot: Collision episodes so far.
        robot_world: Likewise.
        last_goal_time: [s] of simulated time at which the latest goal was settled.
        crashes: Contact episodes in order of time.
        misses: Goals given up, in order of time.
        rejected: Inputs that the doors of the processes turned away, by kind.
        foreign: Topics with the names of nodes that should not publish there.
    """

    robots: dict[str, RobotTally]
    has_mission: bool
    total: int = 0
    is_done: bool = False
    sim_time: float = 0.0
    real_time_factor: float = 0.0
    robot_robot: int = 0
    robot_world: int = 0
    last_goal_time: float = math.nan
    crashes: list[Crash] = field(default_factory=list)
    misses: list[Miss] = field(default_factory=list)
    rejected: Counter[str] = field(default_factory=Counter)
    foreign: list[tuple[str, str]] = field(default_factory=list)

    @classmethod
    def of(cls, names: Iterable[str], has_mission: bool) -> Tally:
        """Return the tally at the start."""
        return cls({name: RobotTally() for name in names}, has_mission)

    def apply(self, event: Mapping[str, Any]) -> None:
        """Add an event; kinds that do not count are ignored."""
        handler = getattr(self, f"_on_{event.get('event')}", None)
        if handler is not None:
            handler(event)

    @property
    def active(self) -> int:
        """Number of robots whose navigator is active."""
        return sum(r.active and not r.died and not r.left for r in self.robots.values())

    @property
    def there(self) -> int:
        """Number of robots that were not taken out."""
        return sum(not robot.left for robot in self.robots.values())

    @property
    def sent(self) -> int:
        """Goals sent."""
        return sum(robot.sent for robot in self.robots.values())

    @property
    def reached(self) -> int:
        """Goals reached."""
        return sum(robot.reached for robot in self.robots.values())

    @property
    def failed(self) -> int:
        """Goals given up."""
        return sum(robot.failed for robot in self.robots.values())

    @property
    def pending(self) -> int:
        """Goals not yet settled: of the whole mission, without one of those sent."""
        return max(0, max(self.total, self.sent) - self.reached - self.failed)

    @property
    def collisions(self) -> int:
        """Collision episodes of any kind."""
        return self.robot_robot + self.robot_world

    @property
    def unfinished(self) -> list[Unfinished]:
        """Robots that are under way to a goal, and in which state."""
        return [
            Unfinished(name, robot.goal, f"{robot.state} {robot.detail}".strip())
            for name, robot in self.robots.items()
            if robot.sent > robot.reached + robot.failed
        ]

    @property
    def holding(self) -> list[str]:
        """Names of the robots in the holding pattern."""
        return [
            name
            for name, robot in self.robots.items()
            if robot.state == HOLDING and not robot.died and not robot.left
        ]

    def _on_active(self, event: Mapping[str, Any]) -> None:
        robot = self.robots[event["robot"]]
        robot.active, robot.died = True, False

    def _on_found(self, event: Mapping[str, Any]) -> None:
        """Take back the goals that a robot had lost, as it is there again."""
        name = event["robot"]
        robot = self.robots[name]
        robot.failed -= int(event["goals"])
        robot.sent = robot.reached + robot.failed + 1  # the one in hand
        robot.goal = str(event["name"])
        self.misses = [
            miss for miss in self.misses if (miss.robot, miss.reason) != (name, LOST_REASON)
        ]

    def _on_died(self, event: Mapping[str, Any]) -> None:
        robot = self.robots[event["robot"]]
        robot.died = True
        robot.state = robot.detail = ""

    def _on_mission_down(self, _: Mapping[str, Any]) -> None:
        """Take back the goals in hand: the next mission process sends them again."""
        for robot in self.robots.values():
            robot.goal, robot.sent = "", robot.reached + robot.failed

    def _on_spawned(self, event: Mapping[str, Any]) -> None:
        robot = self.robots.setdefault(event["robot"], RobotTally())
        robot.active = robot.died = robot.left = False
        robot.state = robot.detail = ""

    def _on_removed(self, event: Mapping[str, Any]) -> None:
        robot = self.robots[event["robot"]]
        robot.left = True
        robot.goal, robot.sent = "", robot.reached + robot.failed

    def _on_withdrawn(self, event: Mapping[str, Any]) -> None:
        """Count a goal of the mission no longer: its robot was taken out."""
        robot = self.robots[event["robot"]]
        self.total -= 1
        robot.goal, robot.sent = "", robot.reached + robot.failed

    def _on_progress(self, event: Mapping[str, Any]) -> None:
        self.sim_time = float(event["sim_time"])
        self.real_time_factor = float(event["real_time_factor"])
        self.robot_robot = int(event["collisions"]["robot_robot"])
        self.robot_world = int(event["collisions"]["robot_world"])

    def _on_mission(self, event: Mapping[str, Any]) -> None:
        self.total = int(event["goals"])

    def _on_rejected(self, event: Mapping[str, Any]) -> None:
        self.rejected.update(event["counts"])

    def _on_foreign(self, event: Mapping[str, Any]) -> None:
        self.foreign.append((event["topic"], event["node"]))

    def _on_done(self, _: Mapping[str, Any]) -> None:
        self.is_done = True

    def _on_collision(self, event: Mapping[str, Any]) -> None:
        self.crashes.append(Crash.of(event))

    def _on_sent(self, event: Mapping[str, Any]) -> None:
        robot = self.robots[event["robot"]]
        robot.sent += 1
        robot.goal = str(event["name"])

    def _on_goal(self, event: Mapping[str, Any]) -> None:
        robot = self.robots[event["robot"]]
        if event["outcome"] == "reached":
            robot.reached += 1
            robot.sent = max(robot.sent, robot.reached)
            robot.durations.append(float(event["duration"]))
        else:
            robot.failed += 1
            self.misses.append(Miss.of(event))
        robot.goal = ""
        self._settle(float(event["sim_time"]))

    def _on_status(self, event: Mapping[str, Any]) -> None:
        robot = self.robots[event["robot"]]
        if robot.left:  # said before it went
            return
        robot.state = event["state"]
        robot.detail = event.get("detail", "")
        count = robot.meters.count
        robot.hold_time = count("hold_time", float(event["hold_time"]))
        robot.wait_time = count("wait_time", float(event["wait_time"]))
        robot.counts = {name: int(count(key, event[key])) for key, name in COUNTS.items()}
        if not self.has_mission:
            settled = robot.reached + robot.failed
            robot.reached = int(count("goals_reached", event["goals_reached"]))
            robot.failed = int(count("goals_failed", event["goals_failed"]))
            robot.sent = robot.reached + robot.failed + bool(event["has_goal"])
            if robot.reached + robot.failed > settled:
                self._settle(float(event["sim_time"]))

    def _settle(self, sim_time: float) -> None:
        if not self.last_goal_time >= sim_time:
            self.last_goal_time = sim_time
