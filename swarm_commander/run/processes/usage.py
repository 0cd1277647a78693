"""CPU time and memory of the processes of a run."""

from __future__ import annotations

import contextlib
import statistics
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field

import psutil

from swarm_common.files.journal import Journal

MEGABYTE = 1e6
MEMORY_SAMPLES = 5  # from one reading of known memory to the next: 5 to 10 ms, the process may wait


@dataclass(slots=True)
class Usage:
    """CPU seconds since the start and memory of a group of processes.

    Processes that have ended keep their last known CPU time.
    """

    cpu_by_pid: dict[int, float] = field(default_factory=dict)
    rss_mb: float = 0.0
    _share_by_pid: dict[int, float] = field(default_factory=dict)  # [MB], in order of reading
    _count: int = 0
    _samples: int = 0  # since the start or its end

    @property
    def cpu(self) -> float:
        """CPU seconds of all of them, user and system."""
        return sum(self.cpu_by_pid.values())

    @property
    def memory_mb(self) -> float:
        """Memory of all of them [MB], each shared page counted once."""
        shares = self._share_by_pid.values()
        return self._count * statistics.mean(shares) if shares else 0.0

    def sample(self, processes: Iterable[psutil.Process]) -> None:
        """Read the present values; of memory at most that of one process.

        Args:
            processes: All of the group that run; those that end meanwhile are skipped.
        """
        alive = list(processes)
        rss = 0
        for process in alive:
            try:
                with process.oneshot():
                    times = process.cpu_times()
                    rss += process.memory_info().rss
            except psutil.Error:
                continue
            self.cpu_by_pid[process.pid] = times.user + times.system
        self.rss_mb = max(self.rss_mb, rss / MEGABYTE)
        self._sample_share({process.pid: process for process in alive})

    def _sample_share(self, alive: Mapping[int, psutil.Process]) -> None:
        """Read the memory of a process that is new, or now and then of the one read longest ago."""
        known = {pid: share for pid, share in self._share_by_pid.items() if pid in alive}
        self._share_by_pid, self._count = known, len(alive)
        unread = [pid for pid in alive if pid not in known]
        is_due = self._samples % MEMORY_SAMPLES == 0
        self._samples += 1
        for pid in (unread or (list(known) if is_due else []))[:1]:
            known.pop(pid, None)
            known.update((pid, share) for _, share in memory_mb([alive[pid]]))

    def end_start(self) -> None:
        """Read memory at the next sample: that of the start was another."""
        self._samples = 0


def process_tree(pid: int | None) -> list[psutil.Process]:
    """Return a process and all of its descendants; nothing if it is gone.

    Args:
        pid: None for nothing.
    """
    if pid is None:
        return []
    try:
        root = psutil.Process(pid)
        return [root, *root.children(recursive=True)]
    except psutil.Error:
        return []


def memory_mb(processes: Iterable[psutil.Process]) -> list[tuple[float, float]]:
    """Return each process's memory [MB]: what it shares with no other, and its share of all.

    A page that k processes share counts as 1/k in the second, so that it can be added up. Slow to
    read.

    Returns:
        A pair for each process that could be read: private and shared out, in MB of 10^6 bytes.
    """
    sizes = []
    for process in processes:
        with contextlib.suppress(psutil.Error):
            memory = process.memory_full_info()
            if memory.pss:  # one that has ended, and not been waited for, has none
                sizes.append((memory.uss / MEGABYTE, memory.pss / MEGABYTE))
    return sizes


class UsageMeter:
    """Usage by group (`world`, `navigators`, `operator`), from `mark` on."""

    def __init__(self) -> None:
        self._groups: dict[str, Usage] = {}
        self._baseline: dict[str, float] = {}
        self._memory_mb: dict[str, list[tuple[float, float]]] = {}

    def sample(self, group: str, processes: Iterable[psutil.Process]) -> None:
        """Read the present values of a group.

        Args:
            group: `world`, `navigators`, `operator` or an onlooker's name.
        """
        self._groups.setdefault(group, Usage()).sample(processes)

    def sample_memory(self, group: str, processes: Iterable[psutil.Process]) -> None:
        """Read the memory of a group, once, at the end of a run."""
        self._memory_mb[group] = memory_mb(processes)

    def private_mb(self, group: str) -> float | None:
        """Return the median private memory of a group's processes [MB]; None if unknown."""
        sizes = self._memory_mb.get(group)
        return statistics.median(private for private, _ in sizes) if sizes else None

    def memory_mb(self, group: str) -> float | None:
        """Return the memory of a group [MB], each shared page counted once; None if unknown."""
        sizes = self._memory_mb.get(group)
        if sizes:
            return sum(share for _, share in sizes)
        return self._groups.get(group, Usage()).memory_mb or None  # sampled while it lived

    def mark(self) -> None:
        """Count CPU time from here on: start-up is over."""
        self._baseline = {name: usage.cpu for name, usage in self._groups.items()}
        for usage in self._groups.values():
            usage.end_start()

    @property
    def groups(self) -> dict[str, Usage]:
        """The measurements by name, since the very start."""
        return dict(self._groups)

    def cpu(self, group: str) -> float:
        """Return the CPU seconds of a group since `mark`."""
        usage = self._groups.get(group, Usage())
        return usage.cpu - self._baseline.get(group, 0.0)

    def rss_mb(self, group: str) -> float:
        """Return the largest resident memory of a group [MB]; shared pages count in each."""
        return self._groups.get(group, Usage()).rss_mb


class UsageLog:
    """CPU time, memory and the real-time factor over the wall clock, for the report."""

    def __init__(self, journal: Journal) -> None:
        """Begin to write.

        Args:
            journal: Open file, a JSON object per line.
        """
        self._journal = journal

    def write(self, wall: float, sim_time: float, factor: float, meter: UsageMeter) -> None:
        """Note a sample of the meter.

        Args:
            wall: [s] of wall time since the start.
            sim_time: [s] of simulated time.
            meter: Its CPU time is noted from the very start, not from its mark.
        """
        self._journal.write(
            wall=round(wall, 3),
            t=round(sim_time, 3),
            rtf=round(factor, 3),
            cpu={name: round(usage.cpu, 3) for name, usage in meter.groups.items()},
            memory_mb={name: round(usage.memory_mb, 1) for name, usage in meter.groups.items()},
        )
