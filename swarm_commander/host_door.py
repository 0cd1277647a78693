"""Where messages of robots' hosts come in on the world's: nothing unsealed gets any further."""

from __future__ import annotations

from swarm_commander.roll import HOSTS, HostReport, parse_report
from swarm_common.errors import SwarmError
from swarm_common.sealed import ForgedError, Opener

FORGED = "host without the secret"
STALE = "host of another run"
UNREADABLE = "host's report"


class HostDoor:
    """Takes reports that were made with the secret, for this run, and not heard before.

    Attributes:
        rejected: How many were not taken, by kind.
    """

    def __init__(self, secret: str, run: str) -> None:
        """Take the secret of the hosts and the name of the run."""
        self.rejected: dict[str, int] = {}
        self._run = run
        self._opener = Opener(secret, HOSTS)
        self._notes: list[str] = []

    def take(self, text: str) -> HostReport | None:
        """Return the report in a message; None for one that is not taken."""
        try:
            letter = self._opener.open(text)
            if letter is None:
                return None
            if letter.run == self._run:
                return parse_report(letter.content, letter.sender)
            self._reject(STALE, "a robots' host of another run is still there; it leaves now")
        except ForgedError:
            note = "somebody without this run's secret asks for robots; he is not heard"
            self._reject(FORGED, note)
        except SwarmError as error:
            self._reject(UNREADABLE, str(error))
        return None

    def notes(self) -> list[str]:
        """Return what the user is to know of it, once for each kind."""
        notes, self._notes = self._notes, []
        return notes

    def _reject(self, kind: str, note: str) -> None:
        if kind not in self.rejected:
            self._notes.append(note)
        self.rejected[kind] = self.rejected.get(kind, 0) + 1
