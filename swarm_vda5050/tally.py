"""Orders of a run in numbers: how many ended, and how long robots stood without one."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any


@dataclass(slots=True)
class OrderTally:
    """Orders of one robot, and simulated times."""

    begun: int = 0
    given_up: int = 0  # cancelled, or ended by hand
    since: float = 0.0  # [s] at which the first one began
    until: float = 0.0  # [s] of the latest state
    idle: float = 0.0  # [s] without an order since then
    is_busy: bool = False

    def begin(self, now: float) -> None:
        """Count an order that begins."""
        self.since = self.since if self.begun else now
        self.begun += 1

    def pass_time(self, now: float, *, is_busy: bool) -> None:
        """Count the time since the last call.

        Args:
            now: Simulated time [s].
            is_busy: Whether the robot has an order that is neither done nor given up.
        """
        if self.begun and not is_busy:
            self.idle += now - max(self.until, self.since)
        self.until, self.is_busy = now, is_busy


def in_numbers(tallies: Sequence[OrderTally]) -> dict[str, Any]:
    """Return the orders of a run for `vda5050.json`.

    Args:
        tallies: One for each robot; those without an order do not count.
    """
    used = [each for each in tallies if each.begun]
    given_up, left = (sum(getattr(each, name) for each in used) for name in ("given_up", "is_busy"))
    done = sum(each.begun for each in used) - given_up - left
    hours = (max(t.until for t in used) - min(t.since for t in used)) / 3600.0 if used else 0.0
    time = sum(each.until - each.since for each in used)
    return {
        "done": done,
        "given_up": given_up,
        "open": left,
        "done_per_hour": round(done / hours, 1) if hours else None,
        "share_of_time_without_order": round(sum(t.idle for t in used) / time, 3) if time else None,
    }
