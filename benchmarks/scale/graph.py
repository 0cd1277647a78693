"""One run of `python -m benchmarks scale` on the ROS graph: `swarm-up`, watched from outside."""

from __future__ import annotations

import json
import os
import subprocess
import tempfile
import time
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from benchmarks.scale.plan import WORKLOADS, ScaleJob
from benchmarks.scale.result import ScaleResult
from benchmarks.scale.watch import Neighbours, ThreadTimes, dds_share, proportional_mb
from swarm_bench.runs.ros_run import SwarmUpError, last_lines
from swarm_commander.run.processes.usage import process_tree
from swarm_common.process.lifetime import die_with
from swarm_run.command_line import SWARM_UP

POLL_PERIOD = 0.5  # [s] of wall time
SAMPLE_PERIOD = 5.0  # [s] between two looks at MANY processes; fewer are looked at more often
MANY = 100
MEMORY_LOOKS = 5  # memory is read at every fifth look, since that takes long
USAGE = Path("trace") / "usage.jsonl"  # of a run's folder


def run_graph(job: ScaleJob, code: str, machine: str) -> ScaleResult:
    """Run `swarm-up` once."""
    with tempfile.TemporaryDirectory(prefix="swarm-scale-") as name:
        folder = Path(name)
        log, parent = folder / "said.txt", os.getpid()
        with log.open("w", encoding="utf-8") as file:
            process = subprocess.Popen(
                (*SWARM_UP, *_flags(job, folder)), cwd=folder, env=environment(job.code),
                stdout=file, stderr=subprocess.STDOUT, preexec_fn=lambda: die_with(parent),
            )  # fmt: skip
            try:
                watched = _watch(process, folder / "run" / USAGE)
            finally:
                if process.poll() is None:  # an interrupted bench takes its swarm along
                    process.terminate()
                    process.wait()
        path = folder / "run" / "report.json"
        said = last_lines(log.read_text(encoding="utf-8"))
        if not path.is_file():
            raise SwarmUpError(
                f"swarm-up ended with code {process.returncode} and no report; it said:\n{said}"
            )
        report = json.loads(path.read_text(encoding="utf-8"))
        if not report["sim_time"]:
            raise SwarmUpError(f"no time passed in the run; swarm-up said:\n{said}")
    return _result(job, report, watched, code, machine)


def environment(code: Path | None) -> dict[str, str]:
    """Return an environment in which the code in a folder runs; None for this code."""
    if code is None:
        return dict(os.environ)
    path = os.pathsep.join([str(code), os.environ.get("PYTHONPATH", "")]).strip(":")
    return {**os.environ, "PYTHONPATH": path}


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
        params.write_text(
            f"/world: {{ros__parameters: {{engine: {job.engine}}}}}\n", encoding="utf-8"
        )
        words += ["--params", str(params)]
    return [*words, "--headless", "--over-limit", "--no-report"]


def _watch(process: subprocess.Popen[bytes], usage: Path) -> dict[str, Any]:
    """Follow a run to its end; return what was seen of it since the first tick."""
    threads = ThreadTimes()
    before: dict[str, tuple[float, float]] | None = None
    neighbours = Neighbours()
    due, memory, looks = 0.0, 0.0, 0
    seen: dict[str, Any] = {"shares": {}, "memory": None, "others": None}
    while process.poll() is None:
        time.sleep(POLL_PERIOD)
        if time.monotonic() < due or not _is_running(usage):
            continue
        tree = process_tree(process.pid)
        due = time.monotonic() + max(POLL_PERIOD, SAMPLE_PERIOD * len(tree) / MANY)
        threads.sample(tree)
        totals = threads.totals()
        if before is None:
            before, neighbours = totals, Neighbours()
            continue
        looks += 1
        if looks % MEMORY_LOOKS == 1:
            memory = max(memory, proportional_mb(tree))
        spent = sum(total for total, _ in totals.values()) - sum(old for old, _ in before.values())
        others = neighbours.share(spent)
        seen = {"shares": dds_share(before, totals), "memory": memory, "others": others}
    return seen


def _is_running(usage: Path) -> bool:
    try:
        lines = usage.read_text(encoding="utf-8").splitlines()
        return bool(lines) and json.loads(lines[-1])["t"] > 0.0
    except (OSError, ValueError):
        return False


def _result(
    job: ScaleJob, report: Mapping[str, Any], watched: Mapping[str, Any], code: str, machine: str
) -> ScaleResult:
    cpu = report["cpu_ms_per_robot_second"]
    parts = {
        "world": cpu["world"],
        "navigators": cpu["navigators"],
        "other": cpu["total"] - cpu["world"] - cpu["navigators"],
    }
    shares = watched["shares"]
    dds = sum(shares.get(group, 0.0) * value for group, value in parts.items()) if shares else None
    rss, private = report["rss_mb"], report["private_mb"]
    return job.result(
        start_up=report["active_after_wall"],
        sim_time=report["sim_time"],
        wall_time=report["sim_time"] / report["real_time_factor"],
        cpu_ms={**parts, "dds": dds},
        memory_mb={
            "total": watched["memory"],
            "robot": private["navigators"],
            "rss": rss["world"] + rss["navigators"],
        },
        late_ticks=report["late_ticks"],
        collisions=sum(count or 0 for count in report["collisions"].values()),
        goals_reached=report["goals"]["reached"],
        others=watched["others"],
        code=code,
        machine=machine,
        trajectory_sha256=report["trajectory_sha256"] or "",
    )
