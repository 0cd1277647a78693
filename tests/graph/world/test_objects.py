"""Things come, are shown and seen, and go, through the services."""

import pytest
from rclpy.qos import qos_profile_sensor_data
from sensor_msgs.msg import LaserScan
from simulation_interfaces.msg import EntityCategory, Result, SimulationState
from simulation_interfaces.srv import (
    DeleteEntity,
    GetEntities,
    GetEntityState,
    ResetSimulation,
    SetEntityState,
    SetSimulationState,
    SpawnEntity,
    StepSimulation,
)
from visualization_msgs.msg import Marker, MarkerArray

from swarm_common.middleware.ros_io import pose_from_msg, pose_msg, resource_in
from swarm_common.model.records import Pose

OK = Result.RESULT_OK
POST = (
    '<sdf version="1.7"><model name="post"><static>true</static><link name="l">'
    '<collision name="c"><geometry><cylinder><radius>0.2</radius><length>1</length></cylinder>'
    "</geometry></collision></link></model></sdf>"
)


ROBOTS = 1


def spawn(swarm, x, y, name="", text=POST):
    request = SpawnEntity.Request(name=name)
    resource_in(request).resource_string = text
    request.initial_pose.header.frame_id = "ground"
    request.initial_pose.pose = pose_msg(Pose(x, y, 0.0))
    return swarm.call(SpawnEntity, "/sim/spawn_entity", request)


def delete(swarm, name):
    return swarm.call(DeleteEntity, "/sim/delete_entity", DeleteEntity.Request(entity=name))


def place_of(swarm, name):
    request = GetEntityState.Request(entity=name)
    answer = swarm.call(GetEntityState, "/sim/get_entity_state", request)
    assert answer.result.result == OK, answer
    return answer.state.pose


def objects(swarm):
    request = GetEntities.Request()
    request.filters.categories = [EntityCategory(category=EntityCategory.CATEGORY_OBJECT)]
    return list(swarm.call(GetEntities, "/sim/get_entities", request).entities)


def set_state(swarm, state):
    request = SetSimulationState.Request(state=SimulationState(state=state))
    return swarm.call(SetSimulationState, "/sim/set_simulation_state", request).result.result


def shown(messages):
    return {marker.text or marker.id: marker.action for marker in messages[-1].markers}


def test_a_thing_comes_is_shown_and_seen_and_goes_while_the_world_is_paused(swarm):
    movers, scans = [], []
    node = swarm.node
    node.create_subscription(MarkerArray, "/sim/movers", movers.append, 10)
    node.create_subscription(LaserScan, "/Srobot1/scan", scans.append, qos_profile_sensor_data)
    assert set_state(swarm, SimulationState.STATE_PAUSED) == OK
    robot = pose_from_msg(place_of(swarm, "Srobot1"))
    ahead = robot.compose(Pose(1.0, 0.0, 0.0))

    answer = spawn(swarm, robot.x, robot.y)
    assert answer.result.result == SpawnEntity.Response.INVALID_POSE
    assert "Srobot1 stands" in answer.result.error_message
    answer = spawn(swarm, ahead.x, ahead.y)
    assert (answer.result.result, answer.entity_name) == (OK, "post")
    assert place_of(swarm, "post").position.z == pytest.approx(0.5)
    assert objects(swarm) == ["post"]
    swarm.spin_until(lambda: movers and shown(movers).get("post") == Marker.ADD)

    before = len(scans)
    steps = swarm.call(StepSimulation, "/sim/step_simulation", StepSimulation.Request(steps=4))
    assert steps.result.result == OK
    swarm.spin_until(lambda: len(scans) > before)
    assert 0.6 < scans[-1].ranges[0] < 1.0

    state = SetEntityState.Request(entity="post")
    state.state.pose = pose_msg(robot.compose(Pose(2.0, 0.0, 0.0)))
    state.state.pose.position.z = 0.5
    assert swarm.call(SetEntityState, "/sim/set_entity_state", state).result.result == OK
    assert delete(swarm, "post").result.result == OK
    assert objects(swarm) == []
    swarm.spin_until(lambda: Marker.DELETE in shown(movers).values())
    assert delete(swarm, "post").result.result == Result.RESULT_NOT_FOUND
    assert set_state(swarm, SimulationState.STATE_PLAYING) == OK


def test_reset_takes_out_what_came(swarm):
    start = pose_from_msg(place_of(swarm, "Srobot1"))
    middle = start.compose(Pose(1.2, 0.0, 0.0))
    assert spawn(swarm, middle.x, middle.y).result.result == OK
    assert spawn(swarm, middle.x, middle.y, "second").result.result == (
        SpawnEntity.Response.INVALID_POSE
    )
    assert objects(swarm) == ["post"]
    answer = swarm.call(ResetSimulation, "/sim/reset_simulation", ResetSimulation.Request())
    assert answer.result.result == OK
    assert objects(swarm) == []
    assert pose_from_msg(place_of(swarm, "Srobot1")).distance(start) < 0.1
