"""Faults of our own that must not end the world: said once each, with where they happened."""

from __future__ import annotations

import sys
import traceback
from collections import Counter

from swarm_sim.refusal import shown

MOST_KINDS = 100  # of which the traceback is printed


class FaultLog:
    """Prints the traceback of each kind of fault once, to the log of the process.

    Attributes:
        counts: Faults by kind and place.
    """

    def __init__(self, what: str) -> None:
        """Begin without any; `what` went wrong when one is noted."""
        self._what = what
        self.counts: Counter[str] = Counter()

    def note(self, error: Exception) -> str:
        """Count a fault; return what to say to who caused it."""
        frame = traceback.extract_tb(error.__traceback__)[-1]
        key = f"{type(error).__name__} in {frame.name}, line {frame.lineno}"
        self.counts[key] += 1
        if self.counts[key] == 1 and len(self.counts) <= MOST_KINDS:
            sys.stderr.write(f"a {self._what} was dropped by a fault of ours: {key}\n")
            traceback.print_exception(error)
            sys.stderr.flush()
        return shown(f"fault of the world, {key}: {error}")
