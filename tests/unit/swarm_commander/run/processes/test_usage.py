"""Memory of a group of processes whose pages are mostly shared."""

import os
import time

import psutil
import pytest

from swarm_commander.run.processes import usage as module
from swarm_commander.run.processes.usage import MEMORY_SAMPLES, Usage, UsageMeter, memory_mb

SIZE = 40_000_000  # [bytes]


def test_the_memory_of_a_process_that_has_ended_is_what_it_was():
    """A run that ended by itself said "world 0.0 MB": the world had ended, unwaited for."""
    pid = os.fork()
    if not pid:
        time.sleep(60.0)
        os._exit(0)
    process, meter = psutil.Process(pid), UsageMeter()
    meter.sample("world", [process])
    os.kill(pid, 9)
    os.waitid(os.P_PID, pid, os.WEXITED | os.WNOWAIT)
    try:
        meter.sample_memory("world", [process])
        assert memory_mb([process]) == []
        assert (meter.memory_mb("world") or 0.0) > 0.0
        assert meter.private_mb("world") is None
    finally:
        os.waitpid(pid, 0)


def test_a_page_that_several_processes_share_counts_once():
    shared = bytearray(os.urandom(1)) * SIZE
    children = []
    for _ in range(3):
        pid = os.fork()
        if not pid:
            time.sleep(60.0)
            os._exit(0)
        children.append(pid)
    try:
        processes = [psutil.Process(pid) for pid in (os.getpid(), *children)]
        usage = Usage()
        for _ in processes:  # one is read at a time
            usage.sample(processes)
        together = sum(share for _, share in memory_mb(processes))
        assert usage.memory_mb == pytest.approx(together, rel=0.1)
        assert usage.rss_mb > usage.memory_mb + 2.5 * SIZE / 1e6
        usage.sample(processes[:1])
        assert usage.memory_mb < together
    finally:
        for pid in children:
            os.kill(pid, 9)
            os.waitpid(pid, 0)
    assert len(shared) == SIZE


def test_memory_is_read_seldom_and_right_after_the_start(monkeypatch):
    """Reading it at every sample took 1 % of a core."""
    read: list[int] = []

    def count(processes):
        read.extend(process.pid for process in processes)
        return [(1.0, 2.0)]

    monkeypatch.setattr(module, "memory_mb", count)
    meter, own = UsageMeter(), psutil.Process()
    for _ in range(2 * MEMORY_SAMPLES):
        meter.sample("world", [own])
    assert len(read) == 2
    meter.sample("world", [own])
    meter.mark()
    meter.sample("world", [own])
    assert len(read) == 4
    assert meter.memory_mb("world") == 2.0
