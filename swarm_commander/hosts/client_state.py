"""A robots' host towards the world's: its reports, and its reaction to the answers.

No clock, no I/O; the counterpart of `host_table`.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict
from typing import Any

import msgspec

from swarm_commander.hosts.host_table import LOST_AFTER, NOTICE_AFTER, HostReport, HostState
from swarm_commander.hosts.run_description import RunDescription, parse
from swarm_common.model.errors import SwarmError
from swarm_common.process import messages as say

FIND_LIMIT = 600.0  # [s] of wall time for the world to answer first: hosts start in any order
HINT_AFTER = 20.0  # [s] of it after which the user is told what may be wrong
SECRET_LIMIT = 5.0  # [s] for the right world to answer, once one with another secret was heard


class ClientState:
    """The state of one robots' host in its exchange with the world's host.

    Attributes:
        description: Description of the run; None until the world's host has sent one that fits.
        is_over: Whether there is nothing more to be said: the run has ended, or was given up.
        silences: [s] that each silence of the world's host lasted.
    """

    def __init__(
        self,
        report: HostReport,
        numbers: Sequence[int],
        own_edition: str,
        stated: Mapping[str, Any],
        now: float,
        find_limit: float = FIND_LIMIT,
        lost_after: float = LOST_AFTER,
    ) -> None:
        """Begin to look for the world's host.

        Args:
            numbers: Numbers of the robots to serve, which the description names.
            stated: Facts that the user states about the run, see `RunDescription.facts`.
            now: Wall time [s].
            find_limit: [s] to find it in.
            lost_after: [s] of silence after which it is given up.
        """
        self.description: RunDescription | None = None
        self.is_over = False
        self.silences: list[float] = []
        self._report = asdict(report) | {"active": [], "died": {}}
        self._numbers = tuple(numbers)
        self._own_edition = own_edition
        self._stated = dict(stated)
        self._find_limit = find_limit
        self._lost_after = lost_after
        self._heard_at = now
        self._is_welcome = False
        self._is_silent = False
        self._has_hinted = False
        self._removed: set[str] = set()
        self._forged_at: float | None = None  # since when another secret is heard
        self._is_unheard = False

    def report(self, now: float) -> dict[str, Any] | None:
        """Return the next report; None before there is anything to report."""
        if self.description is None:
            return None
        return {**self._report, "deaf_for": round(now - self._heard_at, 3)}

    @property
    def is_silent(self) -> bool:
        """Whether the world's host was heard, and is not now."""
        return self._is_silent

    def record_active(self, robot: str) -> None:
        """A navigator has become active."""
        self._report["active"].append(robot)

    def record_death(self, robot: str, code: int) -> None:
        """A navigator has died."""
        self._report["died"][robot] = code

    def record_usage(self, cpu: float, rss_mb: float) -> None:
        """The navigators have used this much."""
        self._report |= {"cpu": cpu, "rss_mb": rss_mb}

    def leave(self) -> None:
        """The user wants this host to stop."""
        self._report["is_leaving"] = True

    def receive_description(self, text: str, now: float) -> list[say.Event]:
        """Receive the description of the run from the world's host."""
        if self._is_welcome or self.is_over:
            return []
        self._heard_at = now
        try:
            description = parse(text)
            description.check(self._own_edition, self._stated)
            self._report["robots"] = description.names_of(self._numbers)
        except SwarmError as error:
            return self._end(say.Refused(str(error)))
        self.description = description
        return []

    def record_forgery(self, now: float) -> list[say.Event]:
        """A sender without this host's secret speaks as a world's host; it is not obeyed.

        If no other world is heard, though, the two hosts have different secrets.
        """
        if self._forged_at is None:
            self._forged_at = now
        is_alone = now - max(self._heard_at, self._forged_at) > SECRET_LIMIT
        if self.is_over or not is_alone:
            return []
        if self._is_welcome:
            message = "the world's host is silent, and another with another secret is there"
            return self._end(say.WorldLost(message))
        return self._end(say.WorldHasOtherSecret())

    def receive_table(self, run: str, answer: Mapping[str, Any], now: float) -> list[say.Event]:
        """Receive the world's host's view of the hosts, and the progress of run `run`."""
        if self.description is None or self.is_over:
            return []
        if run != self.description.run:
            if not self._is_welcome:  # its description comes
                return []
            return self._end(say.WorldLost("another run has begun on the world's host"))
        events: list[say.Event] = []
        if self._is_silent:
            self._is_silent = False
            self.silences.append(round(now - self._heard_at, 3))
            events.append(say.WorldHeard(self.silences[-1]))
        self._heard_at = now
        own = self._report["host"]
        state = answer["hosts"].get(own)
        if own in answer["refused"]:
            return self._end(say.Refused(answer["refused"][own]))
        if state == HostState.LOST.value:
            message = "the world's host has given this one up after its silence"
            return self._end(say.WorldLost(message))
        if state == HostState.LEFT.value:
            return self._end()
        events += self._news(answer, state)
        is_unheard = state == HostState.SILENT.value
        if is_unheard and not self._is_unheard:
            events.append(say.WorldUnhearing())
        self._is_unheard = is_unheard
        if answer["is_over"]:
            self.leave()
            events += self._end(say.WorldOver(answer.get("reason", "")))
        return events

    def _news(self, answer: Mapping[str, Any], state: str | None) -> list[say.Event]:
        events: list[say.Event] = []
        if state is not None and not self._is_welcome:
            self._is_welcome = True
            events.append(say.WorldFound())
        if answer["figures"]:
            figures = msgspec.convert(answer["figures"], say.Figures)
            events.append(
                say.WorldProgress(figures.sim_time, figures.real_time_factor, figures.collisions)
            )
        for robot in answer["removed"]:
            if robot in self._report["robots"] and robot not in self._removed:
                self._removed.add(robot)
                events.append(say.RobotTakenOut(robot))
        return events

    def look(self, now: float) -> list[say.Event]:
        """Notice that the world's host is silent."""
        waited = now - self._heard_at
        if self.is_over:
            return []
        if not self._is_welcome:
            return self._poll_world(waited)
        events: list[say.Event] = []
        if waited > NOTICE_AFTER and not self._is_silent:
            self._is_silent = True
            events.append(say.WorldSilent())
        if waited > self._lost_after:
            message = f"nothing was heard of the world's host for {waited:.0f} s"
            events += self._end(say.WorldLost(message))
        return events

    def _poll_world(self, waited: float) -> list[say.Event]:
        if waited > self._find_limit:
            return self._end(say.WorldUnanswered(waited))
        if waited > HINT_AFTER and not self._has_hinted:
            self._has_hinted = True
            return [say.WorldUnansweredYet(waited)]
        return []

    def _end(self, *last: say.Event) -> list[say.Event]:
        self.is_over = True
        return list(last)
