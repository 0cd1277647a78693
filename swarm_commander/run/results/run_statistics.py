"""The state of a run while it goes on: events of the processes added up."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import Any, assert_never

import msgspec

from swarm_common.model.breaches import MISSED, Collision, MissedGoal, UnfinishedGoal
from swarm_common.model.run_words import waits_for
from swarm_common.process.messages import (
    CentreReported,
    ClientEvent,
    CollisionBegan,
    ConditionsChecked,
    Event,
    FloorReported,
    ForeignPublisher,
    GoalMissed,
    GoalReached,
    GoalSent,
    GoalsRestored,
    GoalWithdrawn,
    InputsRejected,
    MeetingPorts,
    MissionDone,
    MissionLoaded,
    NavigatorActive,
    NavigatorDied,
    OnlookerEvent,
    OrdersReported,
    ProcessEvent,
    RobotLate,
    RobotRemoved,
    RobotSpawned,
    ServerEvent,
    StationDone,
    StatusReported,
    SwarmHeard,
    TimeOver,
    WorldBuilt,
    WorldProgress,
)
from swarm_mission.itinerary import LOST_REASON
from swarm_mission.orders.order_book import OrderBook, OrderEvent
from swarm_mission.wait_graph import WaitGraph

HOLDING, IDLE = "holding", "idle"
REPEAT_TIME = 10.0  # [s] in which a goal that failed and is sent again is the same goal
SAME_GOAL = 1e-3  # [m]
Uncounted = ProcessEvent | OnlookerEvent | ServerEvent | ClientEvent
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
        self._latest: dict[str, float] = {}
        self._before: dict[str, float] = {}

    def count(self, name: str, value: float) -> float:
        """Count a reading.

        Args:
            value: Value as the present navigator reports it; less than the last one is a new
                navigator's.

        Returns:
            Sum over all navigators that the robot has had.
        """
        latest = self._latest.get(name, 0.0)
        if value < latest:
            self._before[name] = self._before.get(name, 0.0) + latest
        self._latest[name] = value
        return self._before.get(name, 0.0) + value


class GivenGoals:
    """Goals that a robot was given from outside, counted as those of a mission are.

    Robots count each try. One that failed and is soon sent to the same place again has not missed
    its goal yet.

    Attributes:
        sent: Settled goals, and the current one.
        reached: Number of goals that were reached.
        missed: Number of goals that were missed.
        misses: Where and when it gave one up, and why.
        ends: Time and duration [s] of each that was reached.
    """

    def __init__(self) -> None:
        self.misses: list[tuple[str, float, str]] = []
        self.ends: list[tuple[float, float]] = []
        self._began_at = self._failed_began_at = 0.0  # of the current goal, and of that one
        self.sent = self.reached = self.missed = 0
        self._tries_failed = self._repeats = 0
        self._place_map: tuple[float, float] | None = None  # of the current goal
        self._failed_map: tuple[float, float] | None = None  # of the one that failed last
        self._failed_at = -math.inf

    def count(
        self,
        reached: int,
        tries_failed: int,
        goal_map: tuple[float, float] | None,
        now: float,
        reason: str = "",
    ) -> None:
        """Count the goals that a robot reports.

        Args:
            goal_map: (x, y) [m] of where it is to go; None without a goal.
            now: Simulated time [s].
            reason: Why it gave up last.
        """
        is_settled = (reached, tries_failed) != (self.reached, self._tries_failed)
        if tries_failed > self._tries_failed:
            self._failed_map, self._failed_at = self._place_map, now
            self._failed_began_at = self._began_at
            new = tries_failed - self._tries_failed
            failed = self._failed_map
            place = "its goal" if failed is None else f"({failed[0]:g}, {failed[1]:g})"
            self.misses += [(place, now, reason)] * new
        if reached > self.reached and self._place_map is not None:
            self.ends.append((now, now - self._began_at))
        if goal_map is not None and (is_settled or goal_map != self._place_map):
            self._began_at = now
        if goal_map is not None and self._is_repeat(goal_map, now):
            self._repeats += 1
            self._failed_map = None
            self.misses.pop()
            self._began_at = self._failed_began_at
        self._place_map, self._tries_failed = goal_map, tries_failed
        self.reached, self.missed = reached, tries_failed - self._repeats
        self.sent = self.reached + self.missed + (goal_map is not None)

    def _is_repeat(self, goal_map: tuple[float, float], now: float) -> bool:
        if self._failed_map is None or now - self._failed_at > REPEAT_TIME:
            return False
        return math.dist(goal_map, self._failed_map) < SAME_GOAL


@dataclass(slots=True)
class RobotStatistics:
    """Statistics of one robot."""

    active: bool = False
    died: bool = False
    restarts: int = 0  # times that its navigator was restarted
    left: bool = False  # whether it was removed from the world
    is_broken: bool = False  # whether its mission says that it stands still, without a navigator
    state: str = ""
    detail: str = ""
    since: float = 0.0  # simulated time [s] at which it entered its state
    hold_time: float = 0.0
    wait_time: float = 0.0
    sent: int = 0
    reached: int = 0
    failed: int = 0
    goal: str = ""  # name of the goal under way; empty without one
    # time and duration [s] of each goal that was reached
    ends: list[tuple[float, float]] = field(default_factory=list)
    # by the report's names, see `COUNTS`
    counts: dict[str, int] = field(default_factory=lambda: dict.fromkeys(COUNTS.values(), 0))
    meters: Meters = field(default_factory=Meters)  # what its navigators counted
    # goals from outside, of a run without a mission
    given: GivenGoals = field(default_factory=GivenGoals)
    battery: float | None = None  # charge by capacity; None without a battery

    def drop_goal(self) -> None:
        """Forget the current goal."""
        self.goal, self.sent = "", self.reached + self.failed


@dataclass(slots=True)
class RunStatistics:
    """Statistics of all robots; `apply` receives every event."""

    robots: dict[str, RobotStatistics]  # by name
    has_mission: bool  # whether goals are counted from our mission; else from what robots report
    total: int = 0  # goals of the mission; 0 while unknown
    is_done: bool = False  # whether the mission is over
    sim_time: float = 0.0  # [s] latest known
    is_paused: bool = False  # whether the world stands still, as somebody wants it to
    real_time_factor: float = 0.0  # latest known
    robot_robot: int = 0  # collision episodes so far
    robot_world: int = 0  # likewise
    last_goal_time: float = math.nan  # [s] of simulated time at which the latest goal was settled
    # contact episodes in order of time
    collisions_seen: list[Collision] = field(default_factory=list)
    misses: list[MissedGoal] = field(default_factory=list)  # goals given up, in order of time
    # inputs that the doors of the processes turned away, by kind
    rejected: Counter[str] = field(default_factory=Counter)
    # topics with the names of nodes that should not publish there
    foreign: list[tuple[str, str]] = field(default_factory=list)
    waits: WaitGraph = field(default_factory=WaitGraph)  # who waits for whom
    conditions: ConditionsChecked | None = None  # what the map has room for, as the navigators say
    # whose LiDAR sees too little of broken robots, as the world says
    unseen: list[str] = field(default_factory=list)
    orders: OrderBook | None = None  # what became of the mission's orders; None if it has none
    # how floor and robots' time are used, by number of the courier
    floors: dict[int, dict[str, Any]] = field(default_factory=dict)
    stations_left: set[str] = field(default_factory=set)  # stations whose orders are not all done
    # what the centre has cost since it was started last; empty without one
    centre: dict[str, float] = field(default_factory=dict)

    @classmethod
    def of(cls, names: Iterable[str], has_mission: bool) -> RunStatistics:
        """Return the statistics at the start.

        Args:
            has_mission: Whether goals are counted from our mission; else from what robots report.
        """
        return cls({name: RobotStatistics() for name in names}, has_mission)

    def apply(self, event: Event) -> None:
        """Add an event; kinds that do not count are ignored."""
        match event:
            case NavigatorActive(robot=name):
                robot = self.robots[name]
                robot.active, robot.died = True, False
                robot.since = self.sim_time if robot.state == "" else robot.since
            case NavigatorDied(robot=name):
                robot = self.robots[name]
                robot.died = True
                robot.state = robot.detail = ""
                robot.since = self.sim_time
                self.waits.note(name, "", self.sim_time)
            case WorldProgress():
                self.sim_time = event.sim_time
                self.is_paused = event.is_paused
                self.real_time_factor = event.real_time_factor
                self.robot_robot = event.collisions.robot_robot
                self.robot_world = event.collisions.robot_world
            case RobotSpawned(robot=name):
                robot = self.robots.setdefault(name, RobotStatistics())
                robot.active = robot.died = robot.left = False
                robot.state = robot.detail = ""
                robot.since = event.sim_time
            case RobotRemoved(robot=name):
                self.robots[name].left = True
                self.robots[name].since = event.sim_time
                self.waits.note(name, "", self.sim_time)
                self.robots[name].drop_goal()
            case CollisionBegan(collision=collision):
                self.collisions_seen.append(collision)
            case InputsRejected(counts=counts):
                self.rejected.update(counts)
            case ConditionsChecked():
                self.conditions = event
            case ForeignPublisher(topic=topic, node=node):
                self.foreign.append((topic, node))
            case MissionLoaded(goals=goals):
                self.total = goals
            case GoalSent(robot=name, goal=goal):
                self.robots[name].sent += 1
                self.robots[name].goal = goal
            case GoalReached():
                self._add_reached(event)
            case GoalMissed(missed=missed):
                self.robots[missed.robot].failed += 1
                self.robots[missed.robot].goal = ""
                self.misses.append(missed)
                self._settle(missed.sim_time)
            case GoalWithdrawn(robot=name):
                self.total -= 1
                self.robots[name].drop_goal()
            case GoalsRestored():
                self._restore(event)
            case StatusReported():
                self._add_status(event)
            case MissionDone():
                self.is_done = True
            case OrdersReported(events=events):
                if self.orders is not None:
                    self.orders.apply_all(msgspec.convert(events, list[OrderEvent]))
            case FloorReported(courier=courier, figures=figures):
                self.floors[courier] = figures
            case CentreReported(figures=figures):
                self.centre = figures
            case StationDone(station=station):
                self.stations_left.discard(station)
                self.is_done = self.is_done or not self.stations_left
            case WorldBuilt():
                self.unseen = event.unseen
            case MeetingPorts() | RobotLate() | SwarmHeard() | TimeOver():
                pass
            case _:
                if not isinstance(event, Uncounted):
                    assert_never(event)

    def on_mission_restart(self) -> None:
        """Withdraw the current goals: the next mission process sends them again."""
        for robot in self.robots.values():
            robot.drop_goal()

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
    def unfinished(self) -> list[UnfinishedGoal]:
        """Robots that are under way to a goal, and in which state."""
        return [
            UnfinishedGoal(name, robot.goal, f"{robot.state} {robot.detail}".strip())
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

    def _add_reached(self, event: GoalReached) -> None:
        robot = self.robots[event.robot]
        robot.reached += 1
        robot.sent = max(robot.sent, robot.reached)
        robot.ends.append((event.sim_time, event.duration))
        robot.goal = ""
        self._settle(event.sim_time)

    def _restore(self, event: GoalsRestored) -> None:
        """Restore the goals that a robot had lost, as it is there again."""
        robot = self.robots[event.robot]
        robot.failed -= event.goals
        robot.sent = robot.reached + robot.failed + 1  # the current one
        robot.goal = event.goal
        lost = (event.robot, LOST_REASON)
        self.misses = [miss for miss in self.misses if (miss.robot, miss.reason) != lost]

    def _add_status(self, event: StatusReported) -> None:
        robot = self.robots[event.robot]
        if robot.left:  # said before it went
            return
        # Robots are idle from their start on, whenever the first status of one arrives.
        if robot.state != event.state and (robot.state or event.state != IDLE):
            robot.since = event.sim_time
        robot.state, robot.detail = event.state, event.detail
        robot.battery = event.battery
        self.waits.note(event.robot, waits_for(event.state, event.detail), event.sim_time)
        count = robot.meters.count
        robot.hold_time = count("hold_time", event.hold_time)
        robot.wait_time = count("wait_time", event.wait_time)
        robot.counts = {name: int(count(key, getattr(event, key))) for key, name in COUNTS.items()}
        if not self.has_mission:
            settled = robot.reached + robot.failed
            reached = int(count("goals_reached", event.goals_reached))
            failed = int(count("goals_failed", event.goals_failed))
            given = robot.given
            known = len(given.misses)
            reason = event.detail.removeprefix(MISSED) if MISSED in event.detail else ""
            given.count(reached, failed, event.goal_map, event.sim_time, reason)
            robot.ends = given.ends
            if len(given.misses) != known:
                self._list_misses()
            robot.sent, robot.reached, robot.failed = given.sent, given.reached, given.missed
            if robot.reached + robot.failed > settled:
                self._settle(event.sim_time)

    def _list_misses(self) -> None:
        """Collect the goals from outside that were given up."""
        misses = [
            MissedGoal(name, goal, at, reason)
            for name, robot in self.robots.items()
            for goal, at, reason in robot.given.misses
        ]
        self.misses = sorted(misses, key=lambda miss: miss.sim_time)

    def _settle(self, sim_time: float) -> None:
        if not self.last_goal_time >= sim_time:
            self.last_goal_time = sim_time
