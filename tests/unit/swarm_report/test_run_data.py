"""Reading a run's folder: whole, cut off, and not a run at all."""

import json

import numpy as np
import pytest

from swarm_common.files.journal import Journal
from swarm_common.model.errors import ConfigError
from swarm_report.judgement import judge
from swarm_report.run import RunData

NAMES = ["Srobot1", "Srobot2"]


@pytest.fixture
def folder(tmp_path):
    """A run of two robots that was killed at 3 s."""
    for name in ("config", "trace"):
        (tmp_path / name).mkdir()
    config = {"world": "hall", "robots": [{"name": name} for name in NAMES]}
    (tmp_path / "config" / "world.json").write_text(json.dumps(config))
    world = Journal(tmp_path / "trace" / "world.jsonl")
    world.write(robots=NAMES, near_mm=500)
    for t in range(4):
        world.write(
            t=t, x=[1000 * t, 0], y=[0, 500], yaw=[0, 0], to_robot=[90, 90], to_world=[500, 200]
        )
    robots = Journal(tmp_path / "trace" / "robots.jsonl")
    robots.write(t=0.0, robot="Srobot1", state="idle", station="", place=0, reached=0, failed=0)
    robots.write(t=0.0, robot="Srobot1", goal="dock", outcome="sent", duration=0.0)
    robots.write(t=0.5, robot="Srobot1", state="driving", station="a", place=1)
    robots.write(t=1.0, robot="Srobot1", waited=1.0)
    robots.write(t=2.0, robot="Srobot1", goal="dock", outcome="reached", duration=2.0)
    robots.write(t=2.5, robot="Srobot9", goal="dock", outcome="reached", duration=2.0)
    return tmp_path


def test_what_was_written_comes_back(folder):
    run = RunData(folder)
    np.testing.assert_allclose(run.series.poses[:, 0, 0], [0.0, 1.0, 2.0, 3.0])
    np.testing.assert_allclose(run.series.poses[:, 1, 1], 0.5)
    np.testing.assert_allclose(run.series.to_robot, 0.09)
    assert run.end == 3.0
    assert [(s.robot, s.start, s.end, s.state, s.place) for s in run.spans] == [
        (0, 0.0, 0.5, "idle", 0),
        (0, 0.5, 3.0, "driving", 1),
    ]
    assert [(g.robot, g.time, g.outcome) for g in run.goals] == [
        (0, 0.0, "sent"),
        (0, 2.0, "reached"),
    ]
    states = run.states_at(np.array([0.0, 0.5, 2.9]))
    assert states[:, 0].tolist() == ["idle", "driving", "driving"]
    assert states[:, 1].tolist() == ["", "", ""]


def test_robots_that_came_and_went_have_no_place_before_and_after(folder):
    path = folder / "trace" / "world.jsonl"
    text = path.read_text()
    world = Journal(path)
    for line in text.splitlines():
        world.write(**json.loads(line))
    world.write(robots=[*NAMES, "Srobot5"], near_mm=500)
    place = {"y": [0, 0, 0], "yaw": [0, 0, 0], "to_robot": [9, 9, 9], "to_world": [9, 9, 9]}
    world.write(t=4, x=[4000, None, 7000], **place)
    run = RunData(folder)
    assert run.robots == [*NAMES, "Srobot5"]
    nan = np.nan
    np.testing.assert_allclose(run.series.poses[:, 2, 0], [nan, nan, nan, nan, 7.0])
    np.testing.assert_allclose(run.series.poses[:, 1, 0], [0.0, 0.0, 0.0, 0.0, nan])


def test_a_run_without_a_report_gets_no_verdict(folder):
    verdict = judge(RunData(folder))
    assert verdict.kind == "open"
    assert "1 goal reached, 0 missed" in verdict.lines[1]


def test_a_folder_that_is_no_run_is_refused(tmp_path):
    with pytest.raises(ConfigError, match="not the folder of a run"):
        RunData(tmp_path)


@pytest.mark.parametrize(
    ("change", "kind", "headline"),
    [
        ({}, "good", "Passed: 16 of 16 goals reached, no collisions"),
        ({"robot_world": 1}, "bad", "Failed: 16 of 16 goals reached, 1 collision"),
        ({"failed": 2}, "bad", "Failed: 16 of 18 goals reached, no collisions"),
        ({"pending": 4}, "open", "Stopped early: 16 of 20 goals reached, no collisions"),
    ],
)
def test_the_verdict(folder, change, kind, headline):
    goals = {"sent": 16, "reached": 16, "failed": 0, "pending": 0}
    crashes = {"robot_robot": 0, "robot_world": 0}
    report = {
        "swarm_size": 4,
        "cpu_ms_per_robot_second": {},
        "goals": {key: change.get(key, value) for key, value in goals.items()},
        "collisions": {key: change.get(key, value) for key, value in crashes.items()},
    }
    (folder / "report.json").write_text(json.dumps(report))
    verdict = judge(RunData(folder))
    assert (verdict.kind, verdict.headline) == (kind, headline)
