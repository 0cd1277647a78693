"""The process that makes vehicles of the robots: `python -m swarm_vda5050.process CONFIG.json`."""

from __future__ import annotations

import json
import time
from dataclasses import replace
from pathlib import Path
from typing import Any

import msgspec

from swarm_common.files.layout_io import read_layout
from swarm_common.files.map_io import load_map
from swarm_common.files.sites_io import load_sites
from swarm_common.files.storage import write_whole
from swarm_common.middleware import ros_env
from swarm_common.middleware.rclpy_compat import SafeExecutor, join_graph
from swarm_common.middleware.rejections import Rejections
from swarm_common.middleware.ros_poll import Waiter, drain
from swarm_common.model.battery import BatterySpec
from swarm_common.model.errors import ConfigError, SwarmError
from swarm_common.model.grid import OCCUPIED
from swarm_common.model.sites import Sites
from swarm_common.process.messages import (
    MISSION,
    FleetJudged,
    MissionCommand,
    Note,
    RobotDead,
    RobotGone,
    RobotHeard,
    RobotSilent,
    WatchRobot,
)
from swarm_common.process.pipes import EventWriter, StartedProcess, leave
from swarm_describe.robots.loading import load_robot
from swarm_run.robots.status_check import StatusCheck
from swarm_vda5050.broker import Broker
from swarm_vda5050.conformance import Conformance, summary
from swarm_vda5050.dialect import Identity
from swarm_vda5050.link import Address, Link
from swarm_vda5050.messages import OrderAction, Parameter
from swarm_vda5050.order_check import DrivingArea, regions_of
from swarm_vda5050.pilot import Pilot
from swarm_vda5050.tally import OrderTally, in_numbers
from swarm_vda5050.vehicle import LOG_FILE

VERDICT_FILE = "vda5050.json"  # in the run's folder
BROKER_PERIOD = 1.0  # [s] of wall time between two looks at our broker
MOST_TOPICS = 64  # that are waited for at once
MOST_UNKNOWN = 20  # names of robots that do not exist, of which the user is told
TURN_PERIOD = 0.05  # [s] of wall time between two looks at MQTT


class VehicleFleet:
    """All robots of a run as vehicles."""

    def __init__(self, config: dict[str, Any], events: EventWriter, folder: Path) -> None:
        """Attach to the robots.

        Args:
            config: Configuration as `process_table` writes it.
            folder: Folder of the run, for what logReport writes.
        """
        self._folder = folder
        self._config = config
        self._events = events
        self._node = join_graph("vda5050")
        self._rejections = Rejections(events, self._node.get_logger().warning)
        self._door = StatusCheck(self._rejections)
        self._grounds: dict[float, DrivingArea] = {}  # by the room [m] that a robot needs beside it
        self.conformance: Conformance | None = None
        if config["check"]:
            edges, places = None, {}
            if config["layout"] is not None:
                layout, _ = read_layout(Path(config["layout"]))
                edges = {(edge.start_node_id, edge.end_node_id) for edge in layout.edges}
                places = {each.node_id: (each.pose[0], each.pose[1]) for each in layout.nodes}
            self.conformance = Conformance(config["version"], self._say, edges, places)
        self._timed = timed_faults(config["faults"])
        self._address = Address(**config["broker"])
        self._pilots: dict[str, Pilot] = {}
        self.tallies: list[OrderTally] = []  # also of robots that are gone
        self._waiter = Waiter(self._node.context, MOST_TOPICS)
        self.executor = SafeExecutor()
        self.executor.add_node(self._node)
        every = self._identity_of("+")
        topics = [every.topic(name) for name in every.topics]
        self._overheard = Link(self._address, topics, None, "swarm")
        self._overheard.open()
        self._unknown: set[str] = set()  # robots that do not exist, but get messages
        for robot in config["robots"]:
            self._attach(robot["name"], robot["model"], robot.get("battery"))

    def wait(self) -> None:
        """Wait for robots to report, and decide on the ticks that they have reported."""
        topics = [pilot.topic for pilot in self._pilots.values() if pilot.topic is not None]
        if not topics:
            self.executor.spin_once(timeout_sec=TURN_PERIOD)
            return
        self._waiter.wait(topics[:MOST_TOPICS], TURN_PERIOD)
        for pilot in self._pilots.values():
            pilot.step()

    def turn(self) -> None:
        """Do what is due."""
        drain(self.executor)
        now = time.monotonic()
        for pilot in self._pilots.values():
            pilot.turn(now)
        while not self._overheard.inbox.empty():
            self._check_receiver(self._overheard.inbox.get().topic)

    def _check_receiver(self, topic: str) -> None:
        """Tell the user of a message for a robot that does not exist; nobody else answers it."""
        name = topic.split("/")[-2] if topic else ""
        is_new = name not in self._pilots and name not in self._unknown
        if topic and is_new and len(self._unknown) < MOST_UNKNOWN:
            self._unknown.add(name)
            known = ", ".join(self._pilots)
            self._events.write(Note(f"{topic}: there is no robot '{name:.80}'; there are {known}"))

    def obey(self, command: MissionCommand) -> None:
        """Handle a message of swarm-up about a robot."""
        name = command.robot
        match command:
            case WatchRobot():
                self._attach(name, self._config["newcomer"])
            case RobotSilent() | RobotDead():
                if name in self._pilots:
                    self._pilots[name].silence()
            case RobotHeard():
                if name in self._pilots:
                    self._pilots[name].hear()
            case RobotGone():
                if name in self._pilots:
                    self._pilots.pop(name).close()

    def close(self) -> None:
        """Disconnect all robots from the broker."""
        for pilot in self._pilots.values():
            pilot.close()

    def _write_log(self, line: bytes) -> None:
        with (self._folder / LOG_FILE).open("ab") as log:
            log.write(line + b"\n")

    def _say(self, text: str) -> None:
        self._events.write(Note(text))

    def _ground_for(self, room: float) -> DrivingArea:
        if room not in self._grounds:
            self._grounds[room] = ground_of(self._config, room)
        return self._grounds[room]

    def _identity_of(self, name: str) -> Identity:
        config = self._config
        return Identity(config["manufacturer"], name, config["version"], config["interface"])

    def _attach(self, name: str, model: str, battery: dict[str, Any] | None = None) -> None:
        if name in self._pilots:
            self._pilots[name].hear()
            return
        identity = self._identity_of(name)
        spec = load_robot(model)
        if battery is not None:  # that of a fleet
            spec = replace(spec, battery=msgspec.convert(battery, BatterySpec))
        self._pilots[name] = Pilot(
            self._node,
            identity,
            spec,
            self._ground_for(spec.inscribed_radius),
            self._address,
            door=self._door,
            is_realistic=self._config["realistic"],
            follows_edges=self._config["follows_edges"],
            names=self._pilots,
            note=self._say,
            judge=None if self.conformance is None else self.conformance.judge,
            is_lenient=self._config["check"] == "lenient",
            timed=[(at, action) for robot, at, action in self._timed if robot == name],
            log=self._write_log,
            rejections=self._rejections if self._config["is_in_step"] else None,
        )
        self.tallies.append(self._pilots[name].vehicle.tally)


def timed_faults(faults: list[dict[str, Any]]) -> list[tuple[str, float, OrderAction]]:
    """Return the robot, the time [s] and the instant action of each fault of a run's file."""
    return [
        (
            each["robot"],
            float(each["at"]),
            OrderAction(
                action_type=each["fault"],
                action_id=f"timed-{number}",
                action_parameters=tuple(
                    Parameter(key=key, value=value)
                    for key, value in each.items()
                    if key not in ("robot", "at", "fault")
                ),
            ),
        )
        for number, each in enumerate(faults, 1)
    ]


def ground_of(config: dict[str, Any], room: float) -> DrivingArea:
    """Return where robots may drive: free cells of the map, outside of keepout zones.

    Args:
        room: [m] that a robot needs beside it.
    """
    sites = load_sites(config["sites"]) if config["sites"] else Sites()
    grid = sites.zones.mark(load_map(config["map"]).upright())

    def obstacle_at(x: float, y: float) -> str:
        """Return what is in the way at a place; empty if it is free."""
        if not grid.contains(x, y):
            return "off the map"
        if grid.cells[grid.cell_of(x, y)] == OCCUPIED:
            return "in a wall"
        zone = sites.zones.keepout_at(x, y)
        return f"in {zone}" if zone else ""

    return DrivingArea(config["map_id"], obstacle_at, regions_of(grid, room), grid)


def main(arguments: list[str] | None = None) -> int:
    """Run until SIGTERM; returns the exit code."""
    child = StartedProcess("VDA 5050 vehicles of a swarm", MISSION, arguments)
    config, events = child.config, child.events
    broker: Broker | None = None
    try:
        if config["embedded"]:
            broker = Broker(config["broker"]["port"], child.path.parent)
        ros_env.set_defaults()
        fleet = VehicleFleet(config, events, child.path.parent.parent)
    except (SwarmError, ConfigError) as error:
        return child.refuse(error)
    events.write(Note(f"VDA 5050: {len(config['robots'])} robots at {Address(**config['broker'])}"))
    due = broker_due = 0.0
    verdict = child.path.parent.parent / VERDICT_FILE
    while not child.is_stopping:
        fleet.wait()
        if time.monotonic() >= due:
            due = time.monotonic() + TURN_PERIOD
            for command in child.commands():
                fleet.obey(command)
            fleet.turn()
            if broker is not None and time.monotonic() >= broker_due:
                broker_due = time.monotonic() + BROKER_PERIOD
                if broker.revive():
                    events.write(Note("the MQTT broker ended; it is started again"))
    fleet.close()
    if fleet.conformance is not None:
        report = fleet.conformance.report(config["check"], in_numbers(fleet.tallies))
        write_whole(verdict, json.dumps(report, indent=1) + "\n")
        is_failed = config["check"] == "strict" and bool(report["broken"])
        events.write(FleetJudged(summary(report), str(verdict), is_failed=is_failed))
    if broker is not None:
        broker.stop()
    return 0


if __name__ == "__main__":
    leave(main())
