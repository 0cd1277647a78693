"""Watches the processes of a run from outside: threads, memory, and other users of the machine."""

from __future__ import annotations

import contextlib
import time
from collections.abc import Iterable
from pathlib import Path

import psutil

MEGABYTE = 1e6
NANOSECOND = 1e-9
DDS = "dds."  # with what Fast DDS begins the names of its threads
# everything else: other
MODULES = {"swarm_sim.ros.node": "world", "swarm_nav.launch.fork_server_main": "navigators"}


class ThreadTimes:
    """CPU seconds of the threads of a tree of processes, by group and by whether they are DDS's."""

    def __init__(self) -> None:
        self._seconds: dict[tuple[str, int, int], tuple[bool, float]] = {}

    def sample(self, processes: Iterable[psutil.Process]) -> None:
        """Read the present values; threads that have ended keep their last ones."""
        for process in processes:
            with contextlib.suppress(OSError, psutil.Error, ValueError):
                words = process.cmdline()
                group = next((own for name, own in MODULES.items() if name in words), "other")
                for task in Path(f"/proc/{process.pid}/task").iterdir():
                    nanoseconds = float((task / "schedstat").read_text().split()[0])
                    is_dds = (task / "comm").read_text().startswith(DDS)
                    key = (group, process.pid, int(task.name))
                    self._seconds[key] = (is_dds, nanoseconds * NANOSECOND)

    def totals(self) -> dict[str, tuple[float, float]]:
        """Return for each group the CPU seconds of all threads and of DDS's."""
        sums: dict[str, tuple[float, float]] = {}
        for (group, *_), (is_dds, seconds) in self._seconds.items():
            all_, dds = sums.get(group, (0.0, 0.0))
            sums[group] = (all_ + seconds, dds + (seconds if is_dds else 0.0))
        return sums


def dds_share(
    before: dict[str, tuple[float, float]], after: dict[str, tuple[float, float]]
) -> dict[str, float]:
    """Return the share, 0 to 1, of DDS threads in each group's CPU time between two totals."""
    shares = {}
    for group, (all_, dds) in after.items():
        all_before, dds_before = before.get(group, (0.0, 0.0))
        spent = all_ - all_before
        shares[group] = (dds - dds_before) / spent if spent > 0.0 else 0.0
    return shares


def proportional_mb(processes: Iterable[psutil.Process]) -> float:
    """Return the memory [MB] of processes, pages that are shared divided among their owners."""
    total = 0
    for process in processes:
        with contextlib.suppress(psutil.Error):
            total += process.memory_full_info().pss
    return total / MEGABYTE


class Neighbours:
    """How much of the machine's processors others use while something is measured."""

    def __init__(self) -> None:
        self._started = time.monotonic()
        self._busy = _busy()

    def share(self, own_cpu: float) -> float:
        """Return the share of all processors, 0 to 1, that others used since the beginning.

        `own_cpu` is the CPU time [s] of the measured processes.
        """
        capacity = (time.monotonic() - self._started) * (psutil.cpu_count() or 1)
        if capacity <= 0.0:
            return 0.0
        return min(1.0, max(0.0, (_busy() - self._busy - own_cpu) / capacity))


def _busy() -> float:
    times = psutil.cpu_times()
    return sum(times) - times.idle - getattr(times, "iowait", 0.0) - getattr(times, "guest", 0.0)
