"""A navigator that hangs before it is active."""

import os
import signal
import time
from collections.abc import Callable, Iterable

import psutil

FORK_SERVER = "swarm_nav.launch.fork_server_main"


def hang_one(processes: Callable[[], Iterable[int]], limit: float) -> int:
    """Stop the first navigator that is forked, as soon as it is there; return its process id.

    Args:
        processes: Returns the ids among which it will be.
        limit: [s] of wall time to wait for it.
    """
    end = time.monotonic() + limit
    while time.monotonic() < end:
        for pid in processes():
            if _is_navigator(pid):
                os.kill(pid, signal.SIGSTOP)
                return pid
        time.sleep(0.002)
    raise AssertionError("no navigator was forked")


def descendants(pid: int) -> Callable[[], list[int]]:
    return lambda: [child.pid for child in psutil.Process(pid).children(recursive=True)]


def _is_navigator(pid: int) -> bool:
    """Whether a process is a child of the fork server; both have the same command line."""
    try:
        process = psutil.Process(pid)
        parent = process.parent()
        return (
            parent is not None
            and FORK_SERVER in process.cmdline()
            and FORK_SERVER in parent.cmdline()
        )
    except psutil.Error:  # it has just ended
        return False
