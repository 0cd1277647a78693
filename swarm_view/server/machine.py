"""How busy the machine is, for the panel."""

from __future__ import annotations

import psutil

PERIOD = 2.0  # [s] of wall time between two readings


class CpuMeter:
    """Reads the machine's load from time to time; costs nothing while the load is not asked for."""

    def __init__(self) -> None:
        self._due = 0.0
        self._text = ""

    def text(self, now: float) -> str:
        """Return the load since the last reading; `now` is wall time."""
        if now >= self._due:
            self._due = now + PERIOD
            share = psutil.cpu_percent()
            self._text = f"{share:.0f} % of this machine's {psutil.cpu_count()} cores"
        return self._text
