"""Faults of our own, or of a library, that must not end a process: said once each, with where."""

from __future__ import annotations

import contextlib
import sys
import traceback
from collections import Counter

LONGEST_MESSAGE = 600  # letters; a message may quote an input of any length
MOST_KINDS = 100  # of which the traceback is printed


class FaultLog:
    """Prints the traceback of each kind of fault once, to the log of the process.

    Attributes:
        counts: Faults by kind and place.
    """

    def __init__(self, what: str) -> None:
        """Start without any.

        Args:
            what: Is dropped by a fault, like `message`; for the log.
        """
        self._what = what
        self.counts: Counter[str] = Counter()

    def note(self, error: Exception) -> str:
        """Count a fault, and print the traceback of the first of its kind.

        Returns:
            A message for the client that caused it.
        """
        frame = traceback.extract_tb(error.__traceback__)[-1]
        key = f"{type(error).__name__} in {frame.name}, line {frame.lineno}"
        self.counts[key] += 1
        if self.counts[key] == 1 and len(self.counts) <= MOST_KINDS:
            with contextlib.suppress(OSError):  # the disk of the log is full
                sys.stderr.write(f"a {self._what} was dropped by a fault of ours: {key}\n")
                traceback.print_exception(error)
                sys.stderr.flush()
        return shown(f"fault, {key}: {error}")


def shown(message: str) -> str:
    """Return a message without control characters, and not longer than anybody reads."""
    text = printable(message[: 2 * LONGEST_MESSAGE])
    if len(message) <= LONGEST_MESSAGE:
        return text
    half = LONGEST_MESSAGE // 2
    return f"{text[:half]} ... {shown(message[-half:])}"


def printable(message: str) -> str:
    """Return a message without control characters: it may quote an input of any letters."""
    return "".join(letter if letter.isprintable() or letter == "\n" else "?" for letter in message)
