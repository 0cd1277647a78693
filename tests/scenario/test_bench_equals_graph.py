"""The bench and the ROS graph are the same swarm: equal seeds give equal trajectories."""

import json
import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

from swarm_bench.runs.episode import RunOptions
from swarm_bench.runs.harness import Harness
from swarm_bench.runs.scenario import load_scenario

ROOT = Path(__file__).resolve().parents[2]
MISSION = """
route:
  - {stations: [loader_1]}
"""  # one station for all: they hold, and push who has finished out of the way
SCENARIO = """
world: slim_blockage
mission: MISSION
robots: [3]
with_lidar: true
loss: 0.2
delay: 0.1
noise: 0.02
"""
PARAMS = """
/world:
  ros__parameters:
    radio: {loss: 0.2, delay: 0.1}
    actuation_noise: 0.02
"""


def run_on_the_graph(folder: Path, seed: int) -> dict[str, Any]:
    flags = (
        *("--swarm-size", "3", "--seed", str(seed), "--mission", str(folder / "short.yaml")),
        *("--params", str(folder / "params.yaml"), "--run-dir", str(folder / "run")),
        *("--until-done", "--headless", "--speed", "max"),
    )
    result = subprocess.run(
        (sys.executable, "-c", "from swarm_commander.cli.main import swarm_up; swarm_up()", *flags),
        env=os.environ | {"PYTHONPATH": str(ROOT)},
        cwd=folder,
        capture_output=True,
        text=True,
        timeout=240,
        check=False,
    )
    assert result.returncode == 0, result.stdout + result.stderr
    report = json.loads((folder / "run" / "report.json").read_text(encoding="utf-8"))
    assert isinstance(report, dict)
    return report


@pytest.mark.slow
@pytest.mark.timeout(300)
def test_bench_and_graph_give_equal_trajectories(tmp_path: Path) -> None:
    (tmp_path / "short.yaml").write_text(MISSION, encoding="utf-8")
    (tmp_path / "params.yaml").write_text(PARAMS, encoding="utf-8")
    scenario = tmp_path / "scenario.yaml"
    scenario.write_text(SCENARIO.replace("MISSION", str(tmp_path / "short.yaml")), "utf-8")
    options = RunOptions(scenario=load_scenario(str(scenario)), robots=3, seed=3, engine="bullet")
    result = Harness(options).run()
    report = run_on_the_graph(tmp_path, seed=3)
    assert result.is_flawless
    assert report["makespan"] == pytest.approx(result.makespan)
    assert report["pushes"] == result.pushes > 0
    assert report["trajectory_sha256"] == result.trajectory_sha256
