"""The command `swarm-teleop`: drives a robot of a running swarm by hand."""

from __future__ import annotations

import contextlib
import os
import select
import signal
import sys
import termios
import time
import tty
from collections.abc import Iterator
from typing import Annotated

import rclpy
import typer
from geometry_msgs.msg import Twist as TwistMsg
from nav2_msgs.action import AssistedTeleop
from rclpy.node import Node
from std_msgs.msg import Empty
from swarm_interfaces.msg import RobotStatus

from swarm_commander.cli.command_node import command_node, robots
from swarm_common.middleware.ros_io import RELIABLE
from swarm_common.model.errors import ConfigError
from swarm_common.model.records import Twist
from swarm_run.domain import domain_id, patience_for
from swarm_run.robots.client import RobotCommander
from swarm_run.robots.discovery import find_robots, read_parameters
from swarm_run.robots.swarm_watch import SwarmWatch
from swarm_run.robots.task import Task, TaskResult
from swarm_run.robots.teleop_keys import HELP, Keys

ACTION = ("assisted_teleop", AssistedTeleop)
PERIOD = 0.05  # [s] of wall time between two wishes
READY_LIMIT = 20.0  # [s] of wall time for the robot to take the goal
END_LIMIT = 5.0  # [s] of wall time for it to end
STATUS_PERIOD = 1.0  # [s] between two lines about the robot
ENDING = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)  # mean what Q means

teleop_app = typer.Typer(rich_markup_mode="rich")


@teleop_app.command(epilog="Example: swarm-teleop Srobot3 --speed 0.3")
def teleop(
    robot: Annotated[
        str, typer.Argument(autocompletion=robots, help="Name of the robot, like Srobot3.")
    ],
    speed: Annotated[
        float, typer.Option(help="Share of the robot's full speed to begin with, 0.1 to 1.")
    ] = 0.5,
) -> None:
    """Drive a robot by hand with the keys of this terminal.

    The robot turns and drives as you say, as far as nothing is in the way: it keeps its
    reservation, stops before walls, obstacles and the reservations of others, and goes on with
    its mission afterwards.

    Exit code: 0 you ended it, 1 the robot ended it, 2 bad input, 3 the swarm has ended.
    """
    if not 0.1 <= speed <= 1.0:
        raise ConfigError(f"--speed is {speed}; expected 0.1 to 1")
    with command_node("swarm_teleop") as node:
        running = find_robots(node, [robot], patience_for(domain_id()))
        if robot not in running:
            raise ConfigError(f"no robot '{robot}' is running; there are {', '.join(running)}")
        values = read_parameters(node, robot, ["max_vel_x", "max_vel_theta"])
        full = Twist(values[0].double_value, 0.0, values[1].double_value)
        keys = Keys(full)
        keys.share = speed
        raise typer.Exit(drive(node, robot, keys))


def drive(node: Node, name: str, keys: Keys) -> int:
    """Drive a robot by what is typed, until the operator or the robot ends it.

    Returns:
        The exit code.
    """
    for number in ENDING:
        signal.signal(number, lambda *_: keys.end())
    robot = RobotCommander(node, name, with_feedback=False)
    watch = SwarmWatch(node)
    wishes = node.create_publisher(TwistMsg, f"/{name}/cmd_vel_teleop", RELIABLE)
    end = node.create_publisher(Empty, f"/{name}/preempt_teleop", RELIABLE)
    deadline = time.monotonic() + READY_LIMIT
    while not (robot.offers(*ACTION) and wishes.get_subscription_count()):
        watch.check()
        if keys.is_over:
            return 0
        if time.monotonic() > deadline:
            raise ConfigError(f"{name} is not to be driven by hand; is its navigator active?")
        rclpy.spin_once(node, timeout_sec=PERIOD)
    task = robot.send(*ACTION, AssistedTeleop.Goal())
    try:
        _tell(f"{name} is yours\n{HELP}")
        with _typed() as descriptor:
            _steer(node, robot, task, keys, wishes, watch, descriptor)
    finally:
        deadline = time.monotonic() + END_LIMIT
        while not task.is_complete and time.monotonic() < deadline and not watch.look():
            end.publish(Empty())
            robot.look()
            rclpy.spin_once(node, timeout_sec=PERIOD)
        if not task.is_complete:
            task.cancel()
            rclpy.spin_once(node, timeout_sec=PERIOD)
    watch.check()
    if task.outcome is TaskResult.SUCCEEDED or not task.is_complete:
        _tell(f"{name} is on its own again")
        return 0
    message = getattr(task.result, "error_msg", "") or task.reason or task.outcome.name.lower()
    _tell(f"{name} took itself back: {message}")
    return 1


def _steer(
    node: Node,
    robot: RobotCommander,
    task: Task,
    keys: Keys,
    wishes: object,
    watch: SwarmWatch,
    descriptor: int,
) -> None:
    """Send what is wanted until it is over."""
    is_open, due = True, 0.0
    while not keys.is_over and not task.is_complete and not watch.look():
        now = time.monotonic()
        if is_open and select.select([descriptor], [], [], 0.0)[0]:
            text = _read(descriptor)
            is_open = bool(text)
            keys.press(text, now)
        wish = keys.wish(now)
        if not is_open and wish == Twist():
            return  # the terminal, or the other end of a pipe, is closed
        message = TwistMsg()
        message.linear.x, message.angular.z = wish.vx, wish.wz
        wishes.publish(message)  # type: ignore[attr-defined]
        robot.look()
        rclpy.spin_once(node, timeout_sec=PERIOD)
        if robot.status is not None and now >= due:
            due = now + STATUS_PERIOD
            _tell(f"\r{robot.name}  {_line(robot.status, keys)}\x1b[K", ends=False)
    _tell("")


def _read(descriptor: int) -> str:
    """Return what was typed; empty if the terminal or the pipe is closed."""
    try:
        return os.read(descriptor, 1024).decode(errors="replace")
    except OSError:  # of a terminal that was closed
        return ""


def _tell(text: str, *, ends: bool = True) -> None:
    """Write to the terminal; that it is closed must not keep the robot from being given back."""
    try:
        typer.echo(text, nl=ends)
    except OSError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


def _line(status: RobotStatus, keys: Keys) -> str:
    detail = f" ({status.detail})" if status.detail else ""
    place = f"x {status.pose.x:z.2f}  y {status.pose.y:z.2f}  yaw {status.pose.theta:z.2f}"
    return f"{place}  speed {100 * keys.share:.0f} %{detail}"


@contextlib.contextmanager
def _typed() -> Iterator[int]:
    """Yield the descriptor of the keyboard; each key comes at once and is not shown."""
    descriptor = sys.stdin.fileno()
    if not os.isatty(descriptor):
        yield descriptor
        return
    before = termios.tcgetattr(descriptor)
    tty.setcbreak(descriptor)
    try:
        yield descriptor
    finally:
        with contextlib.suppress(OSError, termios.error):  # the terminal may be closed
            termios.tcsetattr(descriptor, termios.TCSADRAIN, before)
