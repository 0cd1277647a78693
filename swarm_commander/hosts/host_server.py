"""The world's host towards the robots' hosts: a process of `swarm-up --role world`.

python -m swarm_commander.hosts.host_server CONFIG.json --event-fd N --control-fd M
"""

from __future__ import annotations

import json
import sys
import time
from typing import Any, assert_never

import msgspec
from rclpy.node import Node
from std_msgs.msg import String

from swarm_commander.hosts.host_link import LinkEnd, serve
from swarm_commander.hosts.host_table import (
    DESCRIPTION_TOPIC,
    HOSTS,
    REPORT_PERIOD,
    TABLE_TOPIC,
    HostReport,
    HostTable,
    parse_report,
)
from swarm_commander.hosts.link_probe import Answerer, ProbeSocket
from swarm_common.middleware.rejections import Rejections
from swarm_common.middleware.ros_io import LATCHED, NEWEST
from swarm_common.middleware.sealed import ForgedError, Opener, Sealer
from swarm_common.model.errors import SwarmError
from swarm_common.process import messages as say
from swarm_common.process.pipes import EventWriter

FORGED = "host without the secret"
STALE = "host of another run"
UNREADABLE = "host's report"


class HostServer(LinkEnd[say.ServerCommand]):
    """Publishes the run's description and the table of hosts, and receives the hosts' reports."""

    def __init__(
        self, node: Node, config: dict[str, Any], events: EventWriter, secret: str
    ) -> None:
        super().__init__(events)
        description = config["description"]
        self._run = description["run"]
        self._answerer = Answerer(secret)
        self._probe = ProbeSocket(config["address"], config["domain"], self._answerer.answer)
        self._rejections = Rejections(events, lambda line: sys.stderr.write(line + "\n"))
        self._door = ReportCheck(secret, self._run, self._rejections)
        self._sealer = Sealer(secret, TABLE_TOPIC, self._run)
        self._table = HostTable(list(description["robots"]))
        self._figures: dict[str, Any] = {}
        self._removed: list[str] = []
        self._is_over = False
        self._reason = ""
        self._due = 0.0
        self._description = node.create_publisher(String, DESCRIPTION_TOPIC, LATCHED)
        self._tables = node.create_publisher(String, TABLE_TOPIC, NEWEST)
        sealed = Sealer(secret, DESCRIPTION_TOPIC, self._run).seal(
            self._run, {"description": json.dumps(description)}
        )
        self._description.publish(String(data=sealed))
        node.create_subscription(String, HOSTS, self._receive_report, NEWEST)

    @property
    def is_through(self) -> bool:
        """Whether every host that can hear knows of the end."""
        return self._table.all_have_left

    def leave(self) -> None:
        """Tell all hosts that the run is over."""
        self._is_over = True
        self._due = 0.0

    def receive_command(self, command: say.ServerCommand) -> None:
        """Obey swarm-up."""
        match command:
            case say.ShowFigures(figures=figures):
                self._figures = msgspec.to_builtins(figures)
            case say.RobotGone(robot=robot):
                self._removed.append(robot)
            case say.RunOver(reason=reason):
                self._reason = reason
            case _:
                assert_never(command)

    def turn(self, now: float) -> None:
        """Do what is due at wall time `now`."""
        self._pass_on(self._table.look(now))
        self._rejections.tell(now)
        for address in self._answerer.deaf():
            self._events.write(say.HostUnanswered(address))
        if now >= self._due:
            self._due = now + REPORT_PERIOD
            self._publish()

    def close(self) -> None:
        """Give swarm-up the hosts for the report."""
        self._rejections.flush()
        self._events.write(say.HostsSummary(self._table.summary()))

    def _receive_report(self, message: String) -> None:
        report = self._door.take(message.data)
        if report is None:
            return
        events = self._table.hear(report, time.monotonic())
        self._pass_on(events)
        if events:
            self._publish()

    def _publish(self) -> None:
        answer = {
            "figures": self._figures,
            "removed": self._removed,
            "is_over": self._is_over,
            "reason": self._reason,
            **self._table.answer(),
        }
        self._tables.publish(String(data=self._sealer.seal(self._run, answer)))


def main() -> None:
    """Run until SIGTERM, then say farewell."""
    serve(lambda _: "registry", HostServer, say.SERVER)


class ReportCheck:
    """Accepts reports that were made with the secret, for this run, and not heard before."""

    def __init__(self, secret: str, run: str, rejections: Rejections) -> None:
        self._run = run
        self._opener = Opener(secret, HOSTS)
        self._reject = rejections.reject

    def take(self, text: str) -> HostReport | None:
        """Return the report in a message; None for one that is not taken."""
        try:
            letter = self._opener.open(text)
            if letter is None:
                return None
            if letter.run == self._run:
                return parse_report(letter.content, letter.sender)
            self._reject(STALE, letter.sender, f"it is of {letter.run}, and leaves now")
        except ForgedError as error:
            self._reject(FORGED, "the network", error)
        except SwarmError as error:
            self._reject(UNREADABLE, letter.sender if letter else "", error)
        return None


if __name__ == "__main__":
    main()
