"""Signals that ask for the end, counted."""

from __future__ import annotations

import signal
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
