"""A robots' host towards the world's: a process of `swarm-up --role robots`.

python -m swarm_commander.hosts.host_client CONFIG.json --event-fd N --control-fd M
"""

from __future__ import annotations

import time
from pathlib import Path
from queue import SimpleQueue
from typing import Any, assert_never

from rclpy.node import Node
from std_msgs.msg import String

from swarm_commander.hosts.client_state import ClientState
from swarm_commander.hosts.host_link import LinkEnd, serve
from swarm_commander.hosts.host_table import (
    DESCRIPTION_TOPIC,
    HOSTS,
    REPORT_PERIOD,
    TABLE_TOPIC,
    HostReport,
)
from swarm_commander.hosts.link_probe import NOTHING, Asker, ProbeSocket
from swarm_common.middleware.ros_io import LATCHED, NEWEST
from swarm_common.middleware.sealed import ForgedError, Letter, Opener, Sealer
from swarm_common.process import messages as say
from swarm_common.process.pipes import EventWriter

FAREWELLS, FAREWELL_PAUSE = 3, 0.05  # times the last report is sent, as one may get lost; [s]


class HostClient(LinkEnd[say.ClientCommand]):
    """Hears description and table, and says how this host is."""

    def __init__(
        self, node: Node, config: dict[str, Any], events: EventWriter, secret: str
    ) -> None:
        super().__init__(events)
        self._descriptions, self._tables = (
            Opener(secret, DESCRIPTION_TOPIC),
            Opener(secret, TABLE_TOPIC),
        )
        self._sealer = Sealer(secret, HOSTS, config["host"])
        report = HostReport(config["host"], config["label"], ())
        self.state = ClientState(
            report, config["robots"], config["edition"], config["stated"], time.monotonic()
        )
        self._description_path = Path(config["description_path"])
        self._due = 0.0
        self._world_address = config["world_address"]
        self._asker = Asker(secret, config["host"])
        self._answers: SimpleQueue[tuple[bytes, float]] = SimpleQueue()  # heard in a thread; [s]
        self._probe = ProbeSocket(config["own_address"], config["domain"], self._receive_answer)
        self._found = ""
        self._reports = node.create_publisher(String, HOSTS, NEWEST)
        node.create_subscription(String, DESCRIPTION_TOPIC, self._receive_description, LATCHED)
        node.create_subscription(String, TABLE_TOPIC, self._receive_table, NEWEST)

    def receive_command(self, command: say.ClientCommand) -> None:
        """Obey swarm-up."""
        match command:
            case say.ReportActive(robot=robot):
                self.state.record_active(robot)
                self._due = 0.0
            case say.ReportDeath(robot=robot, returncode=code):
                self.state.record_death(robot, code)
                self._due = 0.0
            case say.ReportUsage(cpu=cpu, rss_mb=rss_mb):
                self.state.record_usage(cpu, rss_mb)
            case _:
                assert_never(command)

    def turn(self, now: float) -> None:
        """Send, receive and check what is due at wall time `now`."""
        events = self.state.look(now)
        self._pass_on(events)
        while not self._answers.empty():
            self._asker.take(*self._answers.get())
        if say.WorldSilent() in events:
            self._asker.restart()
        for question in self._asker.questions(now):
            self._probe.send(question, self._world_address)
        self._look_at_network(now)
        if now >= self._due:
            self._due = now + REPORT_PERIOD
            self._send(now)

    def _send(self, now: float) -> None:
        description, report = self.state.description, self.state.report(now)
        if description is not None and report is not None:
            self._reports.publish(String(data=self._sealer.seal(description.run, report)))

    def leave(self) -> None:
        """Say that this host leaves."""
        self.state.leave()
        self._due = 0.0

    @property
    def is_through(self) -> bool:
        """Whether the world's host knows, or there is none to tell."""
        return self.state.is_over or self.state.description is None

    def close(self) -> None:
        """Send the last report."""
        for _ in range(FAREWELLS):
            self._send(time.monotonic())
            time.sleep(FAREWELL_PAUSE)

        self._events.write(say.NetworkFigures(self._asker.figures(time.monotonic())))

    def _receive_answer(self, data: bytes, _: str) -> None:
        self._answers.put((data, time.monotonic()))

    def _look_at_network(self, now: float) -> None:
        """Say once what is wrong; before the world is there, no answer means nothing."""
        found, text = self._asker.finding(now)
        if found == NOTHING and not self.state.is_silent:
            return
        if found and found != self._found:
            self._events.write(say.NetworkFault(text))
        self._found = found or self._found

    def _receive_description(self, message: String) -> None:
        letter = self._open(self._descriptions, message)
        if letter is None:
            return
        text = str(letter.content["description"])
        events = self.state.receive_description(text, time.monotonic())
        if self.state.description is not None and self.state.description.run == letter.run:
            self._description_path.write_text(text, encoding="utf-8")
        self._pass_on(events)

    def _receive_table(self, message: String) -> None:
        letter = self._open(self._tables, message)
        if letter is None:
            return
        self._pass_on(self.state.receive_table(letter.run, letter.content, time.monotonic()))
        if self.state.is_over:
            self._due = 0.0

    def _open(self, opener: Opener, message: String) -> Letter | None:
        """Return the content of a message of the world's host; None if another host sent it."""
        try:
            return opener.open(message.data)
        except ForgedError:
            self._pass_on(self.state.record_forgery(time.monotonic()))
            return None


def main() -> None:
    """Run until SIGTERM, then say farewell."""
    serve(lambda config: f"agent_{config['host']}", HostClient, say.CLIENT)


if __name__ == "__main__":
    main()
