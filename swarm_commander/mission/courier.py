"""Process of one robot's courier, or of several that share it in a large swarm.

It bids for the orders that it hears of on `/orders`, and sends its robot where they lead.

python -m swarm_commander.mission.courier CONFIG.json --event-fd N --control-fd M
"""

from __future__ import annotations

import time
from functools import partial
from pathlib import Path
from typing import Any

import msgspec
from nav2_msgs.action import NavigateToPose
from rclpy.node import Node
from swarm_interfaces.msg import Mission as MissionMsg
from swarm_interfaces.msg import RobotStatus

from swarm_commander.mission.client import RobotCommander
from swarm_commander.mission.goal_news import GoalNews
from swarm_commander.mission.order_channel import OrderChannel
from swarm_commander.mission.order_party import run_party
from swarm_commander.mission.state_log import FILE, StateLog
from swarm_commander.mission.status_check import StatusCheck
from swarm_commander.mission.task import Task, TaskResult
from swarm_common.files.journal import Journal
from swarm_common.files.map_io import load_map
from swarm_common.files.sites_io import load_sites
from swarm_common.middleware.rejections import Rejections
from swarm_common.middleware.ros_io import LATCHED, pose_stamped, start_text, tick_of, time_msg
from swarm_common.model.records import Pose
from swarm_common.process.messages import (
    FloorReported,
    GoalWithdrawn,
    MissionCommand,
    OrdersReported,
    RobotDead,
    RobotGone,
    RobotHeard,
    RobotSilent,
)
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

# A robot says nothing after so long without a status; the status may wait in a busy machine.
MUTE_TICKS = 50
MUTE_TIME = 2.0  # [s] of wall time


class OrderRobot:
    """One robot: its courier, its client, and the goal that it was sent last.

    Attributes:
        is_dead: Whether it is gone, or its navigator is down.
    """

    def __init__(
        self, client: RobotCommander, courier: Courier, ways: WayLengths, speed: float, node: Node
    ) -> None:
        """Attach to a robot.

        Args:
            speed: [m/s] at most.
            node: For the topic that lets the robot begin.
        """
        self.client = client
        self.courier = courier
        self.senses = BidSenses(self._way_to, speed, self._charge)
        self.is_dead = False
        self._ways = ways
        self._task: Task | None = None
        self._goal: NextGoal | None = None
        self._heard_at = time.monotonic()  # wall time of its latest status
        self._tick = 0  # of its latest status
        self._known = 0  # outcomes that were told
        self._is_told = False  # whether the current goal was told
        self._mission = node.create_publisher(MissionMsg, f"/{client.name}/mission", LATCHED)

    def begin(self) -> None:
        """Let the robot answer ticks without goals."""
        self._mission.publish(MissionMsg(stamp=time_msg(0), active=False, goals_sent=0))

    def on_status(self, status: RobotStatus) -> int:
        """Take that it lives; return the tick of the status."""
        self._heard_at = time.monotonic()
        self._tick = tick_of(status.stamp)
        return self._tick

    def send(self, goal: NextGoal, tick: int, news: GoalNews) -> None:
        """Send a goal in place of any other."""
        self._goal = goal
        self._is_told = goal.stop.name != HOME
        if self._is_told:
            news.sent(self.client.name, goal, self._tick)
        later = start_text(goal.start_tick) if goal.start_tick > tick else ""
        message = NavigateToPose.Goal(
            pose=pose_stamped(goal.stop.pose_map, tick), behavior_tree=later
        )
        self._task = self.client.send("navigate_to_pose", NavigateToPose, message)

    def poll(self, tick: int, news: GoalNews) -> None:
        """Take the end of the current goal, if it has come."""
        task, goal = self._task, self._goal
        if task is None or goal is None or not task.is_complete:
            return
        self._task = None
        if task.is_forgotten:  # its navigator was started again
            self.send(goal, tick, news)
            return
        reached = task.outcome is TaskResult.SUCCEEDED
        again = self.courier.on_end(reached, tick, task.reason)
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

    def is_mute(self, tick: int) -> bool:
        """Whether nothing has been heard of the robot for too long."""
        is_late = tick - self._tick > MUTE_TICKS
        is_unheard = time.monotonic() - self._heard_at > MUTE_TIME
        return self.client.status is None or (is_late and is_unheard)

    def _way_to(self, station: str) -> float:
        status = self.client.status
        assert status is not None
        return self._ways.length(status.pose.x, status.pose.y, station)

    def _charge(self) -> float:
        status = self.client.status
        return float("nan") if status is None else float(status.battery)


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
            config: As `RunPlan.courier_configs` writes it.

        Raises:
            ConfigError: If mission, map or sites are unusable.
        """
        sites = load_sites(config["sites"])
        mission = load_mission(config["mission"]).with_groups(sites)
        assert mission.orders is not None
        stations = {name: sites.stations[name] for name in mission.orders.stations}
        grid = load_map(Path(config["map"])).upright() if config["map"] else None
        marked = None if grid is None else sites.zones.mark(grid)
        ways = WayLengths(stations, marked, config["radius"])
        door = StatusCheck(rejections)
        self._robots: dict[str, OrderRobot] = {}
        for name, robot in config["robots"].items():
            courier = Courier(
                name, Pose(*robot["home"]), stations, retries=mission.retries,
                capacity=mission.orders.capacity, bids_for_all=mission.orders.dispatch != CLAIM,
            )  # fmt: skip
            client = RobotCommander(
                node, name, partial(self._on_status, name), with_feedback=False, door=door,
                watches_swarm=False,
            )  # fmt: skip
            self._robots[name] = OrderRobot(client, courier, ways, robot["speed"], node)
        self._channel = channel
        self._floor = FloorUse()
        self._events = events
        folder = config.get("trace_dir")
        log = StateLog(Journal(Path(folder) / FILE, is_shared=True)) if folder else None
        self._news = GoalNews(events, log)
        self._number: int = config["number"]
        self._awaited = set(mission.orders.stations)
        self._has_begun = False

    def _on_status(self, name: str, status: RobotStatus) -> None:
        """Sample where a robot is."""
        robot, pose = self._robots[name], status.pose
        if robot.is_mute(self._channel.tick):
            robot.client.ask()
        tick = robot.on_status(status)
        self._floor.note(tick, name, pose.x, pose.y, robot.courier.share)

    def turn(self) -> None:
        """Let all robots hear, decide and send; they begin when all are there, and all stations."""
        if not self._channel.has_news:
            return
        tick = self._channel.tick
        heard = self._channel.receive(list(self._robots))
        if not self._has_begun:
            alive = [robot for robot in self._robots.values() if not robot.is_dead]
            is_ready = all(robot.client.isReady() for robot in alive)
            if not (is_ready and self._awaited <= self._channel.stations):
                return
            self._has_begun = True
            for robot in self._robots.values():
                robot.begin()
        sent: list[Envelope] = []
        for name, robot in self._robots.items():
            if robot.is_dead or robot.is_mute(tick):
                continue
            for message in heard.get(name, ()):
                robot.courier.receive(message, tick)
            sent += self._decide(robot, tick)
        self._channel.send(sent)

    def beat(self) -> None:
        """Report how floor and robots' time are used so far; ask for answers that are overdue."""
        self._events.write(FloorReported(self._number, self._floor.as_json()))
        for robot in self._robots.values():
            robot.client.look()

    def obey(self, command: MissionCommand) -> None:
        """Take what swarm-up knows of a navigator."""
        robot = self._robots.get(command.robot)
        if robot is None:
            return
        robot.is_dead = isinstance(command, RobotSilent | RobotDead | RobotGone)
        if isinstance(command, RobotHeard):
            robot.client.ask()

    def _decide(self, robot: OrderRobot, tick: int) -> list[Envelope]:
        robot.poll(tick, self._news)
        sent, goal = robot.courier.tick(tick, robot.senses)
        if goal is not None:
            if robot.has_dropped_goal:
                self._events.write(GoalWithdrawn(robot.client.name))
            robot.send(goal, tick, self._news)
        if robot.courier.events:
            told = [msgspec.to_builtins(event) for event in robot.courier.events]
            self._events.write(OrdersReported(told))
            robot.courier.events.clear()
        return sent


if __name__ == "__main__":
    run_party("Couriers of robots with orders", "courier", CourierProcess)
