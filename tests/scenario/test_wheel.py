"""Every example runs at its smallest, and is short."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

from tests.fakes.ros_domains import reserved_domain

FOLDER = Path(__file__).resolve().parents[2] / "examples"
EXAMPLES = {
    "compare": (["1"], "of 4 goals reached"),
    "external_node": ([], "0 collisions"),
    "faults": ([], "0 collisions"),
    "four_robots": (["--bench"], "0 collisions"),
    "learn": (["1"], "ours 2 of 2 goals"),
    "own_controller": (["1"], "own: 0 collisions"),
    "own_rule": ([], "0 collisions"),
    "own_world": ([], "["),
    "ros_client": ([], "status 4"),  # action_msgs/GoalStatus: succeeded
    "sweep": (["1"], "margin 0.08 m"),
}


def test_every_example_is_run():
    elsewhere = {"fleet_control"}  # with a broker: tests/graph
    assert EXAMPLES.keys() | elsewhere == {path.stem for path in FOLDER.glob("*.py")}


@pytest.mark.parametrize("name", EXAMPLES)
def test_an_example_runs_and_is_short(name: str, tmp_path: Path) -> None:
    words, expected = EXAMPLES[name]
    path = FOLDER / f"{name}.py"
    assert len(path.read_text(encoding="utf-8").splitlines()) <= 41
    with reserved_domain() as domain:
        environment = os.environ | {
            "MPLBACKEND": "Agg",
            "PYTHONPATH": str(FOLDER.parent),
            "ROS_DOMAIN_ID": str(domain),
        }
        done = subprocess.run(
            (sys.executable, str(path), *words),
            cwd=tmp_path,
            env=environment,
            capture_output=True,
            text=True,
            check=False,
        )
    assert done.returncode == 0, done.stderr
    assert expected in done.stdout
