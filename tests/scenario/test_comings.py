"""swarm-up with robots that come and go, driven by swarm-commander as a user would."""

import json
import os
import subprocess
import sys
import time
from pathlib import Path

import pytest

from tests.fakes.ros_domains import reserved_domain

ROOT = Path(__file__).resolve().parents[2]
LIMIT = 120.0  # [s] of wall time


def command(name: str) -> tuple[str, ...]:
    return (sys.executable, "-c", f"from swarm_commander.cli.main import {name}; {name}()")


@pytest.mark.slow
@pytest.mark.timeout(400)
def test_robots_come_and_go_while_a_swarm_runs(tmp_path):
    with reserved_domain() as domain:
        environment = os.environ | {"PYTHONPATH": str(ROOT), "ROS_DOMAIN_ID": str(domain)}
        flags = ("--swarm-size", "2", "--speed", "4", "--headless", "--no-report")
        log = tmp_path / "up.log"

        def ask(*words: str) -> subprocess.CompletedProcess[str]:
            return subprocess.run(
                (*command("commander"), *words),
                env=environment, cwd=tmp_path, capture_output=True, text=True,
                timeout=LIMIT, check=False,
            )  # fmt: skip

        with log.open("w", encoding="utf-8") as output:
            swarm = subprocess.Popen(
                (*command("swarm_up"), *flags, "--run-dir", "run"),
                env=environment, cwd=tmp_path, stdout=output, stderr=subprocess.STDOUT,
            )  # fmt: skip
        try:
            end = time.monotonic() + LIMIT
            while "all robots are active" not in log.read_text(encoding="utf-8"):
                assert time.monotonic() < end, log.read_text(encoding="utf-8")
                assert swarm.poll() is None, log.read_text(encoding="utf-8")
                time.sleep(0.2)
            refused = ask("spawn", "--robot", "turtlebot9")
            assert (refused.returncode, refused.stdout) == (2, "")
            assert "did you mean" in refused.stderr
            spawned = ask("spawn", "--robot", "turtlebot3_burger", "--pose", "3", "3", "0")
            assert spawned.stdout.startswith("Srobot3 is there"), spawned.stderr
            driven = ask("Srobot3", "--goal", "4", "3", "0")
            assert driven.returncode == 0, driven.stdout + driven.stderr
            removed = ask("remove", "Srobot3", "Srobot1")
            assert removed.returncode == 0, removed.stderr
            assert [line.split()[0] for line in ask("list").stdout.splitlines()] == ["Srobot2"]
        finally:
            swarm.terminate()
            code = swarm.wait(LIMIT)
    assert code == 0, log.read_text(encoding="utf-8")
    report = json.loads((tmp_path / "run" / "report.json").read_text(encoding="utf-8"))
    assert list(report["robots"]) == ["Srobot1", "Srobot2", "Srobot3"]
    assert report["robots"]["Srobot3"]["goals_reached"] == 1
    assert report["collisions"] == {"robot_robot": 0, "robot_world": 0}
    assert report["failures"] == []
    values = (tmp_path / "run" / "params" / "Srobot3.yaml").read_text(encoding="utf-8")
    assert "turtlebot3_burger" in values
