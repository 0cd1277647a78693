"""A robots' host towards the world's: a process of `swarm-up --role robots`.

python -m swarm_commander.agent CONFIG.json --event-fd N --control-fd M
"""

from __future__ import annotations

import json
import time
from pathlib import Path
from typing import Any

from rclpy.node import Node
from std_msgs.msg import String

from swarm_commander.envoy import Envoy
from swarm_commander.host_link import CHARTER, HOSTS, ROLL, LinkEnd, serve
from swarm_commander.roll import REPORT_PERIOD, HostReport
from swarm_common.pipes import EventWriter
from swarm_common.ros_io import LATCHED, RELIABLE


class Agent(LinkEnd):
    """Hears charter and roll, and says how this host is."""

    def __init__(self, node: Node, config: dict[str, Any], events: EventWriter) -> None:
        """Begin to look for the world's host; see `RobotsPlan.agent_config`."""
        super().__init__(events)
        report = HostReport(config["host"], config["label"], tuple(config["robots"]))
        self.envoy = Envoy(report, config["edition"], config["stated"], time.monotonic())
        self._charter_path = Path(config["charter_path"])
        self._due = 0.0
        self._reports = node.create_publisher(String, HOSTS, RELIABLE)
        node.create_subscription(String, CHARTER, self._take_charter, LATCHED)
        node.create_subscription(String, ROLL, self._take_roll, RELIABLE)

    def take_command(self, command: dict[str, Any]) -> None:
        """Obey a line from swarm-up."""
        if command["cmd"] == "active":
            self.envoy.note_active(command["robot"])
        elif command["cmd"] == "died":
            self.envoy.note_death(command["robot"], int(command["returncode"]))
        elif command["cmd"] == "usage":
            self.envoy.note_usage(command["cpu"], command["rss_mb"])
            return
        self._due = 0.0

    def turn(self, now: float) -> None:
        """Do what is due at wall time `now`."""
        self._pass_on(self.envoy.look(now))
        report = self.envoy.report
        if report is not None and now >= self._due:
            self._due = now + REPORT_PERIOD
            self._reports.publish(String(data=json.dumps(report)))

    def leave(self) -> None:
        """Say that this host leaves."""
        self.envoy.leave()
        self._due = 0.0

    @property
    def is_through(self) -> bool:
        """Whether the world's host knows, or there is none to tell."""
        return self.envoy.is_over or self.envoy.charter is None

    def close(self) -> None:
        """Send the last report, if it is due."""
        self.turn(time.monotonic())

    def _take_charter(self, message: String) -> None:
        events = self.envoy.take_charter(message.data, time.monotonic())
        if self.envoy.charter is not None:
            self._charter_path.write_text(message.data, encoding="utf-8")
        self._pass_on(events)

    def _take_roll(self, message: String) -> None:
        self._pass_on(self.envoy.take_roll(json.loads(message.data), time.monotonic()))
        if self.envoy.is_over:
            self._due = 0.0


def main() -> None:
    """Run until SIGTERM, then say farewell."""
    serve(lambda config: f"agent_{config['host']}", Agent)


if __name__ == "__main__":
    main()
