"""Lifetime of processes: they end with their parent, and do not interrupt each other."""

from __future__ import annotations

import contextlib
import ctypes
import os
import signal
import time
from collections.abc import Callable

PR_SET_PDEATHSIG = 1
LEASE = 10.0  # [s] of sleep after which DDS forgets a process, and it the others (fastdds.xml)
BEGINS_ANEW = 75  # exit code of a process that others have forgotten; EX_TEMPFAIL in sysexits.h
_LIBC = ctypes.CDLL(None, use_errno=True)


def die_with(parent: int) -> None:
    """Let the kernel kill the calling process when its parent dies; call it after a fork.

    Args:
        parent: Process id of the parent, taken before the fork.
    """
    _LIBC.prctl(PR_SET_PDEATHSIG, signal.SIGKILL)
    if os.getppid() != parent:  # it died before the kernel knew
        os._exit(1)


class SleepWatch:
    """Notices that this process was stopped: wall time passed, and it did not compute."""

    BUSY = 0.05  # of a processor; who works for long does not sleep, nor do threads of DDS then

    def __init__(
        self,
        limit: float,
        clock: Callable[[], float] = time.monotonic,
        computed: Callable[[], float] = time.process_time,
    ) -> None:
        """Start awake.

        Args:
            limit: [s] of the shortest sleep that counts.
            computed: CPU time of this process [s].
        """
        self._limit, self._clock, self._computed = limit, clock, computed
        self._at, self._used = clock(), computed()

    def slept(self) -> float:
        """Return how long [s] it was stopped since the last call, 0 if it was not."""
        gap, used = self._clock() - self._at, self._computed() - self._used
        self._at, self._used = self._at + gap, self._used + used
        return gap if gap > self._limit and used < self.BUSY * gap else 0.0


def interrupt_nobody() -> None:
    """Let the calling process, and threads that it starts, run when others wait or are through.

    Messages wake robots one by one. A woken process would interrupt the one at work, to be put back
    soon by the next; where there are more robots than processors, all lose time by it. See
    SCHED_BATCH in sched(7).
    """
    with contextlib.suppress(OSError):  # forbidden in some containers
        os.sched_setscheduler(0, os.SCHED_BATCH, os.sched_param(0))
