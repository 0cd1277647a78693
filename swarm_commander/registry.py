"""The world's host towards the robots' hosts: a process of `swarm-up --role world`.

python -m swarm_commander.registry CONFIG.json --event-fd N --control-fd M
"""

from __future__ import annotations

import contextlib
import json
import os
import signal
import sys
import time
from pathlib import Path
from typing import Any

import rclpy
from rclpy.experimental import EventsExecutor
from rclpy.node import Node
from std_msgs.msg import String

from swarm_commander.roll import REPORT_PERIOD, Roll, parse_report
from swarm_common.errors import SwarmError
from swarm_common.pipes import EventWriter, LineReader
from swarm_common.ros_io import LATCHED, RELIABLE

CHARTER, ROLL, HOSTS = "/sim/charter", "/sim/roll", "/sim/hosts"
FAREWELL = 4.0  # [s] of wall time for the hosts to say that they know of the end
TURN = 0.1  # [s]


class Registry:
    """Publishes charter and roll, and hears the hosts."""

    def __init__(self, node: Node, config: dict[str, Any], events: EventWriter) -> None:
        """Begin; `config` holds the charter."""
        charter = config["charter"]
        self._run = charter["run"]
        self._events = events
        self._roll = Roll(list(charter["robots"]))
        self._figures: dict[str, Any] = {}
        self._removed: list[str] = []
        self._is_over = False
        self._reason = ""
        self._due = 0.0
        self._charter = node.create_publisher(String, CHARTER, LATCHED)
        self._rolls = node.create_publisher(String, ROLL, RELIABLE)
        self._charter.publish(String(data=json.dumps(charter)))
        node.create_subscription(String, HOSTS, self._take_report, RELIABLE)

    @property
    def is_through(self) -> bool:
        """Whether every host that can hear knows of the end."""
        return self._roll.all_have_left

    def end(self) -> None:
        """Tell all hosts that the run is over."""
        self._is_over = True
        self._due = 0.0

    def take_command(self, command: dict[str, Any]) -> None:
        """Obey a line from swarm-up."""
        if command["cmd"] == "figures":
            self._figures = command["figures"]
        elif command["cmd"] == "removed":
            self._removed.append(command["robot"])
        elif command["cmd"] == "over":
            self._reason = command["reason"]

    def turn(self, now: float) -> None:
        """Do what is due at wall time `now`."""
        self._pass_on(self._roll.look(now))
        if now >= self._due:
            self._due = now + REPORT_PERIOD
            self._publish()

    def summary(self) -> list[dict[str, Any]]:
        """Return the hosts for the report."""
        return self._roll.summary()

    def _take_report(self, message: String) -> None:
        try:
            report = parse_report(json.loads(message.data))
        except (SwarmError, ValueError) as error:
            self._events.write("note", message=str(error))
            return
        events = self._roll.hear(report, time.monotonic())
        self._pass_on(events)
        if events:
            self._publish()

    def _pass_on(self, events: list[dict[str, Any]]) -> None:
        for event in events:
            values = {key: value for key, value in event.items() if key != "event"}
            self._events.write(event["event"], **values)

    def _publish(self) -> None:
        answer = {
            "run": self._run,
            "figures": self._figures,
            "removed": self._removed,
            "is_over": self._is_over,
            "reason": self._reason,
            **self._roll.answer(),
        }
        self._rolls.publish(String(data=json.dumps(answer)))


def main() -> None:
    """Run until SIGTERM, then say farewell."""
    config = json.loads(Path(sys.argv[1]).read_text(encoding="utf-8"))
    flags = dict(zip(sys.argv[2::2], sys.argv[3::2], strict=True))
    events = EventWriter(int(flags["--event-fd"]))
    commands = LineReader(int(flags["--control-fd"]))
    stopping: list[int] = []
    signal.signal(signal.SIGTERM, lambda number, _: stopping.append(number))
    rclpy.init(signal_handler_options=rclpy.SignalHandlerOptions.NO)
    node = rclpy.create_node(
        "registry", namespace="sim", enable_rosout=False, start_parameter_services=False
    )
    executor = EventsExecutor()
    executor.add_node(node)
    registry = Registry(node, config, events)
    deadline = float("inf")
    with contextlib.suppress(BrokenPipeError):
        while time.monotonic() < deadline:
            executor.spin_once(timeout_sec=TURN)
            for command in commands.read():
                registry.take_command(command)
            if stopping and deadline == float("inf"):
                deadline = time.monotonic() + FAREWELL
                registry.end()
            registry.turn(time.monotonic())
            if stopping and registry.is_through:
                break
        events.write("hosts", hosts=registry.summary())
    os._exit(0)  # everything of this process ends with it


if __name__ == "__main__":
    main()
