"""Trained policies as brains: what they see, that they drive, and what is refused."""

import numpy as np
import pytest

from swarm_common.model.errors import SwarmError
from swarm_workbench import Swarm, load_robot, run_scenario
from swarm_workbench.gym import RobotEnv, SwarmEnv
from swarm_workbench.policy import Policy, describe_policy
from tests.fakes.policies import TO_THE_GOAL, save_policy


def test_a_policy_sees_on_a_robot_what_it_saw_in_the_environment(tmp_path):
    path = save_policy(tmp_path / "policy.onnx")
    env = SwarmEnv(3, "doorway", neighbours=3)
    observations, _ = env.reset(seed=4)
    policy = Policy(path, load_robot("turtlebot3_waffle"))
    arena, goals = env._team._arena, env._team._goals
    poses = arena.world.poses
    for row, seen in enumerate(observations.values()):
        order = [row, *(other for other in range(3) if other != row)]
        goal = tuple(goals[row])
        twist = policy.twist(
            arena.ranges[row], goal, goal, poses[order], arena.twists[order], np.array(order)
        )
        away = np.array([0.002, 0.001, 0.0, 0.0, 0.0, 0.0])
        action = seen["goal"] * (2.0, 2.0) * seen["scan"].min() - (seen["neighbours"] * away).sum()
        high = env.action_space("Srobot1").high
        assert (twist.vx, twist.wz) == pytest.approx(np.clip(action, -high, high), abs=1e-5)


ALONG_THE_WAY = """
<ir_version: 8, opset_import: ["": 17]>
policy (float[N, 86] observation) => (float[N, 2] action) <int64[1] first = {75},
    int64[1] last = {77}, int64[1] axis = {1}, float[2, 2] turn = {0.7, 0.0, 0.0, 1.0}> {
    way = Slice(observation, first, last, axis)
    action = MatMul(way, turn) }
"""


def test_a_model_says_itself_what_it_sees(tmp_path):
    """It drives along the shortest way, alike in an environment and as a brain behind a shield."""
    path = save_policy(tmp_path / "policy.onnx", ALONG_THE_WAY)
    sees = {
        "observation": "flat", "normalise": True, "parts": ("scan", "goal", "way", "twist",
        "neighbours"), "rays": 36, "stack": 2, "neighbours": 1, "ticks": 2,
    }  # fmt: skip
    env = RobotEnv(1, "doorway", **sees)
    with pytest.raises(SwarmError, match=r"input observation \[.*86\]; expected some of"):
        Policy(path, load_robot("turtlebot3_waffle"))
    describe_policy(path, env.options)
    assert Policy(path, load_robot("turtlebot3_waffle")).config.ticks == 2
    seen, _ = env.reset(options={"starts": [(-3.0, 1.0, 0.0)], "goals": [(3.0, 1.0)]})
    end = cut = False
    while not (end or cut):
        seen, _, end, cut, info = env.step(seen[75:77] * (0.7, 1.0))
    assert info["reached"]
    with Swarm(robots=1, world="doorway", bench=True, brain=path) as swarm:
        start = swarm["Srobot1"].true_pose
        assert swarm["Srobot1"].go_to((start.x + 1.0, start.y + 1.0)).wait(timeout=40.0)
        assert swarm.report.collisions == 0
    (tmp_path / "none.onnx").write_text("nothing")
    with pytest.raises(SwarmError, match="is no model"):
        describe_policy(tmp_path / "none.onnx", env.options)


LOWER_NUMBERS_DRIVE = """
<ir_version: 8, opset_import: ["": 17]>
policy (float[N, 1] precedence) => (float[N, 2] action) <float[1, 2] speeds = {0.2, 0.0}> {
    wish = MatMul(precedence, speeds)  action = Relu(wish) }
"""


def test_precedence_on_a_robot_is_by_the_numbers_in_beacons(tmp_path):
    path = save_policy(tmp_path / "policy.onnx", LOWER_NUMBERS_DRIVE)
    describe_policy(path, RobotEnv(2, "doorway", parts=("precedence",), neighbours=1).options)
    with Swarm(robots=2, world="doorway", bench=True, brain=path) as swarm:
        starts = [robot.true_pose for robot in swarm]
        for robot, start in zip(swarm, starts, strict=True):
            robot.go_to((start.x + 1.0, start.y))
        swarm.run(seconds=4.0)
        moved = [swarm[f"Srobot{k + 1}"].true_pose.distance(starts[k]) for k in range(2)]
    assert moved[0] > 0.2
    assert moved[1] == 0.0


def test_a_policy_drives_to_goals_on_the_bench(tmp_path):
    path = save_policy(tmp_path / "policy.onnx")
    with Swarm(robots=2, world="doorway", bench=True, brain=path) as swarm:
        start = swarm["Srobot1"].true_pose
        first = swarm["Srobot1"].go_to((start.x + 0.5, start.y))
        assert first.wait(timeout=40.0)
        assert swarm["Srobot1"].state == "idle"
        goal = swarm["Srobot2"].go_to((start.x, start.y))
        swarm.run(seconds=1.0)
        goal.cancel()
        assert goal.wait(timeout=1.0).outcome == "canceled"
        assert swarm.report.collisions == 0


def test_a_policy_that_sees_scans_gets_some(tmp_path):
    """Without LiDARs it saw no wall: its figures were those of a blind one."""
    path = save_policy(tmp_path / "policy.onnx")
    with pytest.raises(SwarmError, match="sees scans, and this run has no LiDARs"):
        run_scenario("doorway", robots=2, brain=path, time_limit=2.0)
    assert run_scenario("doorway", robots=2, brain=path, time_limit=2.0, lidar=True).goals_sent
    (tmp_path / "damaged.onnx").write_text("nothing")
    with pytest.raises(SwarmError, match=r"damaged\.onnx is no model in ONNX"):
        run_scenario("doorway", robots=2, brain=str(tmp_path / "damaged.onnx"), time_limit=2.0)
    path = save_policy(tmp_path / "numbers.onnx", LOWER_NUMBERS_DRIVE)
    describe_policy(path, RobotEnv(2, "doorway", parts=("precedence",), neighbours=1).options)
    assert run_scenario("doorway", robots=2, brain=path, time_limit=2.0).goals_sent


def test_policies_that_are_of_no_use_are_refused(tmp_path):
    with pytest.raises(SwarmError, match="there is no such file"):
        Swarm(robots=1, world="doorway", bench=True, brain="no_such.onnx").start()
    path = save_policy(tmp_path / "wide.onnx", TO_THE_GOAL.replace("360", "12"))
    with pytest.raises(SwarmError, match=r"input scan \[1, 12\]; expected some of"):
        Policy(path, load_robot("turtlebot3_waffle"))
