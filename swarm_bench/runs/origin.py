"""Where a result comes from: which code, which inputs, which machine."""

from __future__ import annotations

import datetime
import functools
import platform
import subprocess
from pathlib import Path

from swarm_bench.runs.machine import processor
from swarm_common.process.compiled_code import edition
from swarm_run.record.run_record import ResultOrigin

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
