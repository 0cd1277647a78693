"""the statistics of robots that come and go, and the parameters that a newcomer gets."""

import json

from swarm_commander.run.results.run_statistics import RunStatistics
from swarm_commander.run.results.status_table import shown_state
from swarm_common.model.records import Pose
from swarm_common.process import messages as say
from swarm_run.plan import check_plan
from swarm_run.spec import RunSpec
from tests.fakes.charging import BATTERY


def test_a_newcomer_counts_once_it_is_active():
    statistics = RunStatistics.of(["Srobot1"], False)
    statistics.apply(say.NavigatorActive("Srobot1"))
    statistics.apply(say.RobotSpawned("Srobot4", 4, "waffle", (0.0, 0.0, 0.0), 1.0))
    assert statistics.active == 1
    statistics.apply(say.NavigatorActive("Srobot4"))
    assert (statistics.active, list(statistics.robots)) == (2, ["Srobot1", "Srobot4"])


def test_goals_of_a_robot_that_was_taken_out_do_not_count():
    statistics = RunStatistics.of(["Srobot1", "Srobot2"], True)
    for robot in statistics.robots:
        statistics.apply(say.NavigatorActive(robot))
    statistics.apply(say.MissionLoaded(6))
    statistics.apply(say.GoalSent("Srobot2", "Loader1"))
    statistics.apply(say.RobotRemoved("Srobot2", 4.0))
    for _ in range(3):
        statistics.apply(say.GoalWithdrawn("Srobot2"))
    assert (statistics.total, statistics.sent, statistics.pending, statistics.failed) == (
        3,
        0,
        3,
        0,
    )
    assert statistics.unfinished == []
    assert statistics.active == 1
    assert shown_state(statistics.robots["Srobot2"]) == "gone"
    statistics.apply(say.RobotSpawned("Srobot2", 2, "waffle", (0.0, 0.0, 0.0), 1.0))
    statistics.apply(say.NavigatorActive("Srobot2"))
    assert statistics.active == 2


def test_one_that_comes_back_has_the_battery_of_its_group(tmp_path):
    fleet = tmp_path / "fleet.yaml"
    group = {"model": "turtlebot3_waffle", "count": 2, "battery": BATTERY}
    fleet.write_text(json.dumps({"groups": [group]}), encoding="utf-8")
    plan = check_plan(RunSpec(fleet=str(fleet)))
    assert plan.world_config(tmp_path)["robots"][0]["battery"]["capacity"] == BATTERY["capacity"]
    assert "no station in" in plan.remarks[0]
    for name, has_battery in (("Srobot2", True), ("Srobot9", False)):
        tree = plan.parameter_file_of_newcomer(name, 2, "turtlebot3_waffle", Pose(0.0, 0.0, 0.0))
        robot = tree[f"/{name}/navigator"]["ros__parameters"]["robot"]
        assert ("battery" in robot) is has_battery


def test_a_newcomer_gets_the_parameters_of_its_model():
    plan = check_plan(RunSpec(swarm_size=2, mission="loading_route"))
    tree = plan.parameter_file_of_newcomer("Srobot9", 9, "turtlebot3_burger", Pose(1.0, 2.0, 0.5))
    values = tree["/Srobot9/navigator"]["ros__parameters"]
    assert (values["robot_id"], values["robot"]["model"]) == (9, "turtlebot3_burger")
    assert values["initial_pose"] == {"x": 1.0, "y": 2.0, "yaw": 0.5}
    assert values["wait_for_mission"] is False
    assert (
        values["sites"]
        == plan.parameter_file(1, Pose(0, 0, 0))["/Srobot1/navigator"]["ros__parameters"]["sites"]
    )
