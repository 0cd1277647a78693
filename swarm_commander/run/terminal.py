"""Output that may end before the run does: a pipe into `head`, a terminal that is closed."""

from __future__ import annotations

import contextlib
import io
import os
import sys
from typing import IO, Any, TextIO, cast

from rich.console import Console


class Outlet(io.TextIOBase):
    """Writes to a stream until that fails; from then on to nowhere, and the run goes on.

    Attributes:
        is_open: Whether anybody may still read it.
    """

    def __init__(self, stream: TextIO) -> None:
        """Begin open.

        Args:
            stream: Like `sys.stdout`.
        """
        self._stream = stream
        self.is_open = True

    def write(self, text: str) -> int:
        """Write a text, or drop it.

        Returns:
            Number of characters, also of a text that is dropped.
        """
        if self.is_open:
            try:
                self._stream.write(text)
            except (OSError, ValueError):  # a full disk, a broken pipe; a closed or foreign stream
                self._close()
        return len(text)

    def flush(self) -> None:
        """Pass the text on."""
        if self.is_open:
            try:
                self._stream.flush()
            except (OSError, ValueError):
                self._close()

    def isatty(self) -> bool:
        """True if it is a terminal."""
        return self.is_open and self._stream.isatty()

    def fileno(self) -> int:
        """Return the descriptor of the stream."""
        return self._stream.fileno()

    @property
    def encoding(self) -> Any:  # type: ignore[override]
        """Encoding of the stream."""
        return self._stream.encoding

    def _close(self) -> None:
        """Redirect the stream to /dev/null, so that its buffered text causes no error."""
        self.is_open = False
        with contextlib.suppress(OSError, ValueError):
            nowhere = os.open(os.devnull, os.O_WRONLY)
            os.dup2(nowhere, self._stream.fileno())
            os.close(nowhere)


def console() -> Console:
    """Return a console on stdout that outlives its reader; brackets in a name are no markup."""
    return Console(file=cast(IO[str], Outlet(sys.stdout)), markup=False)


def complain(message: str) -> None:
    """Say something on stderr, if anybody listens."""
    outlet = Outlet(sys.stderr)
    outlet.write(f"swarm-up: {message}\n")
    outlet.flush()
