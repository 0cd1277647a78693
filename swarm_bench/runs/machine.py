"""The machine that something was measured on, in one line."""

from __future__ import annotations

import functools
import platform
from pathlib import Path

import psutil

CPU_INFO = Path("/proc/cpuinfo")


def machine_line() -> str:
    """Return processor, cores and Python of this machine."""
    cores = psutil.cpu_count(logical=False) or psutil.cpu_count() or 1
    threads = psutil.cpu_count() or cores
    return f"{processor()}, {cores} cores, {threads} threads, Python {platform.python_version()}"


@functools.cache
def processor() -> str:
    """Return the model of this machine's processor."""
    try:
        lines = CPU_INFO.read_text(encoding="utf-8").splitlines()
    except OSError:
        lines = []
    for line in lines:
        name, _, value = line.partition(":")
        if name.strip() == "model name":
            return value.strip()
    return platform.machine()
