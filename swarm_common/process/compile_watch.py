"""Tells how far numba has compiled, so that a first start does not look like a hang."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

PERIOD = 1.0  # [s] of wall time between two reports


@contextmanager
def watched(
    tell: Callable[[int, int], None],
    packages: tuple[str, ...],
    clock: Callable[[], float] = time.monotonic,
) -> Iterator[None]:
    """Report within it how many kernels are compiled or loaded, whenever one is compiled.

    Nothing is reported where all come from numba's cache.

    Args:
        tell: Receives the numbers of kernels that are ready, and of all.
    """
    from numba.core import event

    with event.install_listener("numba:compile", _watch(tell, packages, clock)):
        yield


def _watch(
    tell: Callable[[int, int], None], packages: tuple[str, ...], clock: Callable[[], float]
) -> Any:
    from numba.core import event

    class Watch(event.Listener):  # type: ignore[misc]  # numba has no types
        """Called by numba around each compilation."""

        due = float("-inf")

        def on_start(self, _: Any) -> None:
            if clock() >= self.due:
                self.due = clock() + PERIOD
                tell(*_counts(packages))

        def on_end(self, _: Any) -> None:
            """Be called when a kernel is ready; the next one tells."""

    return Watch()


def _counts(packages: tuple[str, ...]) -> tuple[int, int]:
    """Return how many kernels have been compiled or loaded, and how many there are."""
    from numba.core.dispatcher import Dispatcher

    kernels = {
        id(value): bool(value.signatures)
        for name, module in list(sys.modules.items())
        if module is not None and name.partition(".")[0] in packages
        for value in list(vars(module).values())
        if isinstance(value, Dispatcher)
    }
    return sum(kernels.values()), len(kernels)
