"""The command `swarm-commander`: drives robots of a running swarm from another terminal."""

from __future__ import annotations

import math
import signal
import time
from dataclasses import dataclass
from functools import partial
from typing import Annotated

import rclpy
import typer
from rclpy.node import Node
from swarm_interfaces.msg import RobotStatus

from swarm_commander.cli.command_node import command_node, first_words, stations
from swarm_common.middleware.ros_io import tick_of
from swarm_common.model.errors import ConfigError, UnknownNameError, close_names
from swarm_common.model.records import Pose
from swarm_common.model.robot_names import FLEET_COMMANDS
from swarm_common.process.signals import SignalCounter
from swarm_mission.itinerary import Itinerary, NextGoal, StopOutcome
from swarm_mission.mission import Mission, load_mission, mission_names, single_goal, usual_mission
from swarm_run.domain import domain_id, patience_for
from swarm_run.robots.discovery import (
    find_robots,
    read_home,
    read_number,
    read_sites,
    robot_on_mission,
)
from swarm_run.robots.driver import RobotDriver, has_goal, sim_seconds
from swarm_run.robots.swarm_watch import SwarmWatch

PERIOD = 2.0  # [s] of simulated time between two lines that say the same
CANCEL_LIMIT = 2.0  # [s] of wall time for cancelled goals to end
READY_LIMIT = 20.0  # [s] of wall time for a robot to say where it is and to take goals
SAME_GOAL = 0.5  # [m] between two places that are one goal
CALM_PERIOD = 10.0  # [s] of simulated time between two lines of one robot among several

EXAMPLES = """Examples:

swarm-commander Srobot3

swarm-commander Srobot3 Srobot4 --mission loading_route

swarm-commander Srobot3 --to loader_2

swarm-commander Srobot3 --goal 2.0 1.5 0

swarm-commander spawn --help
"""
_goal = partial(typer.Option, rich_help_panel="Where to")

commander_app = typer.Typer(rich_markup_mode="rich")


@commander_app.command(epilog=EXAMPLES)
def command(
    robots: Annotated[
        list[str] | None,
        typer.Argument(autocompletion=first_words, help="Names of robots, like Srobot3."),
    ] = None,
    mission: Annotated[
        str | None,
        _goal(
            autocompletion=mission_names,
            help="Name or file of a mission.",
            show_default="loading_route, or the stations or places of this world, then home",
        ),
    ] = None,
    goal: Annotated[
        tuple[float, float, float] | None, _goal(help="X Y YAW in the map, instead of a mission.")
    ] = None,
    to: Annotated[
        str | None, _goal(autocompletion=stations, help="Name of a station, instead of a mission.")
    ] = None,
    seed: Annotated[int, _goal(help="Seed of the order of the stations.")] = 0,
    all_: Annotated[bool, typer.Option("--all", help="Drive every robot.")] = False,
) -> None:
    """Drive robots of a running swarm through a mission, or to one goal.

    Other commands: spawn, remove, move, list, reset, restart; see swarm-commander spawn --help.

    Exit code: 0 all goals reached, 1 a goal missed, 2 bad input, 3 the swarm has ended.
    """
    if robots and all_:
        raise ConfigError(f"{' '.join(robots)} and --all exclude each other")
    if not robots and not all_:
        raise ConfigError("name a robot, like Srobot3, or give --all")
    if sum(one is not None for one in (mission, goal, to)) > 1:
        raise ConfigError("--mission, --goal and --to exclude each other")
    plan = None if mission is None else load_mission(mission)
    if goal is not None:
        if not all(map(math.isfinite, goal)):
            raise ConfigError(f"--goal is {' '.join(map(str, goal))}; expected finite numbers")
        plan = single_goal(Pose(*goal))
    with command_node("swarm_commander") as node:
        running = find_robots(node, robots or [], patience_for(domain_id()))
        names = running if all_ else list(dict.fromkeys(robots or []))
        for name in names:
            if name not in running:
                close = close_names(name, FLEET_COMMANDS, 1)
                hint = f"; did you mean the command {close[0]}?" if close else ""
                there = ", ".join(running)
                raise ConfigError(f"no robot '{name}' is running; there are {there}{hint}")
        if to is not None:
            sites, where = read_sites(node, names[0])
            if to not in sites.stations:
                raise UnknownNameError("station", to, sites.stations, where)
            plan = single_goal(sites.stations[to])
        raise typer.Exit(Commander(node, names, calm=len(names) > 1).drive(plan, seed))


class Commander:
    """Drives some robots and prints their progress; a `Listener` of their drivers."""

    def __init__(self, node: Node, names: list[str], *, calm: bool) -> None:
        """Attach to the robots `names`; `calm` prints less about each."""
        self._node = node
        self._names = names
        self._drivers: dict[str, RobotDriver] = {}
        period = CALM_PERIOD if calm else 2.0
        self._narrators = {name: StatusConsole(name, period) for name in names}
        self._failed = 0
        self._watch = SwarmWatch(node)

    def drive(self, mission: Mission | None, seed: int) -> int:
        """Drive all robots through a mission, None for one of this world; return the exit code."""
        if mission is None or not mission.is_single_goal:
            self._refuse_if_busy()
        sites, where = read_sites(self._node, self._names[0])
        if mission is None:
            mission = usual_mission(sites, where)
        numbers = {name: read_number(self._node, name) for name in self._names}
        mission.check_stations(sites, where, highest=max(numbers.values()))
        homes = {n: read_home(self._node, n) or self._pose_of(n) for n in self._names}
        for name, home in homes.items():
            stops = mission.stops(sites, home, seed=seed, robot_id=numbers[name])
            itinerary = Itinerary(stops, mission.retries)
            self._drivers[name] = RobotDriver(
                self._node, name, itinerary, self, announces=not mission.is_single_goal
            )
        self._wait_until_ready()
        with SignalCounter() as signals:  # an exception may be lost or changed in rclpy
            drivers = self._drivers.values()
            for driver in drivers:
                driver.start()
            while not signals.count and not all(driver.is_over for driver in drivers):
                rclpy.spin_once(self._node, timeout_sec=0.2)
                self._watch.check()
                for driver in self._drivers.values():
                    driver.robot.look()
        if signals.count:
            self._abandon()
            signal.raise_signal(signals.latest)  # ends this process
        return 1 if self._failed else 0

    # Listener

    def on_sent(self, driver: RobotDriver, order: NextGoal) -> None:
        """Say where the robot is off to."""
        again = f", try {order.attempt}" if order.attempt > 1 else ""
        typer.echo(f"{driver.name}  {_goal_label(driver)}: sent{again}")

    def on_settled(self, driver: RobotDriver, outcome: StopOutcome) -> None:
        """Say how it went."""
        self._failed += not outcome.reached
        word = "reached" if outcome.reached else "FAILED"
        at = sim_seconds(outcome.tick)
        why = f": {outcome.reason}" if outcome.reason else ""
        typer.echo(f"{driver.name}  {outcome.stop.name}: {word} at t = {at:.1f} s{why}")

    def on_over(self, driver: RobotDriver) -> bool:
        """Say so; the robot is free."""
        typer.echo(f"{driver.name}  mission over")
        return True

    def on_status(self, driver: RobotDriver, status: RobotStatus) -> None:
        """Print waypoint, remaining distance and remaining time from time to time."""
        if driver.is_over or not has_goal(status) or not _is_own(driver, status):
            return
        line = self._narrators[driver.name].line(_goal_label(driver), _moment(status))
        if line is not None:
            typer.echo(line)

    # Own work

    def _pose_of(self, name: str) -> Pose:
        poses: list[Pose] = []
        subscription = self._node.create_subscription(
            RobotStatus,
            f"/{name}/status",
            lambda status: poses.append(Pose(status.pose.x, status.pose.y, status.pose.theta)),
            10,
        )
        deadline = time.monotonic() + READY_LIMIT
        while not poses:
            self._watch.check()
            if time.monotonic() > deadline:
                raise ConfigError(f"{name} does not say where it is; is its navigator alive?")
            rclpy.spin_once(self._node, timeout_sec=0.2)
        self._node.destroy_subscription(subscription)
        return poses[-1]

    def _refuse_if_busy(self) -> None:
        name = robot_on_mission(self._node, self._names)
        if name is not None:
            raise ConfigError(
                f"{name} is on a mission already;"
                " wait for its end, or start swarm-up without --mission"
            )

    def _wait_until_ready(self) -> None:
        deadline = time.monotonic() + READY_LIMIT
        for driver in self._drivers.values():
            while not driver.robot.isReady():
                self._watch.check()
                if time.monotonic() > deadline:
                    raise ConfigError(f"{driver.name} takes no goals; is its navigator active?")
                rclpy.spin_once(self._node, timeout_sec=0.1)

    def _abandon(self) -> None:
        typer.echo("stopping: goals are cancelled")
        for driver in self._drivers.values():
            driver.abandon()
        robots = [driver.robot for driver in self._drivers.values()]
        end = time.monotonic() + CANCEL_LIMIT
        while time.monotonic() < end and not all(robot.isTaskComplete() for robot in robots):
            rclpy.spin_once(self._node, timeout_sec=0.1)


def _is_own(driver: RobotDriver, status: RobotStatus) -> bool:
    """True if a robot is on its way to our goal, not to one that somebody else gave it since."""
    if driver.order is None:
        return False
    pose = driver.order.stop.pose_map
    return math.dist((status.goal.x, status.goal.y), (pose.x, pose.y)) < SAME_GOAL


def _goal_label(driver: RobotDriver) -> str:
    order, itinerary = driver.order, driver.itinerary
    if order is None or itinerary is None:
        return ""
    return f"{order.number}/{itinerary.total} {order.stop.name}"


def _moment(status: RobotStatus) -> Moment:
    return Moment(
        sim_time=sim_seconds(tick_of(status.stamp)),
        state=status.state,
        detail=status.detail,
        station=status.station,
        place=status.queue_place,
        distance=status.distance_remaining,
        time_left=status.estimated_time_remaining,
    )


@dataclass(frozen=True, slots=True)
class Moment:
    """A robot's status in its operator's words."""

    sim_time: float  # [s]
    state: str  # as in RobotStatus
    detail: str  # why
    station: str  # held or wanted
    place: int  # in the order of request; 0 for none
    distance: float  # [m] still to go
    time_left: float  # [s] estimated until arrival


class StatusConsole:
    """Decides which statuses of one robot are worth a line."""

    def __init__(self, robot: str, period: float = PERIOD) -> None:
        self._robot = robot
        self._period = period
        self._said = ""
        self._due = 0.0

    def line(self, goal: str, moment: Moment) -> str | None:
        """Return what to print now, if anything.

        Args:
            goal: Like ``3/8 loader_2``.
        """
        what = f"{goal}{moment.state}{moment.station}{moment.place}"
        if what == self._said and moment.sim_time < self._due:
            return None
        self._said = what
        self._due = moment.sim_time + self._period
        return f"{self._robot}  {goal:<16} {describe(moment)}"


def describe(moment: Moment) -> str:
    """Return a robot's status in words."""
    way = f"{moment.distance:.2f} m, {moment.time_left:.0f} s to go"
    if moment.state == "holding":
        place = f", place {moment.place}" if moment.place else ""
        words = f"holding for {moment.station or 'its goal'}{place}"
    else:
        words = moment.state
    detail = f" ({moment.detail})" if moment.detail else ""
    return f"{words}{detail}: {way}"
