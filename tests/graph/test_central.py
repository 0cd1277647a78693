"""A swarm under a centre on the graph: robots go on alone when it dies, not when it refuses."""

import json
import os
import subprocess
import sys
import time
from pathlib import Path

import psutil
import pytest

from tests.fakes import solver
from tests.fakes.ros_domains import reserved_domain

LIMIT = 120.0  # [s] of wall time, on a busy machine
SOLVER = """
/central:
  ros__parameters: {{solver: {program}, solver_time: 10.0}}
"""
LED = 20.0  # [s] of simulated time before the centre is killed


def led_for(usage: Path) -> float:
    """Return the simulated time [s] that swarm-up noted last."""
    lines = usage.read_text(encoding="utf-8").splitlines() if usage.exists() else []
    return float(json.loads(lines[-1])["t"]) if lines else 0.0


@pytest.mark.timeout(300)
def test_robots_reach_all_goals_alone_when_the_centre_dies(tmp_path):
    folder = tmp_path / "run"
    command = (
        sys.executable, "-c", "from swarm_commander.cli.main import swarm_up; swarm_up()",
        "--world", "doorway",
        "--mission", "change_rooms", "--swarm-size", "4", "--until-done", "--headless",
        "--drive", "planar", "--speed", "5", "--no-restart", "--no-report", "--run-dir",
        str(folder), "--coordination", "central-with-fallback",
    )  # fmt: skip
    with reserved_domain() as domain:
        env = os.environ | {"ROS_DOMAIN_ID": str(domain)}
        with subprocess.Popen(command, env=env, stdout=subprocess.PIPE, text=True) as swarm:
            try:
                end = time.monotonic() + LIMIT
                while led_for(folder / "trace" / "usage.jsonl") < LED:
                    assert time.monotonic() < end
                    assert swarm.poll() is None
                    time.sleep(0.1)
                (centre,) = [
                    child
                    for child in psutil.Process(swarm.pid).children(recursive=True)
                    if "swarm_central.process" in child.cmdline()
                ]
                centre.kill()
                output, _ = swarm.communicate(timeout=LIMIT)
            finally:
                swarm.terminate()
    report = json.loads((folder / "report.json").read_text(encoding="utf-8"))
    assert report["failures"], output
    assert "central process ended" in report["failures"][0]
    assert report["centre"]["plans"] > 5
    assert report["centre"]["commands"] == 4
    assert report["goals"]["reached"] == report["goals"]["sent"] == 4
    assert report["collisions"] == {"robot_robot": 0, "robot_world": 0}
    assert sum(robot["replans"] for robot in report["robots"].values()) > 0


@pytest.mark.timeout(300)
def test_a_solver_that_fails_ends_the_run_and_nothing_else_drives_in_its_name(tmp_path):
    params = tmp_path / "solver.yaml"
    params.write_text(SOLVER.format(program=solver.__file__), encoding="utf-8")
    command = (
        sys.executable, "-c", "from swarm_commander.cli.main import swarm_up; swarm_up()",
        "--world", "doorway", "--mission", "change_rooms", "--swarm-size", "2", "--until-done",
        "--headless", "--drive", "planar", "--speed", "5", "--no-report",
        "--run-dir", str(tmp_path / "run"), "--coordination", "central-with-fallback",
        "--params", str(params),
    )  # fmt: skip
    with reserved_domain() as domain:
        env = os.environ | {
            "ROS_DOMAIN_ID": str(domain),
            "SOLVER_MODE": "late",
            "SOLVER_COUNT": str(tmp_path / "count"),
        }
        done = subprocess.run(
            command, env=env, capture_output=True, text=True, timeout=2 * LIMIT, check=False
        )
    assert done.returncode == 2, done.stdout
    assert f"s of simulated time --central-solver {solver.__file__}" in done.stderr
    assert "gave up with exit code 1" in done.stderr
    assert not (tmp_path / "run" / "report.json").exists()
