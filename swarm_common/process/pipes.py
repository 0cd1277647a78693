"""JSON lines through the pipes between swarm-up and its processes."""

from __future__ import annotations

import contextlib
import json
import os
from typing import Any


class LineReader:
    """Reader that never waits."""

    def __init__(self, descriptor: int) -> None:
        """Switch the descriptor to non-blocking."""
        os.set_blocking(descriptor, False)
        self._descriptor = descriptor
        self._partial = b""

    def read(self) -> list[dict[str, Any]]:
        """Return the objects that have arrived; a line that is not whole yet waits."""
        with contextlib.suppress(BlockingIOError):
            while chunk := os.read(self._descriptor, 65536):
                self._partial += chunk
        *lines, self._partial = self._partial.split(b"\n")
        return [json.loads(line) for line in lines if line.strip()]


class EventWriter:
    """Writer of `{"event": kind, ...}`; without a descriptor it writes nothing."""

    def __init__(self, descriptor: int | None) -> None:
        """Keep the descriptor of a pipe's writing end."""
        self._descriptor = descriptor

    def write(self, kind: str, **values: Any) -> None:
        """Write one event; nobody left to read it is not an error."""
        if self._descriptor is None:
            return
        data = json.dumps({"event": kind, **values}).encode() + b"\n"
        try:
            while data:
                data = data[os.write(self._descriptor, data) :]
        except BrokenPipeError:
            self._descriptor = None
