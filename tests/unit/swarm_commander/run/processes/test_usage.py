"""Memory of a group of processes whose pages are mostly shared."""

import os
import time

import psutil
import pytest

from swarm_commander.run.processes.usage import Usage, UsageMeter, memory_mb

SIZE = 40_000_000  # [bytes]


def test_the_memory_of_a_process_that_has_ended_is_what_it_was() -> None:
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


def test_a_page_that_several_processes_share_counts_once() -> None:
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
