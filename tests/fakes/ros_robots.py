"""Fake robots with ROS but without world or navigation: they reach every goal in 20 ticks.

python -m tests.fakes.ros_robots COUNT [--fail NAME] [--mute NAME] [--homes]

Time goes on as in lockstep: it stands still while a robot whose mission is active has no goal.
`--fail` gives a robot whose every goal fails at the first try, `--mute` one that goes silent with
its first goal.
With `--homes` they know where they were started: at y = 7, not where they are. Once all are there,
a line says so.
"""

import argparse
import contextlib
import math
import sys
import time

import rclpy
from geometry_msgs.msg import Pose2D
from nav2_msgs.action import NavigateToPose
from rclpy._rclpy_pybind11 import RCLError
from rclpy.action import ActionServer, CancelResponse, GoalResponse
from rclpy.executors import ExternalShutdownException, SingleThreadedExecutor
from rclpy.node import Node
from rclpy.task import Future
from rosgraph_msgs.msg import Clock
from swarm_interfaces.msg import Mission, RobotStatus

from swarm_common.middleware.ros_io import LATCHED, RELIABLE, start_in, time_msg
from swarm_describe.worlds.world_file import find_world

DRIVE_TICKS = 20


class Robot:
    """One fake robot."""

    def __init__(self, name: str, number: int, *, fails: bool, is_mute: bool, homes: bool) -> None:
        self.node = Node("navigator", namespace=name)
        self.name = name
        self.is_mute = is_mute
        self.fails = fails
        self.mission_active = False
        self.goal: Pose2D | None = None
        self._has_had_goal = False
        self.start_tick = self.tick = 0
        self.reached = self.failed = 0
        self.station = ""
        self._pose = Pose2D(x=float(number), y=0.0, theta=0.0)
        self._tries: dict[tuple[float, float], int] = {}
        self._end: Future | None = None
        sites = find_world("slim_blockage").parent / "sites.yaml"
        self.node.declare_parameter("sites", str(sites))
        if homes:
            for axis, value in zip(("x", "y", "yaw"), (float(number), 7.0, 0.0), strict=True):
                self.node.declare_parameter(f"initial_pose.{axis}", value)
        self._status = self.node.create_publisher(RobotStatus, "status", RELIABLE)
        self.node.create_subscription(Mission, "mission", self._receive_mission, LATCHED)
        self._server = ActionServer(
            self.node,
            NavigateToPose,
            "navigate_to_pose",
            self._execute,
            goal_callback=lambda _: GoalResponse.ACCEPT,
            cancel_callback=self._cancel,
        )

    @property
    def withholds(self) -> bool:
        return self.mission_active and self.goal is None and not self.is_silent

    @property
    def is_silent(self) -> bool:
        return self.is_mute and self._has_had_goal

    def step(self, tick: int) -> None:
        self.tick = tick
        if self.is_silent:
            return
        if self.goal is not None and tick >= self.start_tick + DRIVE_TICKS:
            key = (self.goal.x, self.goal.y)
            self._tries[key] = self._tries.get(key, 0) + 1
            self.finish("aborted" if self.fails and self._tries[key] == 1 else "succeeded")
        elif tick % 5 == 0:
            self.publish()

    def finish(self, outcome: str) -> None:
        if outcome == "succeeded":
            self.reached += 1
            self._pose = self.goal or self._pose
        elif outcome == "aborted":
            self.failed += 1
        self.goal = None
        if outcome != "preempted":
            self.publish()
        if self._end is not None:
            self._end.set_result(outcome)
            self._end = None

    def publish(self) -> None:
        status = RobotStatus(stamp=time_msg(self.tick), robot=self.name, pose=self._pose)
        status.state = "idle" if self.goal is None else "driving"
        if self.goal is not None and self.tick < self.start_tick + DRIVE_TICKS // 2:
            status.state, status.station, status.queue_place = "holding", "loader_3", 2
        status.goal = self.goal or Pose2D(x=math.nan, y=math.nan, theta=math.nan)
        status.goals_reached, status.goals_failed = self.reached, self.failed
        status.battery = math.nan
        status.hold_time = 0.5 * self.reached
        status.distance_remaining = 0.1 * max(0, self.start_tick + DRIVE_TICKS - self.tick)
        self._status.publish(status)

    def _receive_mission(self, message: Mission) -> None:
        self.mission_active = message.active

    def _cancel(self, _: object) -> CancelResponse:
        self.finish("aborted")
        return CancelResponse.ACCEPT

    async def _execute(self, handle: object) -> NavigateToPose.Result:
        if self.goal is not None:
            self.finish("preempted")
        pose = handle.request.pose
        self.goal = Pose2D(x=pose.pose.position.x, y=pose.pose.position.y, theta=0.0)
        self._has_had_goal = True
        self.start_tick = max(self.tick, start_in(handle.request.behavior_tree))
        self.publish()
        self._end = Future()
        handle.publish_feedback(NavigateToPose.Feedback(distance_remaining=1.0))
        outcome = await self._end
        if outcome == "succeeded":
            handle.succeed()
        else:
            # A handle may only be cancelled after a request; a preempted one is aborted.
            handle.abort()
        return NavigateToPose.Result(error_code=0 if outcome == "succeeded" else 105)


def main() -> None:
    parser = argparse.ArgumentParser()
    parser.add_argument("count", type=int)
    parser.add_argument("--fail", default="")
    parser.add_argument("--mute", default="")
    parser.add_argument("--homes", action="store_true")
    options = parser.parse_args()
    rclpy.init()
    executor = SingleThreadedExecutor()
    robots = []
    for number in range(1, options.count + 1):
        name = f"Srobot{number}"
        moods = {"fails": name == options.fail, "is_mute": name == options.mute}
        robots.append(Robot(name, number, **moods, homes=options.homes))
        executor.add_node(robots[-1].node)
    clock = robots[0].node.create_publisher(Clock, "/clock", RELIABLE)
    sys.stdout.write("ready\n")
    sys.stdout.flush()
    tick = 0
    due = time.monotonic()
    while rclpy.ok():
        with contextlib.suppress(ExternalShutdownException, RCLError):
            executor.spin_once(timeout_sec=0.005)
        if time.monotonic() >= due and not any(robot.withholds for robot in robots):
            due = time.monotonic() + 0.01
            tick += 1
            with contextlib.suppress(RCLError):
                clock.publish(Clock(clock=time_msg(tick)))
            for robot in robots:
                robot.step(tick)


if __name__ == "__main__":
    main()
