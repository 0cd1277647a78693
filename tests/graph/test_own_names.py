"""Robots with names of their own: Nav2's clients, words of the robots, newcomers, frames."""

from lifecycle_msgs.srv import GetState
from rcl_interfaces.srv import GetParameters
from simulation_interfaces.msg import Result
from simulation_interfaces.srv import SpawnEntity
from swarm_interfaces.msg import RobotStatus

from swarm_commander.viewers.frame_relay import FrameRelay
from swarm_common.middleware.ros_io import pose_stamped, resource_in
from swarm_common.model.records import Pose
from swarm_common.model.robot_names import RobotNames
from swarm_run.robots.client import RobotCommander
from swarm_run.robots.discovery import robots_in_graph
from swarm_run.robots.task import TaskResult
from tests.graph.conftest import ROBOT, START_LIMIT

NAMES = RobotNames(("amr_beta", "amr_alpha"), "agv{:02}")


ROBOTS = 3
OPTIONS = dict(names=NAMES)


def test_a_client_of_nav2_drives_a_robot_in_its_namespace(swarm):
    robot = RobotCommander(swarm.node, "agv03")
    swarm.spin_until(robot.isReady, START_LIMIT)
    _, home = read_start_of(swarm, "agv03")
    task = robot.goToPose(pose_stamped(home.compose(Pose(0.5, 0.0, 0.0)), 0))
    swarm.spin_until(lambda: task.is_complete, START_LIMIT)
    assert robot.getResult() == TaskResult.SUCCEEDED
    state = swarm.call(GetState, "/agv03/bt_navigator/get_state", GetState.Request())
    assert state.current_state.label == "active"


def read_start_of(swarm, robot):
    names = ["robot_id", *(f"initial_pose.{name}" for name in ("x", "y", "yaw"))]
    request = GetParameters.Request(names=names)
    values = swarm.call(GetParameters, f"/{robot}/navigator/get_parameters", request).values
    return values[0].integer_value, Pose(*(value.double_value for value in values[1:]))


def test_numbers_are_places_in_the_list_and_robots_call_each_other_by_name(swarm):
    assert [read_start_of(swarm, name)[0] for name in swarm.names] == [1, 2, 3]
    # One is sent to where another stands, and says for whom it waits.
    said = []
    topic = "/amr_beta/status"
    subscription = swarm.node.create_subscription(RobotStatus, topic, said.append, 10)
    _, there = read_start_of(swarm, "amr_alpha")
    robot = RobotCommander(swarm.node, "amr_beta")
    swarm.spin_until(robot.isReady, START_LIMIT)
    robot.goToPose(pose_stamped(there, 0))
    swarm.spin_until(lambda: any("amr_alpha" in s.detail for s in said), START_LIMIT)
    robot.cancelTask()
    assert not any("Srobot" in status.detail for status in said)
    swarm.node.destroy_subscription(subscription)


def test_a_newcomer_is_called_by_the_pattern(swarm):
    request = SpawnEntity.Request(name="Srobot7")
    resource_in(request).uri = ROBOT
    request.initial_pose.header.frame_id = "spawn"
    refused = swarm.call(SpawnEntity, "/sim/spawn_entity", request).result
    assert refused.result == SpawnEntity.Response.NAME_INVALID
    assert "expected amr_beta and amr_alpha and agv03" not in refused.error_message
    assert "agv04" in refused.error_message
    request.name = ""
    answer = swarm.call(SpawnEntity, "/sim/spawn_entity", request)
    assert answer.result.result == Result.RESULT_OK, answer.result.error_message
    assert answer.entity_name == "agv04"


def test_robots_are_found_and_their_frames_relayed(swarm):
    swarm.spin_until(lambda: robots_in_graph(swarm.node) >= {*swarm.names}, START_LIMIT)
    assert robots_in_graph(swarm.node) <= {*swarm.names, "agv04"}
    relay = FrameRelay(swarm.node)
    swarm.spin_until(lambda: relay.look() or len(relay.robots) >= 3, START_LIMIT)
    assert {*swarm.names} <= {*relay.robots} <= {*swarm.names, "agv04"}
