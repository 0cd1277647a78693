"""Where a result comes from: which code, which inputs, which machine."""

from __future__ import annotations

import datetime
import functools
import platform
import subprocess
from pathlib import Path

import psutil

from swarm_common.process.compiled_code import edition
from swarm_run.record.run_record import ResultOrigin

CPU_INFO = Path("/proc/cpuinfo")
# Packages whose code decides what a run of the bench is.
DECIDING = (
    "swarm_common", "swarm_describe", "swarm_nav", "swarm_mission", "swarm_sim", "swarm_central",
    "swarm_run",
    "swarm_bench/baselines", "swarm_bench/halls", "swarm_bench/runs",
)  # fmt: skip


def here(inputs: str = "") -> ResultOrigin:
    """Return the origin of a result that this process has made just now.

    Args:
        inputs: Hash of the run's inputs.
    """
    return ResultOrigin(
        commit=commit_of(Path(__file__).resolve().parents[2]),
        edition=bench_edition(),
        inputs=inputs,
        host=platform.node(),
        processor=processor(),
        date=datetime.datetime.now(datetime.UTC).isoformat(timespec="seconds"),
    )


@functools.cache
def bench_edition() -> str:
    """Return version and digest of the code that runs in the bench."""
    return edition(DECIDING)


@functools.cache
def commit_of(folder: Path) -> str:
    """Return a folder's commit, shortened, with -dirty after changes; empty outside a repository.

    Args:
        folder: Its top folder, or one in it.
    """
    command = ("git", "-C", str(folder), "describe", "--always", "--dirty", "--exclude", "*")
    try:
        return subprocess.run(command, capture_output=True, text=True, check=True).stdout.strip()
    except (OSError, subprocess.CalledProcessError):
        return ""


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
