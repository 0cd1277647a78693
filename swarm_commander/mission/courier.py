"""Process of one robot's courier, or of several that share it in a large swarm.

It bids for the orders that it hears of on `/orders`, and sends its robot where they lead. In
lockstep it decides on a tick when its robot has, and then lets the robot answer the world: so what
it says takes effect one tick later. In free run it goes by `/clock` and the robot's status.

python -m swarm_commander.mission.courier CONFIG.json --event-fd N --control-fd M
"""

from __future__ import annotations

import math
import time
from collections.abc import Sequence
from functools import partial
from pathlib import Path
from typing import Any

import msgspec
from nav2_msgs.action import NavigateToPose
from rclpy.node import Node
from swarm_interfaces.msg import RobotStatus

from swarm_commander.mission.order_channel import OrderChannel
from swarm_commander.mission.order_party import run_party
from swarm_commander.mission.state_log import FILE, GoalNews, StateLog
from swarm_common.files.journal import Journal
from swarm_common.files.map_io import load_map
from swarm_common.files.sites_io import load_sites
from swarm_common.middleware.courier_io import StepLink, TickRelease, TickReport
from swarm_common.middleware.rejections import Rejections
from swarm_common.middleware.ros_io import pose_stamped, start_text, tick_of
from swarm_common.middleware.ros_poll import PolledTopic
from swarm_common.model.palette import CHARGING
from swarm_common.model.records import Pose
from swarm_common.process import messages as say
from swarm_common.process.pipes import EventWriter
from swarm_mission.itinerary import NextGoal
from swarm_mission.leg import HOME
from swarm_mission.mission import load_mission
from swarm_mission.orders.courier import Courier
from swarm_mission.orders.dispatch import CLAIM
from swarm_mission.orders.floor_use import FloorUse
from swarm_mission.orders.messages import Envelope
from swarm_mission.orders.robot_bidder import BidSenses
from swarm_mission.orders.way_lengths import WayLengths
from swarm_run.robots.client import RobotCommander
from swarm_run.robots.status_check import StatusCheck
from swarm_run.robots.task import Task, TaskResult

# A robot says nothing after so long without a status; the status may wait in a busy machine.
MUTE_TICKS = 50
MUTE_TIME = 2.0  # [s] of wall time


class OrderRobot:
    """One robot: its courier, its client, and the goal that it was sent last.

    Attributes:
        is_awaited: Whether ticks wait for its reports; not of one that is down or late.
        link: Brings its reports; None in free run, where it does not report.
    """

    def __init__(
        self,
        client: RobotCommander,
        courier: Courier,
        ways: WayLengths,
        speed: float,
        node: Node,
        rejections: Rejections,
        *,
        is_in_step: bool,
    ) -> None:
        """Attach to a robot.

        Args:
            speed: [m/s] at most.
            node: For the topics of lockstep.
            is_in_step: Whether the robot awaits the release of each tick.
        """
        self.client = client
        self.courier = courier
        self.senses = BidSenses(
            self._way_to, speed, self._charge, self._reach, way_between=ways.between
        )
        self.is_awaited = True
        self._ways = ways
        self._task: Task | None = None
        self._goal: NextGoal | None = None
        self._sent_at = -1  # tick in which it was sent
        self._heard_at = time.monotonic()  # wall time of its latest status
        self._status_tick = 0  # of its latest status
        self._known = 0  # outcomes that were told
        self._is_told = False  # whether the current goal was told
        self._report: TickReport | None = None  # the newest
        self._released = -1  # tick that it may answer
        self._goals: list[bytes] = []  # sent in the present tick
        self.link = StepLink(node, client.name, rejections) if is_in_step else None

    # Which tick it is at

    @property
    def tick(self) -> int:
        """Newest tick that it has decided on, as far as it reports; -1 before that."""
        return -1 if self._report is None else self._report.tick

    @property
    def is_unheard(self) -> bool:
        """Whether a first report is to come."""
        return self.link is not None and self._report is None

    def poll(self) -> None:
        """Receive its reports."""
        while self.link is not None and (report := self.link.take()) is not None:
            self._report = report

    def has_decided(self, tick: int) -> bool:
        """Whether it takes part in a tick: in lockstep it has reported on it, else it is heard."""
        if self.link is None:
            return self.is_awaited and not self._is_mute(tick)
        is_here = self.tick == tick
        self.is_awaited |= is_here
        return is_here

    def is_missing(self, tick: int, begun: int) -> bool:
        """Whether a tick waits for its report.

        Args:
            begun: Tick that the world has begun for certain; it does without robots that are late.
        """
        if self.link is None or self.tick >= tick:
            return False
        has_joined = self.tick == tick - 1  # one that was down, and is started again
        self.is_awaited = (self.is_awaited or has_joined) and begun <= tick
        return self.is_awaited

    def release(self, tick: int) -> None:
        """Let it answer a tick, once the goals of this tick have reached it."""
        if self.link is not None:
            self.link.release(TickRelease(tick, self._goals))
            self._released = tick
        self._goals = []

    def let_pass(self, tick: int) -> None:
        """Release a tick that is over without the robot: it would be late for each one after."""
        if self._released < self.tick < tick:
            self.release(self.tick)

    def on_status(self, status: RobotStatus) -> int:
        """Record that the robot lives; return the tick of the status."""
        if self.link is None and self._is_mute(self._status_tick):
            self.client.ask()
        self._heard_at = time.monotonic()
        self._status_tick = tick_of(status.stamp)
        return self._status_tick

    def _is_mute(self, tick: int) -> bool:
        is_late = tick - self._status_tick > MUTE_TICKS
        is_unheard = time.monotonic() - self._heard_at > MUTE_TIME
        return self.client.status is None or (is_late and is_unheard)

    # Goals

    def send(self, goal: NextGoal, tick: int, news: GoalNews) -> None:
        """Send a goal in place of any other."""
        self._goal, self._sent_at = goal, tick
        self._is_told = goal.stop.name != HOME
        if self._is_told:
            news.sent(self.client.name, goal, tick)
        later = start_text(goal.start_tick) if goal.start_tick > tick else ""
        message = NavigateToPose.Goal(
            pose=pose_stamped(goal.stop.pose_map, tick), behavior_tree=later
        )
        self._task = self.client.send("navigate_to_pose", NavigateToPose, message)
        self._goals.append(self._task.goal_id)

    def settle(self, tick: int, news: GoalNews) -> None:
        """Handle the end of the current goal, if it has come."""
        task, goal = self._task, self._goal
        if task is None or goal is None:
            return
        if self._report is None:
            self._settle_by_result(task, goal, tick, news)
            return
        for ended in self._report.ended:
            if ended.goal == task.goal_id:
                self._end(ended.is_reached, tick, ended.reason, news)
                return
        if self._report.goal != task.goal_id and self._sent_at < tick:
            self.send(goal, tick, news)  # its navigator was started again

    def _settle_by_result(self, task: Task, goal: NextGoal, tick: int, news: GoalNews) -> None:
        if task.is_forgotten:
            self.send(goal, tick, news)
        elif task.is_complete:
            self._end(task.outcome is TaskResult.SUCCEEDED, tick, task.reason, news)

    def _end(self, is_reached: bool, tick: int, reason: str, news: GoalNews) -> None:
        self._task = None
        again = self.courier.on_end(is_reached, tick, reason)
        for outcome in self.courier.outcomes[self._known :]:
            if outcome.stop.name != HOME:
                news.settled(self.client.name, outcome)
                self._is_told = False
        self._known = len(self.courier.outcomes)
        if again is not None:
            self.send(again, tick, news)

    @property
    def has_dropped_goal(self) -> bool:
        """Whether a goal that was told is replaced before its end."""
        return self._is_told and self._task is not None

    # Senses

    def _way_to(self, station: str) -> float:
        here = self._report
        if here is not None:
            return self._ways.length(here.x, here.y, station)
        status = self.client.status
        assert status is not None
        return self._ways.length(status.pose.x, status.pose.y, station)

    def _charge(self) -> float:
        if self._report is not None:
            return self._report.battery
        status = self.client.status
        return math.nan if status is None else float(status.battery)

    def _reach(self) -> float:
        if self._report is not None:
            return self._report.reach
        status = self.client.status
        is_charging = status is not None and status.state == CHARGING
        return 0.0 if is_charging else math.inf


class CourierProcess:
    """The robots of this process; they share nothing but the topic and the map."""

    def __init__(
        self,
        config: dict[str, Any],
        node: Node,
        channel: OrderChannel,
        events: EventWriter,
        rejections: Rejections,
    ) -> None:
        """Attach to the robots.

        Args:
            config: Configuration as `RunPlan.courier_configs` writes it.

        Raises:
            ConfigError: If mission, map or sites are unusable.
        """
        sites = load_sites(config["sites"])
        mission = load_mission(config["mission"]).with_groups(sites)
        assert mission.orders is not None
        stations = {name: sites.stations[name] for name in mission.orders.stations}
        grid = load_map(Path(config["map"])).upright().refined() if config["map"] else None
        marked = None if grid is None else sites.zones.mark(grid)
        ways = WayLengths(stations, marked, config["radius"])
        door = StatusCheck(rejections)
        self._robots: dict[str, OrderRobot] = {}
        for name, robot in config["robots"].items():
            courier = Courier(
                name,
                Pose(*robot["home"]),
                stations,
                retries=mission.retries,
                capacity=mission.orders.capacity,
                bids_for_all=mission.orders.dispatch != CLAIM,
            )
            client = RobotCommander(
                node,
                name,
                partial(self._on_status, name),
                with_feedback=False,
                door=door,
                watches_swarm=False,
            )
            self._robots[name] = OrderRobot(
                client,
                courier,
                ways,
                robot["speed"],
                node,
                rejections,
                is_in_step=config["is_in_step"],
            )
        self._channel = channel
        self._floor = FloorUse()
        self._events = events
        folder = config.get("trace_dir")
        log = StateLog(Journal(Path(folder) / FILE, is_shared=True)) if folder else None
        self._news = GoalNews(events, log)
        self._number: int = config["number"]
        self._stations: list[str] = config["ends_with"]  # processes
        self._has_begun = self._is_joining = self._is_done = False
        self._unreleased: list[OrderRobot] | None = None  # that have decided on the present tick

    def _on_status(self, name: str, status: RobotStatus) -> None:
        robot, pose = self._robots[name], status.pose
        tick = robot.on_status(status)
        self._floor.note(tick, name, pose.x, pose.y, robot.courier.share)

    @property
    def topics(self) -> Sequence[PolledTopic]:
        """Topics that bring what the present tick lacks."""
        tick, begun = self._channel.tick, self._channel.barrier.begun
        reports = [
            robot.link.topic
            for robot in self._robots.values()
            if robot.link is not None and robot.is_missing(tick, begun)
        ]
        return (*self._channel.topics, *reports)

    def turn(self) -> None:
        """Decide on each tick that may begin: hear, decide, send and release it."""
        now, channel = time.monotonic(), self._channel
        channel.poll()
        for robot in self._robots.values():
            robot.poll()
            robot.let_pass(channel.tick)
            channel.barrier.see(robot.tick)
        if not self._has_begun and not self._begin():
            return
        while self._is_closed(now) and (self._is_joining or channel.can_begin(now)):
            robots = self._robots.values()
            if any(robot.is_missing(channel.tick, channel.barrier.begun) for robot in robots):
                return
            self._decide()

    def _begin(self) -> bool:
        """Begin at the tick of the robots once goals would reach them; return whether they do."""
        robots = [robot for robot in self._robots.values() if robot.is_awaited]
        if any(not robot.client.isReady() or robot.is_unheard for robot in robots):
            return False
        barrier = self._channel.barrier
        self._channel.tick = max((r.tick for r in robots if r.tick >= 0), default=barrier.begun)
        self._is_joining = self._channel.tick > 0  # a run that is under way
        self._has_begun = True
        return True

    def _is_closed(self, now: float) -> bool:
        """Release the present tick; return whether the next one is the present one.

        Where the run ends with the last order, time stands still as soon as that is done.
        """
        if self._unreleased is None:
            return True
        if self._stations:
            are_over = self._channel.are_over(self._stations, now)
            if are_over and not self._is_done:
                self._is_done = True
                self._events.write(say.MissionDone())
            if are_over is not False:
                return False
        for robot in self._unreleased:
            robot.release(self._channel.tick)
        self._unreleased = None
        self._channel.tick += 1
        return True

    def _decide(self) -> None:
        """Let all robots hear, decide and send."""
        tick = self._channel.tick
        self._is_joining = False
        heard = self._channel.receive(list(self._robots))
        robots = {name: each for name, each in self._robots.items() if each.has_decided(tick)}
        sent: list[Envelope] = []
        for name, robot in robots.items():
            robot.settle(tick, self._news)
            for message in heard.get(name, ()):
                robot.courier.receive(message, tick)
            sent += self._ask(robot, tick)
        is_in_step = any(robot.link is not None for robot in robots.values())
        self._channel.send(sent, is_in_step=is_in_step)
        self._unreleased = list(robots.values())

    def _ask(self, robot: OrderRobot, tick: int) -> list[Envelope]:
        """Let a courier decide; return what it sends."""
        sent, goal = robot.courier.tick(tick, robot.senses)
        if goal is not None:
            if robot.has_dropped_goal:
                self._events.write(say.GoalWithdrawn(robot.client.name))
            robot.send(goal, tick, self._news)
        if robot.courier.events:
            told = [msgspec.to_builtins(event) for event in robot.courier.events]
            self._events.write(say.OrdersReported(told))
            robot.courier.events.clear()
        return sent

    def beat(self) -> None:
        """Report how floor and robots' time are used so far; ask for answers that are overdue."""
        self._events.write(say.FloorReported(self._number, self._floor.as_json()))
        for robot in self._robots.values():
            robot.client.look()

    def obey(self, command: say.MissionCommand) -> None:
        """Handle a message of swarm-up about a navigator."""
        robot = self._robots.get(command.robot)
        if robot is None:
            return
        robot.is_awaited = not isinstance(command, say.RobotSilent | say.RobotDead | say.RobotGone)
        if isinstance(command, say.RobotHeard):
            robot.client.ask()


if __name__ == "__main__":
    run_party("Couriers of robots with orders", "courier", CourierProcess)
