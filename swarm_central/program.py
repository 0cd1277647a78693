"""A program of others that runs for a limited time, and leaves no process behind."""

from __future__ import annotations

import os
import select
import signal
import subprocess
import time
from collections.abc import Sequence
from dataclasses import dataclass

from swarm_common.process.lifetime import die_with

MOST_KEPT = 4096  # bytes of what a program complains that are kept, the last ones
LONGEST_LINE = 200  # letters of its last line
CLEANUP_TIME = 0.2  # [s] for the last words of a program that has ended


@dataclass(frozen=True, slots=True)
class ProgramEnd:
    """Result of a program."""

    code: int | None  # exit code, negative for a signal; None if it was killed at its limit
    complaint: str  # last line on stderr; empty without one


def run_limited(command: Sequence[str], seconds: float) -> ProgramEnd:
    """Run a program until it ends or its time is up; its children are killed in any case.

    Args:
        command: The program and its arguments.
        seconds: [s] of wall time that it gets.

    Raises:
        OSError: If it cannot be started.
    """
    parent = os.getpid()
    process = subprocess.Popen(
        command,
        stdin=subprocess.DEVNULL,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
        start_new_session=True,
        preexec_fn=lambda: die_with(parent),
    )
    assert process.stderr is not None
    with process.stderr as stream:
        try:
            has_ended, heard = _follow(process.pid, stream.fileno(), time.monotonic() + seconds)
        finally:
            os.killpg(process.pid, signal.SIGKILL)  # the leader is not reaped yet: no other's group
            process.wait()
    lines = heard.decode(errors="replace").split("\n")
    complaint = next((line.strip() for line in reversed(lines) if line.strip()), "")
    return ProgramEnd(process.returncode if has_ended else None, complaint[:LONGEST_LINE])


def _follow(pid: int, stderr: int, deadline: float) -> tuple[bool, bytes]:
    """Wait for a program, without reaping it; return whether it has ended, and its last words."""
    heard, is_open, has_ended = b"", True, False
    while not has_ended and (left := deadline - time.monotonic()) > 0.0:
        if is_open and select.select([stderr], [], [], min(left, 0.02))[0]:
            data = os.read(stderr, MOST_KEPT)
            heard, is_open = (heard + data)[-MOST_KEPT:], bool(data)
        elif not is_open:
            time.sleep(min(left, 0.005))
        has_ended = os.waitid(os.P_PID, pid, os.WEXITED | os.WNOHANG | os.WNOWAIT) is not None
    deadline = time.monotonic() + CLEANUP_TIME
    while is_open and time.monotonic() < deadline and select.select([stderr], [], [], 0.0)[0]:
        data = os.read(stderr, MOST_KEPT)
        heard, is_open = (heard + data)[-MOST_KEPT:], bool(data)
    return has_ended, heard
