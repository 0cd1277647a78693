"""Runs of `python -m benchmarks scale`, one after the other, with their results kept on disk."""

from __future__ import annotations

import dataclasses
import json
import os
import resource
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any

import msgspec
import psutil

from benchmarks.scale.plan import GRAPH, WORKLOADS, ScaleJob
from benchmarks.scale.result import ScaleResult
from swarm_bench.execution.store import Store
from swarm_bench.execution.sweep import Sweep
from swarm_bench.runs.episode import RunOptions, check
from swarm_bench.runs.origin import commit_of, machine_line
from swarm_bench.runs.ros_run import last_lines
from swarm_bench.tables import number
from swarm_common.model.errors import SwarmError
from swarm_common.process.lifetime import die_with
from swarm_run.command_line import SWARM_UP

REPOSITORY = Path(__file__).resolve().parents[2]
HARNESS_PROGRAM = Path(__file__).with_name("harness.py")
OF_SCENARIO = ("name", "world", "mission", "with_lidar", "noise", "stall_limit")


class ScaleRunError(SwarmError):
    """A run ended without a result."""


def store_of(file: Path | None) -> Store[ScaleResult]:
    """Return the store of a file of JSON lines; None keeps nothing."""
    parse = partial(msgspec.convert, type=ScaleResult)
    return Store(file, parse, "python -m benchmarks scale")


def sweep_of(
    jobs: Sequence[ScaleJob],
    file: Path | None = None,
    runner: Callable[[ScaleJob], ScaleResult] | None = None,
) -> Sweep[ScaleJob, ScaleResult]:
    """Return the sweep of jobs.

    Args:
        file: JSON lines; None to keep nothing.
        runner: Runs one; None for `run_job`.

    Raises:
        SwarmError: If a hall has no room for so many robots.
    """
    for job in {(job.workload, job.robots): job for job in jobs}.values():
        check(RunOptions(scenario=job.scenario, robots=job.robots))
    return Sweep(
        items=jobs,
        runner=runner or run_job,
        store=store_of(file),
        key=lambda job: (*job.key, job.code),
        key_of=lambda result: (*result.key, None),
        line=scale_line,
        name=lambda job: f"{job.system} {job.workload} {job.robots} robots run {job.repeat + 1}",
    )


def run_job(job: ScaleJob) -> ScaleResult:
    """Run a job with the code that it names, in processes of its own.

    Raises:
        ScaleRunError: If there is no result.
    """
    return job.result(
        **(_run_graph if job.system == GRAPH else _run_harness)(job),
        code=commit_of(job.code or REPOSITORY),
        machine=machine_line(),
    )


def _run_graph(job: ScaleJob) -> dict[str, Any]:
    with tempfile.TemporaryDirectory(prefix="swarm-scale-") as name:
        folder = Path(name)
        said, others = _run((*SWARM_UP, *_flags(job, folder)), job, folder)
        try:
            report = json.loads((folder / "run" / "report.json").read_text(encoding="utf-8"))
            factor = report["sim_time"] / report["real_time_factor"]
        except (OSError, ZeroDivisionError, TypeError):
            raise ScaleRunError(f"swarm-up made no report of a run; it said:\n{said}") from None
    cpu, memory = report["cpu_ms_per_robot_second"], report["memory_mb"]
    other = cpu["total"] - cpu["world"] - cpu["navigators"]
    return {
        "start_up": report["active_after_wall"],
        "sim_time": report["sim_time"],
        "wall_time": factor,
        "cpu_ms": {"world": cpu["world"], "navigators": cpu["navigators"], "other": other},
        "memory_mb": {
            "total": sum(size or 0.0 for size in memory.values()),
            "robot": report["private_mb"]["navigators"],
            "rss": sum(report["rss_mb"][part] for part in ("world", "navigators")),
        },
        "late_ticks": report["late_ticks"],
        "collisions": sum(count or 0 for count in report["collisions"].values()),
        "goals_reached": report["goals"]["reached"],
        "trajectory_sha256": report["trajectory_sha256"] or "",
        "others": others,
    }


def _flags(job: ScaleJob, folder: Path) -> list[str]:
    workload = WORKLOADS[job.workload]
    flags = {
        "--swarm-size": job.robots,
        "--world": workload.world,
        "--mission": workload.mission,
        "--seed": 0,
        "--speed": "max",
        "--duration": job.seconds,
        "--pack": job.pack,
        "--run-dir": folder / "run",
    }
    words = [word for flag, value in flags.items() for word in (flag, str(value))]
    words += ["--goals-per-robot", str(job.goals), "--until-done"] if job.goals else []
    if job.engine != "bullet":
        params = folder / "params.yaml"
        params.write_text(f"/world: {{ros__parameters: {{engine: {job.engine}}}}}\n", "utf-8")
        words += ["--params", str(params)]
    return [*words, "--headless", "--over-limit", "--no-report"]


def _run_harness(job: ScaleJob) -> dict[str, Any]:
    scenario = dataclasses.asdict(job.scenario)
    request = {
        "scenario": {name: scenario[name] for name in OF_SCENARIO},
        "robots": job.robots,
        "seconds": job.seconds,
        "engine": job.engine,
    }
    said, others = _run((sys.executable, str(HARNESS_PROGRAM), json.dumps(request)), job)
    lines = [line for line in said.splitlines() if line.startswith("{")]
    if not lines:
        raise ScaleRunError(f"harness.py ended without a result; it said:\n{last_lines(said)}")
    result: dict[str, Any] = json.loads(lines[-1])
    robot_seconds = job.robots * result["sim_time"]
    cpu = {name: 1000.0 * value / robot_seconds for name, value in result.pop("cpu").items()}
    memory = result.pop("rss_mb")
    memory_mb = {"total": memory, "robot": None, "rss": memory}
    return {**result, "cpu_ms": cpu, "memory_mb": memory_mb, "others": others}


def _run(command: Sequence[str], job: ScaleJob, folder: Path | None = None) -> tuple[str, float]:
    """Run a program with a job's code.

    Returns:
        What it said, and the share of the machine's processors, 0 to 1, that others used meanwhile.
    """
    environment = dict(os.environ)
    if job.code is not None:
        path = os.pathsep.join([str(job.code), environment.get("PYTHONPATH", "")])
        environment["PYTHONPATH"] = path.strip(os.pathsep)
    parent, began, busy, own = os.getpid(), time.monotonic(), _busy(), _children_cpu()
    ended = subprocess.run(
        command,
        env=environment,
        cwd=folder,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        check=False,
        preexec_fn=lambda: die_with(parent),
    )
    capacity = (time.monotonic() - began) * (psutil.cpu_count() or 1)
    used = _busy() - busy - (_children_cpu() - own)
    return ended.stdout, min(1.0, max(0.0, used / capacity))


def _children_cpu() -> float:
    usage = resource.getrusage(resource.RUSAGE_CHILDREN)
    return usage.ru_utime + usage.ru_stime


def _busy() -> float:
    times = psutil.cpu_times()
    return sum(times) - times.idle - getattr(times, "iowait", 0.0) - getattr(times, "guest", 0.0)


def scale_line(result: ScaleResult) -> str:
    """Return one line about one run."""
    cpu: Mapping[str, float | None] = result.cpu_ms
    others = None if result.others is None else 100.0 * result.others
    return (
        f"{result.system} {result.workload} {result.robots} robots run {result.repeat + 1}: "
        f"start {number(result.start_up, 1)} s, {result.sim_time:.0f} s at "
        f"{result.real_time_factor:.2f}x, {result.cpu_total:.2f} ms per robot-second "
        f"(world {number(cpu.get('world'), 2)}, navigators {number(cpu.get('navigators'), 2)}, "
        f"other {number(cpu.get('other'), 2)}), "
        f"memory {number(result.memory_mb.get('total'), 0)} MB, late {result.late_ticks}, "
        f"collisions {result.collisions}, others used {number(others, 0)} % of the machine"
    )
