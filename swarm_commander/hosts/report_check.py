"""Where messages of robots' hosts reach the world's host; only sealed ones pass."""

from __future__ import annotations

from swarm_commander.hosts.host_table import HOSTS, HostReport, parse_report
from swarm_common.middleware.rejections import Rejections
from swarm_common.middleware.sealed import ForgedError, Opener
from swarm_common.model.errors import SwarmError

FORGED = "host without the secret"
STALE = "host of another run"
UNREADABLE = "host's report"


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
