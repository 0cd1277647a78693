"""Nav2's face: what its clients and the lifecycle tools ask for is there, or says no at once."""

from __future__ import annotations

import itertools
import math
import time

import pytest
from builtin_interfaces.msg import Duration
from geometry_msgs.msg import PoseStamped, Twist
from lifecycle_msgs import srv as lifecycle
from lifecycle_msgs.msg import Transition
from nav2_msgs import action, srv
from nav_msgs.msg import Odometry, Path
from rclpy.action import ActionClient
from rclpy.clock import ClockType
from rclpy.time import Time
from std_msgs.msg import Empty

from swarm_common.middleware.ros_io import pose_from_msg, pose_stamped
from swarm_common.model.records import Pose
from swarm_ros2 import cli
from tests.graph.conftest import START_LIMIT

NAMES = ("amcl", "behavior_server", "bt_navigator", "controller_server", "map_server",
         "planner_server")  # fmt: skip
SUCCEEDED, CANCELED, ABORTED = 4, 5, 6


@pytest.fixture(scope="module")
def swarm(start_swarm):
    started = start_swarm(2)
    started.wait_until_active()
    return started


def now_of_the_wall():
    """What a client stamps with that does not use simulated time."""
    return Time(nanoseconds=time.time_ns(), clock_type=ClockType.ROS_TIME).to_msg()


def begin(swarm, kind, name, goal, feedback=None, robot="Srobot1"):
    client = ActionClient(swarm.node, kind, f"/{robot}/{name}")
    swarm.spin_until(client.server_is_ready, START_LIMIT)
    handle = swarm.result_of(client.send_goal_async(goal, feedback_callback=feedback))
    assert handle.accepted
    return client, handle


def run(swarm, kind, name, goal, feedback=None):
    client, handle = begin(swarm, kind, name, goal, feedback)
    answer = swarm.result_of(handle.get_result_async(), 60.0)
    client.destroy()
    return answer


def place(swarm, robot="Srobot1"):
    poses = []
    topic = f"/{robot}/ground_truth"
    subscription = swarm.node.create_subscription(Odometry, topic, poses.append, 10)
    swarm.spin_until(lambda: poses)
    swarm.node.destroy_subscription(subscription)
    return pose_from_msg(poses[-1].pose.pose)


def stamped(pose):
    message = pose_stamped(pose, 0)
    message.header.stamp = now_of_the_wall()
    return message


def ahead(swarm, distance):
    return place(swarm).compose(Pose(distance, 0.0, 0.0))


@pytest.mark.parametrize(
    ("kind", "name", "field"),
    [
        (action.NavigateToPose, "navigate_to_pose", "pose"),
        (action.NavigateThroughPoses, "navigate_through_poses", "poses"),
        (action.FollowWaypoints, "follow_waypoints", "poses"),
    ],
)
def test_goals_with_wall_clock_stamps_are_reached_and_give_feedback(swarm, kind, name, field):
    """They were accepted and never began."""
    target = stamped(ahead(swarm, 0.5))
    goal = kind.Goal(**{field: target if field == "pose" else [target]})
    seen = []
    answer = run(swarm, kind, name, goal, seen.append)
    assert (answer.status, answer.result.error_code) == (SUCCEEDED, 0)
    assert seen


def test_goal_pose_with_a_wall_clock_stamp_begins(swarm):
    there = ahead(swarm, 0.5)
    publisher = swarm.node.create_publisher(PoseStamped, "/Srobot1/goal_pose", 10)
    swarm.spin_until(lambda: publisher.get_subscription_count() > 0)
    publisher.publish(stamped(there))
    swarm.spin_until(lambda: place(swarm).distance(there) < 0.3)
    swarm.node.destroy_publisher(publisher)


def states(swarm):
    return {
        swarm.call(lifecycle.GetState, f"/Srobot1/{name}/get_state", lifecycle.GetState.Request())
        .current_state.label
        for name in NAMES
    }  # fmt: skip


def test_lifecycle_of_each_of_nav2s_nodes(swarm):
    nodes = {(name, "/Srobot1") for name in NAMES}
    swarm.spin_until(lambda: nodes <= set(swarm.node.get_node_names_and_namespaces()), START_LIMIT)
    assert states(swarm) == {"active"}
    kind = lifecycle.GetAvailableTransitions
    for name, found in (
        ("get_available_transitions", {(4, "deactivate"), (7, "shutdown")}),
        ("get_transition_graph", {(1, "configure"), (2, "cleanup"), (3, "activate"),
                                  (4, "deactivate"), (5, "shutdown"), (6, "shutdown"),
                                  (7, "shutdown")}),
    ):  # fmt: skip
        answer = swarm.call(kind, f"/Srobot1/planner_server/{name}", kind.Request())
        ways = [way.transition for way in answer.available_transitions]
        assert {(way.id, way.label) for way in ways} == found
    kind = lifecycle.GetAvailableStates
    answer = swarm.call(kind, "/Srobot1/amcl/get_available_states", kind.Request())
    assert {state.id for state in answer.available_states} == {0, 1, 2, 3, 4, *range(10, 16)}


def change(swarm, **fields):
    kind = lifecycle.ChangeState
    request = kind.Request(transition=Transition(**fields))
    return swarm.call(kind, "/Srobot1/bt_navigator/change_state", request).success


def test_transitions_are_those_of_the_whole_robot(swarm):
    assert not change(swarm, label="configure")
    assert change(swarm, label="deactivate")
    assert states(swarm) == {"inactive"}
    assert change(swarm, id=Transition.TRANSITION_CLEANUP)
    assert change(swarm, id=Transition.TRANSITION_CONFIGURE)
    assert change(swarm, label="activate")
    assert states(swarm) == {"active"}


def test_ros2_lifecycle(swarm, capfd, monkeypatch):
    monkeypatch.setenv("ROS_DOMAIN_ID", str(swarm.domain))

    def ros2(*words, code=0):
        capfd.readouterr()
        assert cli.run(["lifecycle", *words]) == code
        return capfd.readouterr()

    nodes = ros2("nodes").out.splitlines()
    assert {f"/{robot}/{name}" for robot in swarm.names for name in NAMES} <= set(nodes)
    assert ros2("get", "/Srobot2/planner_server").out == "active [3]\n"
    expected = (
        "- deactivate [4]\n\tStart: active\n\tGoal: deactivating\n"
        "- shutdown [7]\n\tStart: active\n\tGoal: shuttingdown\n"
    )
    assert ros2("list", "/Srobot2/amcl").out == expected
    assert ros2("set", "/Srobot2/amcl", "deactivate").out == "Transitioning successful\n"
    assert ros2("get", "/Srobot2/bt_navigator").out == "inactive [2]\n"
    assert ros2("set", "/Srobot2/amcl", "3").out == "Transitioning successful\n"
    assert "- deactivate [4]" in ros2("set", "/Srobot2/amcl", "configure", code=1).err


@pytest.mark.parametrize(
    ("kind", "name", "code"),
    [
        (action.DockRobot, "dock_robot", 901),
        (action.UndockRobot, "undock_robot", 902),
        (action.FollowGPSWaypoints, "follow_gps_waypoints", 600),
    ],
)
def test_what_there_is_not_is_refused_at_once(swarm, kind, name, code):
    answer = run(swarm, kind, name, kind.Goal())
    assert (answer.status, answer.result.error_code) == (ABORTED, code)
    assert answer.result.error_msg


def smooth(swarm, poses, **fields):
    path = Path(poses=[pose_stamped(pose, 0) for pose in poses])
    path.header.frame_id = "map"
    goal = action.SmoothPath.Goal(path=path, **fields)
    return run(swarm, action.SmoothPath, "smooth_path", goal)


def bend(poses):
    """Return the largest turn [rad] between two steps."""
    steps = [(b.x - a.x, b.y - a.y) for a, b in itertools.pairwise(poses)]
    yaws = [math.atan2(y, x) for x, y in steps if math.hypot(x, y) > 1e-6]
    return max(abs(math.remainder(b - a, math.tau)) for a, b in itertools.pairwise(yaws))


def test_a_path_is_smoothed(swarm):
    corner = [Pose(2.0, 3.0, 0.0), Pose(3.0, 3.0, 0.0), Pose(3.0, 4.0, 1.0)]
    answer = smooth(swarm, corner)
    assert (answer.status, answer.result.was_completed) == (SUCCEEDED, True)
    poses = [pose_from_msg(stamped.pose) for stamped in answer.result.path.poses]
    assert poses[0].distance(corner[0]) < 1e-6
    assert poses[-1] == pytest.approx(corner[-1])
    assert bend(poses) < 0.5 < bend(corner)
    outside = [Pose(2.0, 3.0, 0.0), Pose(2.0, 30.0, 0.0)]
    for poses, fields, code in (
        (corner, {"smoother_id": "spline"}, 501),
        (outside, {"check_for_collisions": True}, 503),
        ([], {}, 505),
    ):
        answer = smooth(swarm, poses, **fields)
        assert (answer.status, answer.result.error_code) == (ABORTED, code)


def test_assisted_teleop_drives_and_turns_as_it_is_told_and_ends(swarm):
    publisher = swarm.node.create_publisher(Twist, "/Srobot1/cmd_vel_teleop", 10)
    ending = swarm.node.create_publisher(Empty, "/Srobot1/preempt_teleop", 10)
    seen = []
    client, handle = begin(
        swarm, action.AssistedTeleop, "assisted_teleop", action.AssistedTeleop.Goal(), seen.append
    )
    swarm.spin_until(lambda: publisher.get_subscription_count() > 0)

    def steer(vx, wz, until):
        twist = Twist()
        twist.linear.x, twist.angular.z = vx, wz
        end = time.monotonic() + 30.0
        while not until():
            assert time.monotonic() < end
            publisher.publish(twist)
            swarm.spin(0.05)

    start = place(swarm)
    steer(0.0, 0.5, lambda: abs(math.remainder(place(swarm).yaw - start.yaw, math.tau)) > 0.4)
    assert place(swarm).distance(start) < 0.05
    steer(-0.1, 0.0, lambda: place(swarm).distance(start) > 0.15)
    ending.publish(Empty())
    assert swarm.result_of(handle.get_result_async()).status == SUCCEEDED
    assert seen
    client.destroy()
    goal = action.AssistedTeleop.Goal(time_allowance=Duration(sec=1))
    answer = run(swarm, action.AssistedTeleop, "assisted_teleop", goal)
    assert (answer.status, answer.result.error_code) == (ABORTED, 731)


def test_parts_of_the_costmaps_are_cleared(swarm):
    for space in ("global_costmap", "local_costmap"):
        for kind, name in (
            (srv.ClearCostmapAroundRobot, f"{space}/clear_around_{space}"),
            (srv.ClearCostmapExceptRegion, f"{space}/clear_except_{space}"),
            (srv.ClearCostmapAroundPose, f"{space}/clear_around_pose_{space}"),
        ):
            swarm.call(kind, f"/Srobot1/{name}", kind.Request(reset_distance=1.0))
