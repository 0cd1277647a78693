"""Signals that ask for the end: counted, or put off while a library is loaded.

The C++ of some libraries makes an ImportError of a Ctrl-C.
"""

from __future__ import annotations

import contextlib
import signal
import threading
from collections.abc import Iterator
from types import TracebackType
from typing import Any

NUMBERS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)


class SignalCounter:
    """In a `with` block: counts the signals that ask for the end, which then have no other effect.

    SIGHUP asks for nothing where whoever started us ignores it: nohup.

    Attributes:
        count: So far.
        latest: Number of the latest; 0 before the first.
    """

    def __init__(self) -> None:
        self.count = 0
        self.latest = 0
        self._before: dict[int, Any] = {}

    def __enter__(self) -> SignalCounter:
        is_nohup = signal.getsignal(signal.SIGHUP) is signal.SIG_IGN
        wanted = [n for n in NUMBERS if n != signal.SIGHUP or not is_nohup]
        self._before = {number: signal.signal(number, self._note) for number in wanted}
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        for number, handler in self._before.items():
            signal.signal(number, handler)

    def _note(self, number: int, _: object) -> None:
        self.count += 1
        self.latest = number


@contextlib.contextmanager
def late_interrupt() -> Iterator[None]:
    """Within it, SIGINT waits; it comes at the end. Other threads than the main one get none."""
    before = signal.getsignal(signal.SIGINT)
    if before is None or threading.current_thread() is not threading.main_thread():
        yield
        return
    pressed: list[int] = []
    signal.signal(signal.SIGINT, lambda number, _: pressed.append(number))
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, before)
        if pressed:
            signal.raise_signal(signal.SIGINT)
