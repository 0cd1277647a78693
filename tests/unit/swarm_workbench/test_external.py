"""Robots that nodes of users drive: what is refused, and their beacons."""

import math

import numpy as np
import pytest

from swarm_common.middleware.radio_check import read_beacon
from swarm_common.model.beacon import empty_beacons, serialize_beacon
from swarm_common.model.errors import SwarmError
from swarm_common.model.records import Pose, Twist
from swarm_run.plan import check_plan
from swarm_run.spec import RunSpec
from swarm_sim.ros.build import build
from swarm_sim.ros.settings import parse_settings
from swarm_workbench import ExternalRobot, Sensed, load_robot
from swarm_workbench.external import compose_beacon, stopping_path


def _fleet(tmp_path, external):
    path = tmp_path / "fleet.yaml"
    group = "- {model: turtlebot3_waffle, count: 3}"
    path.write_text(f"groups: [{group[2:]}]\nexternal: {external}\n", encoding="utf-8")
    return str(path)


def test_external_robots_have_no_navigator_and_a_number(tmp_path):
    plan = check_plan(RunSpec(swarm_size=3, fleet=_fleet(tmp_path, "[Srobot2]")))
    assert plan.alive == ["Srobot1", "Srobot3"]
    robots = plan.world_config(tmp_path / "verdict.json")["robots"]
    assert [robot.get("external", False) for robot in robots] == [False, True, False]
    with pytest.raises(SwarmError, match=r"give number=\.\.\."):
        ExternalRobot("ann", lambda seen: Twist())


@pytest.mark.parametrize(
    ("external", "message"),
    [
        ("[Srobot9]", "unknown robot 'Srobot9' in external"),
        ("[Srobot1, Srobot2, Srobot3]", "leaves no robot with a navigator"),
        ("Srobot1", "expected a list of robots' names"),
    ],
)
def test_external_robots_that_make_no_sense_are_refused(tmp_path, external, message):
    with pytest.raises(SwarmError, match=message):
        RunSpec(fleet=_fleet(tmp_path, external)).check()


def test_a_broken_robot_on_anothers_start_is_refused(tmp_path):
    config = {
        "world": "doorway",
        "engine": "planar",
        "robots": [
            {"name": "Srobot1", "model": "turtlebot3_waffle"},
            {"name": "Srobot2", "model": "turtlebot3_waffle"},
        ],
    }
    start = build(parse_settings(config, "test"))[0].starts[0]
    config["robots"][1]["broken_at"] = [start.x + 0.1, start.y, 0.0]
    with pytest.raises(SwarmError, match="robots 1 and 2 would overlap at their start"):
        build(parse_settings(config, "test"))


def test_a_beacon_has_pose_body_and_stopping_space():
    spec = load_robot("turtlebot3_waffle")
    pose, twist = Pose(1.0, 2.0, math.pi / 2), Twist(vx=0.2)
    sensed = Sensed(30, 3.0, pose, twist, None, empty_beacons(0))
    beacon = compose_beacon(spec, 4, sensed, {2: 29, 7: 28})
    read = read_beacon(serialize_beacon(beacon), 4, 30)
    assert read["pose"] == pytest.approx([1.0, 2.0, math.pi / 2])
    held = read["held"][: read["held_size"]]
    assert held[0] == pytest.approx([1.0, 2.0])
    assert held[-1, 0] == pytest.approx(1.0, abs=1e-5)
    assert held[-1, 1] - 2.0 > 0.2**2 / (2.0 * spec.acc_lim_x)  # ahead, as far as it needs
    assert set(read["heard"].tolist()) - {0} == {2 << 16 | 29, 7 << 16 | 28}
    back = np.array(stopping_path(spec, pose, Twist(vx=-0.2)))
    assert back[-1, 1] < 2.0
