"""swarm-up with names of the user's own, and what commands make of them."""

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
FLEET = """names: [amr_beta, amr_alpha, 'agv{:02}']
groups:
  - {model: turtlebot3_burger, count: 2}
"""
TOUR = "retries: 3\nroute:\n  - {stations: [south_west, north_east], order: random, pause: 0.2}\n"


def command(name: str) -> tuple[str, ...]:
    return (sys.executable, "-c", f"from swarm_commander.cli.main import {name}; {name}()")


def environment(domain: int) -> dict[str, str]:
    return os.environ | {"PYTHONPATH": str(ROOT), "ROS_DOMAIN_ID": str(domain)}


@pytest.mark.slow
@pytest.mark.timeout(400)
def test_names_change_no_trajectory(tmp_path):
    (tmp_path / "tour.yaml").write_text(TOUR, encoding="utf-8")
    flags = ("--world", "hall_12", "--swarm-size", "4", "--mission", "tour.yaml")
    flags += ("--until-done", "--headless", "--no-report")
    reports = []
    with reserved_domain() as domain:
        for run, own in (("usual", ()), ("own", ("--names", "d,c,b,a"))):
            subprocess.run(
                (*command("swarm_up"), *flags, *own, "--run-dir", run),
                env=environment(domain), cwd=tmp_path, check=True, capture_output=True,
            )  # fmt: skip
            reports.append(json.loads((tmp_path / run / "report.json").read_text("utf-8")))
    usual, own_names = reports
    assert list(own_names["robots"]) == ["d", "c", "b", "a"]
    assert own_names["trajectory_sha256"] == usual["trajectory_sha256"]
    assert list(own_names["robots"].values()) == list(usual["robots"].values())


@pytest.mark.slow
@pytest.mark.timeout(400)
def test_commands_take_the_names_of_the_run(tmp_path):
    (tmp_path / "fleet.yaml").write_text(FLEET, encoding="utf-8")
    flags = ("--fleet", "fleet.yaml", "--speed", "4", "--headless", "--no-report")
    log = tmp_path / "up.log"
    with reserved_domain() as domain:

        def ask(*words: str) -> subprocess.CompletedProcess[str]:
            return subprocess.run(
                (*command("commander"), *words),
                env=environment(domain), cwd=tmp_path, capture_output=True, text=True,
                timeout=LIMIT, check=False,
            )  # fmt: skip

        with log.open("w", encoding="utf-8") as output:
            swarm = subprocess.Popen(
                (*command("swarm_up"), *flags, "--run-dir", "run"),
                env=environment(domain), cwd=tmp_path, stdout=output, stderr=subprocess.STDOUT,
            )  # fmt: skip
        try:
            end = time.monotonic() + LIMIT
            while "all robots are active" not in log.read_text(encoding="utf-8"):
                assert time.monotonic() < end, log.read_text(encoding="utf-8")
                assert swarm.poll() is None, log.read_text(encoding="utf-8")
                time.sleep(0.2)
            unknown = ask("amr_gamma")
            assert unknown.returncode == 2
            assert "there are amr_alpha, amr_beta" in unknown.stderr
            refused = ask("spawn", "crate")
            assert refused.returncode == 2
            assert "expected amr_beta and amr_alpha, or agv03 to agv65535" in refused.stderr
            assert "for an object 'crate' give --box" in refused.stderr
            spawned = ask("spawn", "--pose", "3", "3", "0")
            assert spawned.stdout.startswith("agv03 is there"), spawned.stderr
            restarted = ask("restart", "amr_alpha")
            assert restarted.returncode == 0, restarted.stderr
            assert "amr_alpha is active again" in restarted.stdout
            driven = ask("agv03", "--goal", "4", "3", "0")
            assert driven.returncode == 0, driven.stdout + driven.stderr
        finally:
            swarm.terminate()
            swarm.wait(LIMIT)
    report = json.loads((tmp_path / "run" / "report.json").read_text(encoding="utf-8"))
    assert list(report["robots"]) == ["amr_beta", "amr_alpha", "agv03"]
    assert report["robots"]["agv03"]["goals_reached"] == 1
    files = {path.name for path in (tmp_path / "run").rglob("*")}
    assert {"agv03.yaml", "amr_beta.rviz", "amr_alpha.json"} <= files
    assert not any("Srobot" in name for name in files)
