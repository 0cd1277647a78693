"""Fifty robots on the graph move alike, however busy the machine is."""

import json
import multiprocessing
import os
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

ROBOTS, SECONDS = 50, 40


def run(folder: Path) -> dict[str, object]:
    flags = (
        *("--swarm-size", str(ROBOTS), "--mission", "loading_route", "--seed", "5"),
        *("--duration", str(SECONDS), "--speed", "max", "--headless", "--no-report"),
        *("--run-dir", str(folder)),
    )
    ended = subprocess.run(
        (sys.executable, "-c", "from swarm_commander.cli.main import swarm_up; swarm_up()", *flags),
        cwd=folder.parent,
        capture_output=True,
        text=True,
        timeout=1500,
        check=False,
    )
    assert ended.returncode == 0, ended.stdout + ended.stderr
    report = json.loads((folder / "report.json").read_text(encoding="utf-8"))
    assert isinstance(report, dict)
    return report


def burn() -> None:
    while True:
        pass


@contextmanager
def busy_machine() -> Iterator[None]:
    """Keep every processor busy."""
    context = multiprocessing.get_context("spawn")
    hogs = [context.Process(target=burn, daemon=True) for _ in range(os.cpu_count() or 1)]
    for hog in hogs:
        hog.start()
    try:
        yield
    finally:
        for hog in hogs:
            hog.kill()
            hog.join()


@pytest.mark.long
@pytest.mark.timeout(3200)
def test_fifty_robots_move_alike_on_an_idle_and_on_a_busy_machine(tmp_path):
    alone = run(tmp_path / "alone")
    with busy_machine():
        crowded = run(tmp_path / "crowded")
    assert alone["late_ticks"] == crowded["late_ticks"] == 0
    assert alone["trajectory_sha256"] == crowded["trajectory_sha256"]
    assert alone["collisions"] == {"robot_robot": 0, "robot_world": 0}
