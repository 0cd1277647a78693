"""A swarm under a centre on the graph: robots go on alone when it dies, not when it refuses."""

import signal

import pytest

from tests.fakes import solver

SOLVER = """
/central:
  ros__parameters: {{solver: {program}, solver_time: 10.0}}
"""
LED = 20.0  # [s] of simulated time before the centre is killed
FLAGS = (
    "--world", "doorway", "--mission", "change_rooms", "--until-done", "--headless", "--drive",
    "planar", "--speed", "5", "--no-report", "--coordination", "central-with-fallback",
)  # fmt: skip


@pytest.mark.timeout(300)
def test_robots_reach_all_goals_alone_when_the_centre_dies(start):
    swarm = start(*FLAGS, "--swarm-size", "4", "--no-restart")
    swarm.wait_until(lambda: swarm.sim_time() >= LED)
    assert swarm.send("centre", signal.SIGKILL)
    swarm.hurry()
    swarm.wait_for_end()
    report = swarm.report()
    assert report["failures"], swarm.output
    assert "central process ended" in report["failures"][0]
    assert report["centre"]["plans"] > 5
    assert report["centre"]["commands"] == 4
    assert report["goals"]["reached"] == report["goals"]["sent"] == 4
    assert report["collisions"] == {"robot_robot": 0, "robot_world": 0}
    assert sum(robot["replans"] for robot in report["robots"].values()) > 0


@pytest.mark.long  # in the bench it always runs
@pytest.mark.timeout(300)
def test_a_solver_that_fails_ends_the_run_and_nothing_else_drives_in_its_name(start, tmp_path):
    params = tmp_path / "solver.yaml"
    params.write_text(SOLVER.format(program=solver.__file__), encoding="utf-8")
    late = {"SOLVER_MODE": "late", "SOLVER_COUNT": str(tmp_path / "count")}
    swarm = start(*FLAGS, "--swarm-size", "2", "--params", str(params), **late)
    assert swarm.wait_for_end() == 2, swarm.output
    said = swarm.output
    assert f"s of simulated time --central-solver {solver.__file__}" in said
    assert "gave up with exit code 1" in said
    assert not (swarm.run_dir / "report.json").exists()
