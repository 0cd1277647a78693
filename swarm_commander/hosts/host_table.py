"""The list of robots' hosts on the world's host: their robots, silences and departures.

No clock, no I/O: `hear` takes a host's report, `look` notices silence, `answer` is the message to
all hosts. Every message holds the whole state, not a change, so that a lost message costs
only time.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from enum import Enum
from typing import Any

from swarm_common.model.errors import ConfigError
from swarm_common.process import messages as say

DESCRIPTION_TOPIC, TABLE_TOPIC, HOSTS = "/sim/charter", "/sim/roll", "/sim/hosts"  # topics
REPORT_PERIOD = 0.5  # [s] of wall time between two reports of each side
NOTICE_AFTER = 3.0  # [s] of silence that the user is told of
LOST_AFTER = 30.0  # [s] of silence after which the other side is given up


class HostState(Enum):
    """State of a host, as the world's host sees it."""

    SERVING = "serving"
    SILENT = "silent"
    LEFT = "left"
    LOST = "lost"


@dataclass(frozen=True, slots=True)
class HostReport:
    """The report of a robots' host about itself, twice a second."""

    host: str  # name of this start of swarm-up, different for each
    label: str  # name and address of the host, for people
    robots: tuple[str, ...]  # that it wants to serve
    active: tuple[str, ...] = ()  # those whose navigators are active
    died: Mapping[str, int] = field(default_factory=dict)  # return code of each navigator that died
    is_leaving: bool = False  # whether its user stopped it
    cpu: float = 0.0  # [s] used by its navigators
    rss_mb: float = 0.0  # their resident memory [MB]
    deaf_for: float = 0.0  # [s] for which it has not heard the world's host


def parse_report(data: Mapping[str, Any], sender: str) -> HostReport:
    """Return the report in a message.

    Raises:
        ConfigError: If the data is not a report, or speaks for another host.
    """
    try:
        lists = {name: tuple(data[name]) for name in ("robots", "active")}
        report = HostReport(**{**data, **lists})
        if report.host != sender:
            raise TypeError(f"{sender} speaks for {report.host}")
        return report
    except (KeyError, TypeError) as cause:
        raise ConfigError(f"a host sent something else than a report: {cause!r}") from cause


@dataclass(slots=True)
class _Host:
    report: HostReport
    heard_at: float
    state: HostState = HostState.SERVING
    silences: list[float] = field(default_factory=list)  # [s] that each lasted
    active: set[str] = field(default_factory=set)
    died: set[str] = field(default_factory=set)
    is_deaf: bool = False


class HostTable:
    """Tracks which hosts take part, and how long each has been silent."""

    def __init__(
        self,
        robots: Sequence[str],
        notice_after: float = NOTICE_AFTER,
        lost_after: float = LOST_AFTER,
    ) -> None:
        """Begin without hosts.

        Args:
            notice_after: [s] of silence that is worth a note.
            lost_after: [s] of silence after which a host is given up.
        """
        self._robots = tuple(robots)
        self._notice_after = notice_after
        self._lost_after = lost_after
        self._hosts: dict[str, _Host] = {}
        self._refused: dict[str, str] = {}

    def hear(self, report: HostReport, now: float) -> list[say.Event]:
        """Receive a host's report at wall time `now`; return the changes."""
        if report.host in self._refused:
            return []
        host = self._hosts.get(report.host)
        if host is None:
            return self._enlist(report, now)
        if host.state in (HostState.LEFT, HostState.LOST):
            return []
        events: list[say.Event] = []
        if host.state is HostState.SILENT:
            host.state = HostState.SERVING
            host.silences.append(round(now - host.heard_at, 3))
            events.append(say.HostHeard(*_who(report), host.silences[-1]))
        host.report, host.heard_at = report, now
        return events + self._news(host)

    def look(self, now: float) -> list[say.Event]:
        """Notice hosts that are silent, or have been for too long, at wall time `now`."""
        events: list[say.Event] = []
        for host in self._hosts.values():
            waited = now - host.heard_at
            if host.state is HostState.SERVING and waited > self._notice_after:
                host.state = HostState.SILENT
                events.append(say.HostSilent(*_who(host.report), waited))
            if host.state is HostState.SILENT and waited > self._lost_after:
                host.state = HostState.LOST
                host.silences.append(round(waited, 3))
                events.append(say.HostLost(*_who(host.report), host.silences[-1]))
        return events

    def answer(self) -> dict[str, Any]:
        """Return the state of each host by its name, and why others were refused."""
        states = {name: host.state.value for name, host in self._hosts.items()}
        return {"hosts": states, "refused": dict(self._refused)}

    def summary(self) -> list[dict[str, Any]]:
        """Return the hosts for the report."""
        return [
            {
                "host": host.report.label,
                "robots": list(host.report.robots),
                "standing": host.state.value,
                "silences": host.silences,
                "cpu_s": round(host.report.cpu, 3),
                "rss_mb": round(host.report.rss_mb, 1),
            }
            for host in self._hosts.values()
        ]

    @property
    def all_have_left(self) -> bool:
        """True if no host is left that should learn how the run ended."""
        states = [host.state for host in self._hosts.values()]
        return HostState.SERVING not in states

    def _enlist(self, report: HostReport, now: float) -> list[say.Event]:
        if report.is_leaving:
            return []
        for other in self._hosts.values():
            both = [robot for robot in report.robots if robot in other.report.robots]
            if both and other.state in (HostState.SERVING, HostState.SILENT):
                self._refused[report.host] = (
                    f"{both[0]} is on {other.report.label} already; choose other --robots"
                )
                return [say.HostRejected(*_who(report), self._refused[report.host])]
        self._hosts[report.host] = host = _Host(report, now)
        return [say.HostJoined(*_who(report)), *self._news(host)]

    def _news(self, host: _Host) -> list[say.Event]:
        report = host.report
        events: list[say.Event] = []
        is_deaf = report.deaf_for > self._notice_after
        if is_deaf and not host.is_deaf and not report.is_leaving:
            events.append(say.HostDeaf(*_who(report), report.deaf_for))
        host.is_deaf = is_deaf
        for robot in report.active:
            if robot not in host.active:
                host.active.add(robot)
                events.append(say.NavigatorActive(robot))
        for robot, code in report.died.items():
            if robot not in host.died:
                host.died.add(robot)
                events.append(say.NavigatorDied(robot, code, report.label))
        if report.is_leaving:
            host.state = HostState.LEFT
            events.append(say.HostLeft(*_who(report)))
        return events


def _who(report: HostReport) -> tuple[str, str, tuple[str, ...]]:
    return report.host, report.label, report.robots
