"""Robots come, go and are put elsewhere through the services, their navigators included."""

import json

import pytest
import yaml
from nav2_msgs.action import NavigateToPose
from rclpy.action import ActionClient
from simulation_interfaces.msg import EntityCategory, Result
from simulation_interfaces.srv import (
    DeleteEntity,
    GetEntities,
    GetEntityState,
    ResetSimulation,
    SetEntityState,
    SpawnEntity,
)

from swarm_common.middleware.ros_io import pose_from_msg, pose_msg, pose_stamped, resource_in
from swarm_common.model.records import Pose
from tests.graph.conftest import ROBOT, START_LIMIT, Process, parameters

OK = Result.RESULT_OK


def entities(swarm, **filters):
    request = GetEntities.Request()
    for name, value in filters.items():
        setattr(request.filters, name, value)
    return swarm.call(GetEntities, "/sim/get_entities", request)


def place_of(swarm, name):
    request = GetEntityState.Request(entity=name)
    answer = swarm.call(GetEntityState, "/sim/get_entity_state", request)
    assert answer.result.result == OK
    return pose_from_msg(answer.state.pose)


def spawn(swarm, pose=None, name="", model=ROBOT):
    request = SpawnEntity.Request(name=name)
    resource_in(request).uri = model
    request.initial_pose.header.frame_id = "spawn"
    if pose is not None:
        request.initial_pose = pose_stamped(pose, 0)
    return swarm.call(SpawnEntity, "/sim/spawn_entity", request)


def move(swarm, name, pose):
    request = SetEntityState.Request(entity=name)
    request.state.pose = pose_msg(pose)
    return swarm.call(SetEntityState, "/sim/set_entity_state", request)


def delete(swarm, name):
    return swarm.call(DeleteEntity, "/sim/delete_entity", DeleteEntity.Request(entity=name))


def drive(swarm, name, pose_map):
    client = ActionClient(swarm.node, NavigateToPose, f"/{name}/navigate_to_pose")
    swarm.spin_until(client.server_is_ready, START_LIMIT)
    goal = NavigateToPose.Goal(pose=pose_stamped(pose_map, 0))
    handle = swarm.result_of(client.send_goal_async(goal), START_LIMIT)
    assert handle.accepted
    return handle.get_result_async()


def start_navigator(swarm, event):
    """Start the navigator of a newcomer, as swarm-up does."""
    name = event["robot"]
    values = parameters(event["number"], event["pose"], event["model"])
    path = swarm.folder / f"{name}.yaml"
    path.write_text(yaml.safe_dump({f"/{name}/navigator": {"ros__parameters": values}}))
    config = swarm.folder / "newcomer.json"
    config.write_text(json.dumps({"robots": [{"name": name, "params": str(path)}]}))
    return Process(
        "swarm_nav.launch.fork_server_main", config, swarm.domain, swarm.folder / "newcomer.log"
    )


def answering(swarm):
    return swarm.world.named("progress")[-1].get("answering", 0)


def speaks(swarm, name):
    """Whether anybody publishes for a robot; our own clients keep subscriptions."""
    return any(swarm.node.count_publishers(f"/{name}/{topic}") for topic in ("odom", "status"))


def test_bad_input_is_refused_with_the_reason(swarm):
    names = SpawnEntity.Response
    for answer, code, words in (
        (spawn(swarm, model="turtlebot9"), names.RESOURCE_PARSE_ERROR, "turtlebot9"),
        (spawn(swarm, name="Srobot1"), names.NAME_NOT_UNIQUE, "Srobot1"),
        (spawn(swarm, name="Hans"), names.NAME_INVALID, "Hans"),
        (spawn(swarm, pose=Pose(99.0, 0.0, 0.0)), names.INVALID_POSE, "99.00"),
        (spawn(swarm, pose=place_of(swarm, "Srobot1")), names.INVALID_POSE, "Srobot1"),
        (spawn(swarm, model=""), names.NO_RESOURCE, "model"),
        (delete(swarm, "Srobot7"), Result.RESULT_NOT_FOUND, "Srobot7"),
        (move(swarm, "Srobot7", Pose(0, 0, 0)), Result.RESULT_NOT_FOUND, "Srobot7"),
        (move(swarm, "Srobot2", place_of(swarm, "Srobot1")), 101, "Srobot1"),
        (entities(swarm, filter="("), Result.RESULT_OPERATION_FAILED, "("),
    ):
        assert answer.result.result == code, answer
        assert words in answer.result.error_message
    state = GetEntityState.Request(entity="x")
    answer = swarm.call(GetEntityState, "/sim/get_entity_state", state)
    assert answer.result.result == Result.RESULT_NOT_FOUND
    reset = ResetSimulation.Request(scope=ResetSimulation.Request.SCOPE_TIME)
    answer = swarm.call(ResetSimulation, "/sim/reset_simulation", reset)
    assert answer.result.result == Result.RESULT_FEATURE_UNSUPPORTED
    robots = [EntityCategory(category=EntityCategory.CATEGORY_ROBOT)]
    assert list(entities(swarm, categories=robots).entities) == ["Srobot1", "Srobot2"]
    assert list(entities(swarm, filter="2$").entities) == ["Srobot2"]


@pytest.mark.timeout(400)
def test_a_robot_comes_drives_is_put_elsewhere_and_goes(swarm):
    place = Pose(3.0, 3.0, 1.0)
    answer = spawn(swarm, place, model="turtlebot3_burger")
    assert (answer.result.result, answer.entity_name) == (OK, "Srobot3")
    swarm.world.wait_for("spawned")
    (note,) = swarm.world.named("note")
    assert "does not meet a turtlebot3_waffle: it may hit one that falls" in note["message"]
    newcomer = start_navigator(swarm, swarm.world.named("spawned")[0])
    try:
        newcomer.wait_for("active")
        swarm.spin_until(lambda: answering(swarm) == 3, START_LIMIT)
        ahead = place_of(swarm, "Srobot3").compose(Pose(1.0, 0.0, 0.0))
        result = swarm.result_of(drive(swarm, "Srobot3", ahead), START_LIMIT)
        assert result.result.error_code == 0
        assert place_of(swarm, "Srobot3").distance(ahead) < 0.4

        there = Pose(-3.0, 3.0, 0.0)
        assert move(swarm, "Srobot3", there).result.result == OK
        assert place_of(swarm, "Srobot3").distance(there) < 0.02
        result = swarm.result_of(drive(swarm, "Srobot3", Pose(-2.0, 3.0, 0.0)), START_LIMIT)
        assert result.result.error_code == 0
        assert place_of(swarm, "Srobot3").distance(Pose(-2.0, 3.0, 0.0)) < 0.4
    finally:
        if delete(swarm, "Srobot3").result.result == OK:
            newcomer.end()
    assert list(entities(swarm).entities) == ["Srobot1", "Srobot2"]
    assert [event["robot"] for event in swarm.world.named("removed")] == ["Srobot3"]
    swarm.spin_until(lambda: not speaks(swarm, "Srobot3"))
    swarm.spin_until(lambda: answering(swarm) == 2)
    collisions = swarm.world.named("progress")[-1]["collisions"]
    assert set(collisions.values()) == {0}


@pytest.mark.timeout(400)
def test_who_was_taken_out_is_no_obstacle_and_reset_brings_the_others_home(swarm):
    first, second = place_of(swarm, "Srobot1"), place_of(swarm, "Srobot2")
    assert delete(swarm, "Srobot2").result.result == OK
    result = swarm.result_of(drive(swarm, "Srobot1", second), START_LIMIT)
    assert result.result.error_code == 0
    assert place_of(swarm, "Srobot1").distance(second) < 0.4
    answer = swarm.call(ResetSimulation, "/sim/reset_simulation", ResetSimulation.Request())
    assert answer.result.result == OK
    assert place_of(swarm, "Srobot1").distance(first) < 0.02
