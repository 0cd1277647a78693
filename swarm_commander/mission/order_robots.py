"""The robots' side of orders: each robot's courier, over its own client and the topic `/orders`."""

from __future__ import annotations

import time
from collections.abc import Collection, Mapping
from pathlib import Path
from typing import Any

import msgspec
from nav2_msgs.action import NavigateToPose
from rclpy.node import Node
from swarm_interfaces.msg import Mission as MissionMsg
from swarm_interfaces.msg import RobotStatus

from swarm_commander.mission.driver import Listener, RobotDriver
from swarm_commander.mission.order_channel import OrderChannel
from swarm_commander.mission.task import Task, TaskResult
from swarm_common.files.map_io import load_map
from swarm_common.files.sites_io import load_sites
from swarm_common.middleware.rejections import Rejections
from swarm_common.middleware.ros_io import LATCHED, pose_stamped, start_text, tick_of, time_msg
from swarm_common.model.records import Pose
from swarm_common.process.messages import FloorReported, GoalWithdrawn, OrdersReported
from swarm_common.process.pipes import EventWriter
from swarm_mission.itinerary import NextGoal
from swarm_mission.leg import HOME
from swarm_mission.mission import load_mission
from swarm_mission.orders.courier import Courier
from swarm_mission.orders.dispatch import CLAIM
from swarm_mission.orders.floor_use import FloorUse
from swarm_mission.orders.messages import Announcement, Envelope
from swarm_mission.orders.radio import OrderRadio
from swarm_mission.orders.robot_bidder import BidSenses
from swarm_mission.orders.way_lengths import WayLengths

# A robot says nothing after so long without a status; the status may wait in a busy machine.
MUTE_TICKS = 50
MUTE_TIME = 2.0  # [s] of wall time


class OrderRobot:
    """One robot: its courier, its client, and the goal that it was sent last."""

    def __init__(
        self, driver: RobotDriver, courier: Courier, ways: WayLengths, speed: float, node: Node
    ) -> None:
        """Attach to a robot.

        Args:
            speed: [m/s] at most.
            node: For the topic that lets the robot begin.
        """
        self.driver = driver
        self.courier = courier
        self.senses = BidSenses(self._way_to, speed, self._charge)
        self._ways = ways
        self._task: Task | None = None
        self._goal: NextGoal | None = None
        self.heard_at = time.monotonic()  # wall time of its latest status
        self._known = 0  # outcomes that the listener has heard of
        self._is_told = False  # whether it has heard of the current goal
        self._mission = node.create_publisher(MissionMsg, f"/{driver.name}/mission", LATCHED)

    def begin(self) -> None:
        """Let the robot answer ticks without goals."""
        self._mission.publish(MissionMsg(stamp=time_msg(0), active=False, goals_sent=0))

    def send(self, goal: NextGoal, tick: int, listener: Listener) -> None:
        """Send a goal in place of any other."""
        self._goal = goal
        self._is_told = goal.stop.name != HOME
        if self._is_told:
            listener.on_sent(self.driver, goal)
        later = start_text(goal.start_tick) if goal.start_tick > tick else ""
        message = NavigateToPose.Goal(
            pose=pose_stamped(goal.stop.pose_map, tick), behavior_tree=later
        )
        robot = self.driver.robot
        self._task = robot.send("navigate_to_pose", NavigateToPose, message)

    def poll(self, tick: int, listener: Listener) -> None:
        """Take the end of the current goal, if it has come."""
        task, goal = self._task, self._goal
        if task is None or goal is None or not task.is_complete:
            return
        self._task = None
        if task.is_forgotten:  # its navigator was started again
            self.send(goal, tick, listener)
            return
        reached = task.outcome is TaskResult.SUCCEEDED
        again = self.courier.on_end(reached, tick, task.reason)
        for outcome in self.courier.outcomes[self._known :]:
            if outcome.stop.name != HOME:
                listener.on_settled(self.driver, outcome)
                self._is_told = False
        self._known = len(self.courier.outcomes)
        if again is not None:
            self.send(again, tick, listener)

    @property
    def has_dropped_goal(self) -> bool:
        """Whether a goal that the listener has heard of is replaced before its end."""
        return self._is_told and self._task is not None

    def is_mute(self, tick: int) -> bool:
        """Whether nothing has been heard of the robot for too long."""
        if self.driver.robot.status is None:
            return True
        is_late = tick - self.driver.tick > MUTE_TICKS
        return is_late and time.monotonic() - self.heard_at > MUTE_TIME

    def _way_to(self, station: str) -> float:
        status = self.driver.robot.status
        assert status is not None
        return self._ways.length(status.pose.x, status.pose.y, station)

    def _charge(self) -> float:
        status = self.driver.robot.status
        return float("nan") if status is None else float(status.battery)


class OrderRobots:
    """The robots of this process; they share nothing but the topic and the map."""

    def __init__(
        self,
        node: Node,
        config: dict[str, Any],
        drivers: Mapping[str, RobotDriver],
        listener: Listener,
        events: EventWriter,
        rejections: Rejections,
    ) -> None:
        """Attach to the robots.

        Args:
            config: As `RunPlan.runner_config` writes it, with `orders`.
            listener: Told of goals sent and settled.

        Raises:
            ConfigError: If mission, map or sites are unusable.
        """
        sites, orders = load_sites(config["sites"]), config["orders"]
        mission = load_mission(config["mission_file"]).with_groups(sites)
        assert mission.orders is not None
        stations = {name: sites.stations[name] for name in mission.orders.stations}
        grid = load_map(Path(orders["map"])).upright() if orders["map"] else None
        marked = None if grid is None else sites.zones.mark(grid)
        ways = WayLengths(stations, marked, orders["radius"])
        homes = {r["name"]: Pose(*config["homes"][r["number"] - 1]) for r in config["robots"]}
        self._robots = {
            name: OrderRobot(
                drivers[name],
                Courier(
                    name, home, stations, retries=mission.retries,
                    capacity=mission.orders.capacity, bids_for_all=mission.orders.dispatch != CLAIM,
                ),
                ways, orders["speeds"][name], node,
            )
            for name, home in homes.items()
        }  # fmt: skip
        radio = OrderRadio(orders["loss"], orders["delay"], config["seed"])
        self._channel = OrderChannel(node, radio, rejections)
        self._floor = FloorUse()
        self._listener = listener
        self._events = events
        self._unheard = set(mission.orders.stations)
        self._has_begun = False

    def on_status(self, name: str, status: RobotStatus) -> None:
        """Sample where a robot is."""
        if name in self._robots:
            self._robots[name].heard_at = time.monotonic()
            share = self._robots[name].courier.share
            pose = status.pose
            self._floor.note(tick_of(status.stamp), name, pose.x, pose.y, share)

    def turn(self, dead: Collection[str]) -> None:
        """Let all robots hear, decide and send; they begin when all are there, and all stations.

        Args:
            dead: Robots that are gone or silent.
        """
        if not self._channel.has_news:
            return
        tick = self._channel.tick
        heard = self._channel.receive(list(self._robots))
        if not self._has_begun:
            said = (message for each in heard.values() for message in each)
            self._unheard -= {m.station for m in said if isinstance(m, Announcement)}
            alive = [r for name, r in self._robots.items() if name not in dead]
            if self._unheard or not all(robot.driver.robot.isReady() for robot in alive):
                return
            self._has_begun = True
            for robot in self._robots.values():
                robot.begin()
        sent: list[Envelope] = []
        for name, robot in self._robots.items():
            if name in dead or robot.is_mute(tick):
                continue
            for message in heard.get(name, ()):
                robot.courier.receive(message, tick)
            sent += self._decide(robot, tick)
        self._channel.send(sent)

    def report(self) -> None:
        """Report how floor and robots' time are used so far."""
        self._events.write(FloorReported(self._floor.as_json()))

    def _decide(self, robot: OrderRobot, tick: int) -> list[Envelope]:
        robot.poll(tick, self._listener)
        sent, goal = robot.courier.tick(tick, robot.senses)
        if goal is not None:
            if robot.has_dropped_goal:
                self._events.write(GoalWithdrawn(robot.driver.name))
            robot.send(goal, tick, self._listener)
        if robot.courier.events:
            told = [msgspec.to_builtins(event) for event in robot.courier.events]
            self._events.write(OrdersReported(told))
            robot.courier.events.clear()
        return sent
