"""One run of `benchmarks scale` in a process of its own that prints its result as JSON."""

from __future__ import annotations

import dataclasses
import json
import os
import resource
import subprocess
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from benchmarks.scale.graph import environment
from benchmarks.scale.plan import ScaleJob
from benchmarks.scale.result import ScaleResult
from benchmarks.scale.watch import Neighbours
from swarm_bench.runs.ros_run import last_lines
from swarm_common.model.errors import SwarmError
from swarm_common.process.lifetime import die_with

PROGRAM = Path(__file__).with_name("harness.py")
OF_SCENARIO = ("name", "world", "mission", "with_lidar", "noise", "stall_limit")


class ScaleRunError(SwarmError):
    """A run ended without a result."""


def run_harness(job: ScaleJob, code: str, machine: str) -> ScaleResult:
    """Run world core and navigators once, without the ROS graph."""
    scenario = dataclasses.asdict(job.scenario)
    request = {
        "scenario": {name: scenario[name] for name in OF_SCENARIO},
        "robots": job.robots,
        "seconds": job.seconds,
        "engine": job.engine,
    }
    command = (sys.executable, str(PROGRAM), json.dumps(request))
    said, others = run_program(command, environment(job.code))
    return result_of(job, said, others, code, machine)


def run_program(command: Sequence[str], env: Mapping[str, str]) -> tuple[dict[str, Any], float]:
    """Run a program; return its last line of JSON and the share, 0 to 1, of the CPU others used."""
    neighbours, before = Neighbours(), _children_cpu()
    parent = os.getpid()
    ended = subprocess.run(
        command, env=dict(env), capture_output=True, text=True, check=False,
        preexec_fn=lambda: die_with(parent),
    )  # fmt: skip
    others = neighbours.share(_children_cpu() - before)
    lines = [line for line in ended.stdout.splitlines() if line.startswith("{")]
    try:
        return json.loads(lines[-1]), others
    except (ValueError, IndexError):
        said = last_lines(ended.stdout + ended.stderr)
        raise ScaleRunError(
            f"{Path(command[1]).name} ended with code {ended.returncode} and no result; "
            f"it said:\n{said}"
        ) from None


def result_of(
    job: ScaleJob, said: Mapping[str, Any], others: float, code: str, machine: str
) -> ScaleResult:
    """Return the result in the output of `harness.measure` or of a peer."""
    seconds = job.robots * said["sim_time"]
    return job.result(
        start_up=said["start_up"],
        sim_time=said["sim_time"],
        wall_time=said["wall_time"],
        cpu_ms={name: 1000.0 * value / seconds for name, value in said["cpu"].items()},
        memory_mb={"total": said["rss_mb"], "robot": None, "rss": said["rss_mb"]},
        collisions=said["collisions"],
        goals_reached=said["goals_reached"],
        tick_us=said.get("tick_us", {}),
        others=others,
        code=code,
        machine=machine,
        trajectory_sha256=said.get("trajectory_sha256", ""),
    )


def _children_cpu() -> float:
    usage = resource.getrusage(resource.RUSAGE_CHILDREN)
    return usage.ru_utime + usage.ru_stime
