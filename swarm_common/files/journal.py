"""Append-only files of JSON lines: everything written stays readable if the writer is killed."""

from __future__ import annotations

import contextlib
import json
import os
from pathlib import Path
from typing import Any


class Journal:
    """Writes one JSON object per line, straight to the file.

    A process that is killed leaves all lines but perhaps half of the last one. A disk that is full
    ends the journal, not the run.
    """

    def __init__(self, path: str | Path, *, is_shared: bool = False) -> None:
        """Begin an empty file.

        Args:
            path: An old file is overwritten, unless others write to it.
            is_shared: Whether they do.

        Raises:
            OSError: If it cannot be written.
        """
        flags = os.O_WRONLY | os.O_CREAT | os.O_APPEND | os.O_CLOEXEC
        flags |= 0 if is_shared else os.O_TRUNC
        self._descriptor: int | None = os.open(path, flags, 0o644)

    def write(self, **values: Any) -> None:
        """Append a line.

        Raises:
            ValueError: If a number is not finite.
        """
        if self._descriptor is None:
            return
        line = json.dumps(values, separators=(",", ":"), allow_nan=False) + "\n"
        try:
            os.write(self._descriptor, line.encode())
        except OSError:
            self.close()

    def close(self) -> None:
        """End the file; later lines are dropped."""
        descriptor, self._descriptor = self._descriptor, None
        if descriptor is not None:
            with contextlib.suppress(OSError):
                os.close(descriptor)


def read_journal(path: Path) -> list[dict[str, Any]]:
    """Return the lines of a journal; none if there is no file, without those that are cut off."""
    try:
        text = path.read_text(encoding="utf-8", errors="replace")
    except OSError:
        return []
    lines = []
    for line in text.splitlines():
        with contextlib.suppress(ValueError, RecursionError):
            value = json.loads(line, parse_constant=_refuse)
            if isinstance(value, dict):
                lines.append(value)
    return lines


def _refuse(word: str) -> float:
    raise ValueError(f"{word} is no number")
