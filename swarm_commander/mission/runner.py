"""Mission process of `swarm-up`: drives all robots through their missions, or only watches them.

python -m swarm_commander.mission.runner CONFIG.json --event-fd N --control-fd M
"""

from __future__ import annotations

import contextlib
import math
import os
import sys
import time
from pathlib import Path
from typing import Any, assert_never

from swarm_interfaces.msg import RobotStatus

from swarm_commander.mission.state_log import FILE, GoalNews, StateLog
from swarm_common.files.journal import Journal
from swarm_common.middleware.participants import Hubs, prepare
from swarm_common.middleware.rclpy_compat import SafeExecutor, join_graph
from swarm_common.middleware.rejections import Rejections
from swarm_common.model.palette import BUSY_STATES
from swarm_common.model.records import CONTROL_PERIOD
from swarm_common.process import messages as say
from swarm_common.process.lifetime import LEASE, SleepWatch
from swarm_common.process.pipes import EventWriter, StartedProcess, leave
from swarm_mission.itinerary import Itinerary, NextGoal, StopOutcome
from swarm_mission.routes import routes
from swarm_recording.run_trace import RunTrace
from swarm_run.robots.discovery import NEWS_LIMIT
from swarm_run.robots.driver import RobotDriver, has_goal
from swarm_run.robots.status_check import StatusCheck

BEAT_PERIOD = 2.0  # [s] of wall time between two signs of life
TURN_PERIOD = 0.25  # [s] of wall time between two looks at everything else
LOST_TICKS = 100  # ticks without a status, while others go on, after which a robot is lost,
LOST_TIME = 5.0  # [s] if the wall clock, too, has moved on by this much
# [s] of wall time after which a silent robot's goals count as failed until it is heard again;
# longer than swarm-up takes to notice a navigator that hangs and to start another.
GIVE_UP_TIME = 60.0
LATE_STATUS = 2.0  # [s] of wall time to wait for the status of an end


class Runner:
    """All robots of a run."""

    def __init__(self, hubs: Hubs, config: dict[str, Any], events: EventWriter) -> None:
        """Attach to the robots.

        Args:
            hubs: Nodes that the robots are spread over.
            config: Configuration as `RunPlan.runner_config` writes it, with `resumed_at` and
                `settled` in place
                of another mission process that died.
        """
        self._hubs = hubs
        self._events = events
        self._stands_still_at_end = bool(config["stand_still_at_end"])
        self._rejections = Rejections(events, hubs.nodes[0].get_logger().warning)
        self._door = StatusCheck(self._rejections)
        self._drivers = {
            robot["name"]: RobotDriver(
                hubs.node_of(index), robot["name"], itinerary, self, door=self._door
            )
            for index, (robot, itinerary) in enumerate(
                zip(config["robots"], itineraries(config), strict=True)
            )
        }
        folder = config.get("trace_dir")
        self._state_log: StateLog | None = None
        if folder:
            self._state_log = StateLog(Journal(Path(folder) / FILE), RunTrace(Path(folder)))
        self._dead: set[str] = set()  # that will not be restarted
        self._silent: set[str] = set()  # whose current goal may be lost
        self._removed: set[str] = set()  # taken out by the operator: their goals do not count
        self._excused: set[str] = set()  # their host is silent: swarm-up decides about them
        self._fresh: set[str] = set()
        self._news = GoalNews(events, self._state_log)
        self._is_started = False
        self._is_connected = False  # or has waited in vain for some
        self._connected, self._connected_at = 0, 0.0  # robots so far, and when the last came
        # Of a mission process that goes on where another one died
        self._resumed_at = round(float(config.get("resumed_at", 0.0)) / CONTROL_PERIOD)
        self._is_done = False
        self._beat_at = 0.0
        self._heard_at: dict[str, float] = {}
        self._ended_at: dict[str, float] = {}
        if config["mission"] is not None:
            goals = sum(d.itinerary.total for d in self._drivers.values() if d.itinerary)
            events.write(say.MissionLoaded(goals))

    def turn(self) -> None:
        """Do the work that no message triggers: start, notice lost robots, pass on the status."""
        if time.monotonic() - self._beat_at > BEAT_PERIOD:
            self._beat_at = time.monotonic()
            self._events.write(say.Alive())
        if not self._is_connected:
            self._tell_when_connected()
        if not self._is_started:
            self._start_when_ready()
        self._notice_lost()
        self._flush()
        self._rejections.tell(time.monotonic())

    def receive_command(self, command: say.MissionCommand) -> None:
        """Obey swarm-up.

        Args:
            command: Decoded already; its `robot` may be new to us.
        """
        name = command.robot
        match command:
            case say.WatchRobot():
                self._dead.discard(name)
                self._removed.discard(name)
                if name not in self._drivers:
                    node = self._hubs.node_of(len(self._drivers))
                    self._drivers[name] = RobotDriver(node, name, None, self, door=self._door)
            case say.RobotSilent():
                self._excused.add(name)
                self._silent.add(name)
            case say.RobotHeard():
                self._excused.discard(name)
                self._silent.add(name)
                self._heard_at[name] = time.monotonic()
                self._hear_again(name)
            case say.RobotDead() | say.RobotGone():
                if name in self._drivers:
                    self._dead.add(name)
                    if isinstance(command, say.RobotGone):
                        self._removed.add(name)
                    self._drivers[name].lose()
            case _:
                assert_never(command)

    def finish(self) -> None:
        """Pass on the last status."""
        if self._state_log is not None:
            self._state_log.close()
        self._flush()
        self._rejections.flush()

    # What the drivers say

    def on_sent(self, driver: RobotDriver, order: NextGoal) -> None:
        """Count a goal when it is sent first.

        Args:
            driver: Driver of the robot whose goal it is.
            order: The goal; a second try of it is not counted again.
        """
        self._news.sent(driver.name, order, driver.tick)

    def on_settled(self, driver: RobotDriver, outcome: StopOutcome) -> None:
        """Pass a settled stop on.

        Args:
            driver: Driver of the robot whose stop it is.
            outcome: The stop, reached or missed for good.
        """
        if driver.name in self._removed:
            self._events.write(say.GoalWithdrawn(driver.name))
        else:
            self._news.settled(driver.name, outcome)

    def on_over(self, driver: RobotDriver) -> bool:
        """Say so when all are done; keep the last from answering so that time stands still.

        Args:
            driver: Driver of the robot whose mission is over.

        Returns:
            Whether the robot is to be released from lockstep.
        """
        if self._is_done or not all(d.is_over for d in self._drivers.values()):
            return True
        self._is_done = True
        self._flush()
        self._events.write(say.MissionDone())
        return not self._stands_still_at_end

    def on_status(self, driver: RobotDriver, status: RobotStatus) -> None:
        """Remember to pass it on.

        Args:
            driver: Driver of the robot that sent the status.
        """
        if self._state_log is not None:
            self._state_log.note(driver.name, status)
        self._fresh.add(driver.name)
        self._heard_at[driver.name] = time.monotonic()
        if driver.name not in self._excused:
            self._hear_again(driver.name)

    # Own work

    def _tell_when_connected(self) -> None:
        """Say so once all robots are heard, or no more of them have been found for a while."""
        count = sum(driver.robot.is_connected for driver in self._drivers.values())
        now = time.monotonic()
        if count != self._connected:
            self._connected, self._connected_at = count, now
        if count == len(self._drivers) or (count and now - self._connected_at > NEWS_LIMIT):
            self._is_connected = True
            self._events.write(say.SwarmHeard())

    def _start_when_ready(self) -> None:
        alive = [d for name, d in self._drivers.items() if name not in self._dead]
        has_mission = any(driver.itinerary is not None for driver in alive)
        if has_mission and all(driver.robot.isReady() for driver in alive):
            self._is_started = True
            for driver in alive:
                driver.start(max(self._resumed_at, driver.tick) if self._resumed_at else 0)

    def _hear_again(self, name: str) -> None:
        """Ask a robot that was silent for its goal, and give it back the goals that it lost."""
        if name not in self._silent or name not in self._drivers:
            return
        self._silent.discard(name)
        driver = self._drivers[name]
        driver.robot.ask()
        if self._is_done or name in self._removed:
            return
        self._dead.discard(name)
        count = driver.find()
        if count and driver.order is not None:
            goal = driver.order.stop.name
            self._events.write(say.GoalsRestored(name, count, goal))

    def _notice_lost(self) -> None:
        now = time.monotonic()
        latest = max((driver.tick for driver in self._drivers.values()), default=0)
        for name, driver in self._drivers.items():
            is_behind = driver.tick and latest - driver.tick > LOST_TICKS
            silence = now - self._heard_at.get(name, now)
            if is_behind and silence > LOST_TIME and name not in self._dead | self._excused:
                self._silent.add(name)
                if silence > GIVE_UP_TIME:
                    self._dead.add(name)
                    if not driver.is_over:
                        message = f"{name} is silent; its goals count as failed"
                        self._events.write(say.Note(message))
                        driver.lose()
            self._hurry(driver)
            driver.robot.look()

    def _hurry(self, driver: RobotDriver) -> None:
        if not driver.awaits_status:
            self._ended_at.pop(driver.name, None)
        elif time.monotonic() - self._ended_at.setdefault(driver.name, time.monotonic()) > (
            LATE_STATUS
        ):
            driver.settle_late()

    def _flush(self) -> None:
        for name in sorted(self._fresh):
            status = self._drivers[name].robot.status
            if status is not None:
                self._events.write(status_event(name, status))
        self._fresh.clear()


def status_event(robot: str, status: RobotStatus) -> say.StatusReported:
    """Return what swarm-up wants to know of a robot's status.

    Args:
        robot: Name of the robot, like `Srobot3`.
    """
    is_under_way = has_goal(status) and status.state not in BUSY_STATES
    return say.StatusReported(
        robot=robot,
        state=status.state,
        detail=status.detail,
        goal_map=(status.goal.x, status.goal.y) if is_under_way else None,
        sim_time=status.stamp.sec + 1e-9 * status.stamp.nanosec,
        hold_time=status.hold_time,
        wait_time=status.wait_time,
        goals_reached=status.goals_reached,
        goals_failed=status.goals_failed,
        pushes=status.pushes,
        retreats=status.retreats,
        deadlocks_resolved=status.deadlocks_resolved,
        replans=status.replans,
        number_of_recoveries=status.number_of_recoveries,
        battery=round(status.battery, 3) if math.isfinite(status.battery) else None,
    )


def itineraries(config: dict[str, Any]) -> list[Itinerary | None]:
    """Return each robot's mission; None for all if there is none, or if they have orders.

    Args:
        config: Configuration as `RunPlan.runner_config` writes it; `settled` has the number of
            stops that each
            robot has done.

    Returns:
        One per robot, in the order of `config["robots"]`.

    Raises:
        ConfigError: If a mission or the sites are unusable.
    """
    if config["mission"] is None or config.get("has_orders"):
        return [None for _ in config["robots"]]
    settled = config.get("settled", {})  # goals, by robot, of a mission process that died
    return [
        Itinerary(stops, mission.retries, int(settled.get(robot["name"], 0)))
        for robot, (mission, stops) in zip(config["robots"], routes(config), strict=True)
    ]


def main() -> None:
    """Run until SIGTERM."""
    child = StartedProcess("Missions of a swarm", say.MISSION)
    config, events = child.config, child.events
    count = len(config["robots"])
    profile = child.path.resolve().with_suffix(".xml")
    is_large = prepare(count, config.get("processes", count), profile)
    node = join_graph("mission")
    executor = SafeExecutor()
    hubs = Hubs(node, count, is_large=is_large)
    for each in hubs.nodes:
        executor.add_node(each)
    runner = Runner(hubs, config, events)
    if is_large:
        ports = hubs.ports([robot["name"] for robot in config["robots"]])
        peers = {name: [port] for name, port in ports.items()}
        events.write(say.MeetingPorts("mission", peers))
    due = 0.0
    watch = SleepWatch(LEASE)
    with contextlib.suppress(BrokenPipeError):
        while not child.is_stopping:
            executor.spin_once(timeout_sec=TURN_PERIOD)
            if slept := watch.slept():  # links that one side has forgotten do not come back
                sys.stderr.write(f"this process was stopped for {slept:.0f} s: it begins anew\n")
                sys.stderr.flush()
                os._exit(1)
            if time.monotonic() >= due:
                due = time.monotonic() + TURN_PERIOD
                for command in child.commands():
                    runner.receive_command(command)
                runner.turn()
        runner.finish()
    leave()


if __name__ == "__main__":
    main()
