"""The world's host towards the robots' hosts: a process of `swarm-up --role world`.

python -m swarm_commander.hosts.registry CONFIG.json --event-fd N --control-fd M
"""

from __future__ import annotations

import json
import sys
import time
from typing import Any, assert_never

import msgspec
from rclpy.node import Node
from std_msgs.msg import String

from swarm_commander.hosts.host_door import HostDoor
from swarm_commander.hosts.host_link import LinkEnd, serve
from swarm_commander.hosts.link_probe import Answerer, ProbeSocket
from swarm_commander.hosts.roll import CHARTER, HOSTS, REPORT_PERIOD, ROLL, Roll
from swarm_common.middleware.rejections import Rejections
from swarm_common.middleware.ros_io import LATCHED, NEWEST
from swarm_common.middleware.sealed import Sealer
from swarm_common.process.messages import (
    REGISTRY,
    HostsSummary,
    HostUnanswered,
    RegistryCommand,
    RobotGone,
    RunOver,
    ShowFigures,
)
from swarm_common.process.pipes import EventWriter


class Registry(LinkEnd[RegistryCommand]):
    """Publishes charter and roll, and hears the hosts."""

    def __init__(
        self, node: Node, config: dict[str, Any], events: EventWriter, secret: str
    ) -> None:
        """Begin; `config` holds the charter."""
        super().__init__(events)
        charter = config["charter"]
        self._run = charter["run"]
        self._answerer = Answerer(secret)
        self._probe = ProbeSocket(config["address"], config["domain"], self._answerer.answer)
        self._rejections = Rejections(events, lambda line: sys.stderr.write(line + "\n"))
        self._door = HostDoor(secret, self._run, self._rejections)
        self._sealer = Sealer(secret, ROLL, self._run)
        self._roll = Roll(list(charter["robots"]))
        self._figures: dict[str, Any] = {}
        self._removed: list[str] = []
        self._is_over = False
        self._reason = ""
        self._due = 0.0
        self._charter = node.create_publisher(String, CHARTER, LATCHED)
        self._rolls = node.create_publisher(String, ROLL, NEWEST)
        sealed = Sealer(secret, CHARTER, self._run).seal(
            self._run, {"charter": json.dumps(charter)}
        )
        self._charter.publish(String(data=sealed))
        node.create_subscription(String, HOSTS, self._take_report, NEWEST)

    @property
    def is_through(self) -> bool:
        """Whether every host that can hear knows of the end."""
        return self._roll.all_have_left

    def leave(self) -> None:
        """Tell all hosts that the run is over."""
        self._is_over = True
        self._due = 0.0

    def take_command(self, command: RegistryCommand) -> None:
        """Obey swarm-up."""
        match command:
            case ShowFigures(figures=figures):
                self._figures = msgspec.to_builtins(figures)
            case RobotGone(robot=robot):
                self._removed.append(robot)
            case RunOver(reason=reason):
                self._reason = reason
            case _:
                assert_never(command)

    def turn(self, now: float) -> None:
        """Do what is due at wall time `now`."""
        self._pass_on(self._roll.look(now))
        self._rejections.tell(now)
        for address in self._answerer.deaf():
            self._events.write(HostUnanswered(address))
        if now >= self._due:
            self._due = now + REPORT_PERIOD
            self._publish()

    def close(self) -> None:
        """Give swarm-up the hosts for the report."""
        self._rejections.flush()
        self._events.write(HostsSummary(self._roll.summary()))

    def _take_report(self, message: String) -> None:
        report = self._door.take(message.data)
        if report is None:
            return
        events = self._roll.hear(report, time.monotonic())
        self._pass_on(events)
        if events:
            self._publish()

    def _publish(self) -> None:
        answer = {
            "figures": self._figures,
            "removed": self._removed,
            "is_over": self._is_over,
            "reason": self._reason,
            **self._roll.answer(),
        }
        self._rolls.publish(String(data=self._sealer.seal(self._run, answer)))


def main() -> None:
    """Run until SIGTERM, then say farewell."""
    serve(lambda _: "registry", Registry, REGISTRY)


if __name__ == "__main__":
    main()
