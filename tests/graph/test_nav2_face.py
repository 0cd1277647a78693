"""Nav2's face: what its clients and the lifecycle tools ask for is there, or says no at once."""

import itertools
import math
import shutil
import time

import numpy as np
import pytest
from builtin_interfaces.msg import Duration
from geometry_msgs.msg import PoseStamped, Twist
from lifecycle_msgs import srv as lifecycle
from lifecycle_msgs.msg import Transition
from map_msgs.msg import OccupancyGridUpdate
from nav2_msgs import action, srv
from nav2_msgs.msg import Costmap, CostmapUpdate, SpeedLimit
from nav_msgs.msg import OccupancyGrid, Odometry, Path
from rcl_interfaces.msg import Parameter, ParameterEvent, ParameterType, ParameterValue
from rcl_interfaces.srv import DescribeParameters, SetParameters
from rclpy.action import ActionClient
from rclpy.clock import ClockType
from rclpy.time import Time
from std_msgs.msg import Empty
from swarm_interfaces.msg import RobotStatus

from swarm_common.files.resources import share_directory
from swarm_common.middleware.ros_io import LATCHED, pose_from_msg, pose_stamped, start_text, tick_of
from swarm_common.model.records import Pose
from swarm_ros2 import command_line
from swarm_run.robots.client import RobotCommander
from swarm_run.robots.task import TaskResult
from tests.graph.conftest import START_LIMIT, WORLD

NAMES = ("amcl", "behavior_server", "bt_navigator", "controller_server", "map_server",
         "planner_server")  # fmt: skip
SUCCEEDED, CANCELED, ABORTED = 4, 5, 6
FREE_PLACES = (Pose(-2.9, -0.6, math.pi), Pose(-1.6, -0.6, math.pi))  # Srobot2 is far from both


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


def misspelled(pose):
    pose.header.frame_id = "Map"


def not_a_number(pose):
    pose.pose.position.x = math.nan


def without_unit_length(pose):
    pose.pose.orientation.w = pose.pose.orientation.z = 0.2


@pytest.mark.parametrize(
    ("spoil", "reason"),
    [(misspelled, "frame"), (not_a_number, "not finite"), (without_unit_length, "quaternion")],
)
def test_a_program_learns_why_its_goal_is_refused(swarm, spoil, reason):
    robot = RobotCommander(swarm.node, "Srobot1")
    swarm.spin_until(robot.isReady, START_LIMIT)
    pose = pose_stamped(ahead(swarm, 0.5), 0)
    spoil(pose)
    task = robot.goToPose(pose)
    swarm.spin_until(robot.isTaskComplete)
    assert robot.getResult() is TaskResult.FAILED
    assert task.reason.startswith("the robot refused the goal: ")
    assert reason in task.reason


def start_of_plan(swarm, frame):
    goal = action.ComputePathToPose.Goal(use_start=True, goal=stamped(ahead(swarm, 0.5)))
    goal.start.header.frame_id = frame
    result = run(swarm, action.ComputePathToPose, "compute_path_to_pose", goal).result
    return [pose_from_msg(item.pose) for item in result.path.poses[:1]], result.error_msg


@pytest.mark.parametrize("frame", ["base_scan", "/base_scan", "Srobot1/base_scan"])
def test_poses_in_any_fixed_frame_of_the_robot_are_brought_to_map_by_tf(swarm, frame):
    (start,), _ = start_of_plan(swarm, frame)
    here = place(swarm)
    expected = here.compose(Pose(-0.064, 0.0, 0.0))  # of a waffle's LiDAR
    assert math.hypot(start.x - expected.x, start.y - expected.y) < 0.01


def test_an_unknown_frame_is_refused_with_those_that_are_known(swarm):
    poses, message = start_of_plan(swarm, "camera_7")
    assert poses == []
    assert "'camera_7' is unknown; known: map, odom, base_footprint, base_link" in message


def test_a_changed_parameter_is_an_event_of_the_whole_graph(swarm):
    events = []
    subscription = swarm.node.create_subscription(
        ParameterEvent, "/parameter_events", events.append, 10
    )
    value = ParameterValue(type=ParameterType.PARAMETER_DOUBLE, double_value=2.5)
    request = SetParameters.Request(parameters=[Parameter(name="planner.lane_weight", value=value)])
    swarm.spin(1.0)
    swarm.call(SetParameters, "/Srobot1/navigator/set_parameters", request)
    swarm.spin_until(lambda: [e for e in events if e.node == "/Srobot1/navigator"], 10.0)
    (changed,) = events[-1].changed_parameters
    assert (changed.name, changed.value.double_value) == ("planner.lane_weight", 2.5)
    swarm.node.destroy_subscription(subscription)


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
        assert command_line.run(words) == code
        return capfd.readouterr()

    nodes = {f"/{robot}/{name}" for robot in swarm.names for name in NAMES}
    served = swarm.node.get_service_names_and_types  # they come one after the other
    wanted = {f"{name}/get_state" for name in nodes}
    swarm.spin_until(lambda: wanted <= dict(served()).keys(), START_LIMIT)
    assert nodes <= set(ros2("lifecycle", "nodes").out.splitlines())
    assert ros2("lifecycle", "get", "/Srobot2/planner_server").out == "active [3]\n"
    expected = (
        "- deactivate [4]\n\tStart: active\n\tGoal: deactivating\n"
        "- shutdown [7]\n\tStart: active\n\tGoal: shuttingdown\n"
    )
    assert ros2("lifecycle", "list", "/Srobot2/amcl").out == expected
    done = "Transitioning successful\n"
    assert ros2("lifecycle", "set", "/Srobot2/amcl", "deactivate").out == done
    assert ros2("lifecycle", "get", "/Srobot2/bt_navigator").out == "inactive [2]\n"
    assert ros2("lifecycle", "set", "/Srobot2/amcl", "3").out == done
    assert "- deactivate [4]" in ros2("lifecycle", "set", "/Srobot2/amcl", "configure", code=1).err


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
            # as nav2_simple_commander asks for them
            (srv.ClearCostmapAroundRobot, f"{space}/clear_costmap_around_robot"),
            (srv.ClearCostmapExceptRegion, f"{space}/clear_costmap_except_region"),
            (srv.ClearCostmapAroundPose, f"{space}/clear_costmap_around_pose"),
        ):
            swarm.call(kind, f"/Srobot1/{name}", kind.Request(reset_distance=1.0))


@pytest.fixture
def load_map(swarm):
    """Return what loads a map into a robot; in the end each has the map of its world again."""
    changed = set()

    def load(url, robot="Srobot1"):
        changed.add(robot)
        request = srv.LoadMap.Request(map_url=str(url))
        return swarm.call(srv.LoadMap, f"/{robot}/map_server/load_map", request).result

    yield load
    own = (share_directory("maps") / "maps" / WORLD).with_suffix(".yaml")
    for robot in sorted(changed):
        assert load(own, robot) == srv.LoadMap.Response.RESULT_SUCCESS


@pytest.mark.parametrize("name", ["a#b", "a?b", "a;b", "a%20b", "a b"])
def test_the_path_of_a_map_is_as_it_is_written(load_map, tmp_path, name):
    folder = tmp_path / name
    folder.mkdir()
    shipped = share_directory("maps") / "maps" / "hall_12"
    for ending in (".yaml", ".pgm"):
        shutil.copy(shipped.with_suffix(ending), folder)
    for url in (f"{folder}/hall_12.yaml", (folder / "hall_12.yaml").as_uri()):
        assert load_map(url) == srv.LoadMap.Response.RESULT_SUCCESS, url


def test_what_is_wrong_with_a_map_is_told_apart(load_map, tmp_path):
    file = tmp_path / "map.yaml"
    codes = srv.LoadMap.Response
    assert load_map(file) == codes.RESULT_MAP_DOES_NOT_EXIST
    file.write_text("resolution: 0.05\n")
    assert load_map(file) == codes.RESULT_INVALID_MAP_METADATA
    file.write_text("image: none.png\nresolution: 0.05\norigin: [0.0, 0.0, 0.0]\n")
    assert load_map(file) == codes.RESULT_INVALID_MAP_DATA
    (tmp_path / "coarse.pgm").write_bytes(b"P5 40 40 255\n" + bytes([254]) * 1600)
    coarse = "image: coarse.pgm\nresolution: 10.0\norigin: [0.0, 0.0, 0.0]\nnegate: 0\n"
    file.write_text(coarse + "occupied_thresh: 0.65\nfree_thresh: 0.25\n")
    # Too fine when refined; it ended the robot.
    assert load_map(file) == codes.RESULT_INVALID_MAP_METADATA


def listen(swarm, kind, name):
    """Subscribe as Nav2's own costmap subscriber does; return what arrives."""
    heard = []
    topic = f"/Srobot1/{name}"
    subscription = swarm.node.create_subscription(kind, topic, heard.append, LATCHED)
    return subscription, heard


@pytest.mark.parametrize("space", ["global_costmap", "local_costmap"])
def test_raw_costs_are_those_of_the_occupancy_grid(swarm, space):
    subscriptions, (grids, costmaps) = zip(
        listen(swarm, OccupancyGrid, f"{space}/costmap"),
        listen(swarm, Costmap, f"{space}/costmap_raw"),
        strict=True,
    )

    def pairs():
        stamps = {grid.header.stamp.sec + 1e-9 * grid.header.stamp.nanosec: grid for grid in grids}
        return [
            (stamps[at], costmap)
            for costmap in costmaps
            if (at := costmap.header.stamp.sec + 1e-9 * costmap.header.stamp.nanosec) in stamps
        ]

    swarm.spin_until(pairs, START_LIMIT)
    grid, costmap = pairs()[-1]
    info = costmap.metadata
    assert (info.layer, costmap.header.frame_id) == ("master", "map")
    assert (info.size_x, info.size_y) == (grid.info.width, grid.info.height)
    assert (info.resolution, info.origin) == (grid.info.resolution, grid.info.origin)
    # As nav2_costmap_2d documents its costs: 0 free, 253 inscribed, 254 lethal, 255 unknown.
    named = {0: 0, 253: 99, 254: 100, 255: -1}
    expected = [named.get(cost, 1 + 97 * (cost - 1) // 251) for cost in costmap.data]
    assert expected == list(grid.data)
    assert {0, 254} <= set(costmap.data)
    for subscription in subscriptions:
        swarm.node.destroy_subscription(subscription)


def test_changes_make_the_old_costmap_the_new_one(swarm):
    """A client of `costmap_raw_updates`: the costmap, a change of it, and it is the next one."""
    subscriptions, (whole, changes, grids) = zip(
        listen(swarm, Costmap, "global_costmap/costmap_raw"),
        listen(swarm, CostmapUpdate, "global_costmap/costmap_raw_updates"),
        listen(swarm, OccupancyGridUpdate, "global_costmap/costmap_updates"),
        strict=True,
    )
    swarm.spin_until(lambda: len(whole) > 1, START_LIMIT)
    target = stamped(place(swarm, "Srobot2").compose(Pose(0.6, 0.0, 0.0)))
    goal = action.NavigateToPose.Goal(pose=target)  # what the other one holds is in the costmap
    client, handle = begin(swarm, action.NavigateToPose, "navigate_to_pose", goal, robot="Srobot2")
    swarm.spin_until(lambda: changes and grids, START_LIMIT)
    swarm.result_of(handle.get_result_async(), 60.0)
    client.destroy()
    change = changes[-1]
    swarm.spin_until(lambda: any(one.header.stamp == change.header.stamp for one in whole))
    now = next(i for i, one in enumerate(whole) if one.header.stamp == change.header.stamp)
    width = whole[now].metadata.size_x
    before = np.array(whole[now - 1].data).reshape(-1, width)
    area = np.array(change.data).reshape(change.size_y, change.size_x)
    before[change.y : change.y + change.size_y, change.x : change.x + change.size_x] = area
    assert (before == np.array(whole[now].data).reshape(-1, width)).all()
    assert len(change.data) < len(whole[now].data)
    occupancy = next(one for one in grids if one.header.stamp == change.header.stamp)
    size = (occupancy.x, occupancy.y, occupancy.width, occupancy.height)
    assert size == (change.x, change.y, change.size_x, change.size_y)
    for subscription in subscriptions:
        swarm.node.destroy_subscription(subscription)


def test_what_is_beyond_a_range_is_refused_and_described(swarm):
    kind = DescribeParameters
    names = ["costmap.inflation_radius", "vx_samples", "traffic.confirmations", "holding.mode",
             "planner.allow_unknown", "robot_id", "robot.wheel_radius", "max_vel_x"]  # fmt: skip
    answer = swarm.call(kind, "/Srobot1/navigator/describe_parameters", kind.Request(names=names))
    found = dict(zip(names, answer.descriptors, strict=True))
    assert [descriptor.name for descriptor in answer.descriptors] == names
    assert all(descriptor.description for descriptor in answer.descriptors)
    (limits,) = found["costmap.inflation_radius"].floating_point_range
    assert (limits.from_value, limits.to_value, limits.step) == (0.01, 50.0, 0.0)
    (limits,) = found["vx_samples"].integer_range
    assert (limits.from_value, limits.to_value) == (2, 100)
    (limits,) = found["max_vel_x"].floating_point_range
    assert (limits.from_value, limits.to_value) == (0.0, pytest.approx(0.26))  # its model's
    assert found["max_vel_x"].additional_constraints == "more than 0"
    assert found["holding.mode"].additional_constraints == "one of circuit, park, auto"
    read_only = {name for name in names if found[name].read_only}
    assert read_only == {"traffic.confirmations", "robot_id", "robot.wheel_radius"}
    value = ParameterValue(type=ParameterType.PARAMETER_DOUBLE, double_value=51.0)
    parameter = Parameter(name="costmap.inflation_radius", value=value)
    kind = SetParameters
    answer = swarm.call(
        kind, "/Srobot1/navigator/set_parameters", kind.Request(parameters=[parameter])
    )
    (result,) = answer.results
    assert not result.successful
    assert result.reason == "costmap.inflation_radius is 51.0; it must be from 0.01 to 50"


def test_ros2_param_describe_prints_unit_range_and_effect(swarm, capfd, monkeypatch):
    monkeypatch.setenv("ROS_DOMAIN_ID", str(swarm.domain))
    capfd.readouterr()
    names = ("costmap.inflation_radius", "traffic.lost_ticks")
    assert command_line.run(["param", "describe", "/Srobot1/navigator", *names]) == 0
    assert capfd.readouterr().out == (
        "Parameter name: costmap.inflation_radius\n"
        "  Type: double\n"
        "  Description: around obstacles in the costmaps [m]\n"
        "  Constraints:\n"
        "    Min value: 0.01\n"
        "    Max value: 50.0\n"
        "Parameter name: traffic.lost_ticks\n"
        "  Type: integer\n"
        "  Description: ticks without a beacon after which a robot is silent: dead, mute or gone\n"
        "  Constraints:\n"
        "    Read only: true\n"
        "    Min value: 1\n"
        "    Max value: 10000\n"
    )
    assert command_line.run(["param", "describe", "/sim/world", "speed"]) == 0
    assert "Description: times real time; 0: as fast" in capfd.readouterr().out


def test_a_robot_pauses_where_it_was_sent_until_its_next_goal_begins(swarm):
    pose = stamped(place(swarm))
    kind, name = action.NavigateToPose, "navigate_to_pose"
    assert run(swarm, kind, name, kind.Goal(pose=pose)).status == SUCCEEDED
    said = []
    subscription = swarm.node.create_subscription(RobotStatus, "/Srobot1/status", said.append, 10)
    swarm.spin_until(lambda: said)
    start = tick_of(said[-1].stamp) + 200
    goal = kind.Goal(pose=pose, behavior_tree=start_text(start))
    client, _ = begin(swarm, kind, name, goal)
    swarm.spin_until(lambda: tick_of(said[-1].stamp) > start, 60.0)
    client.destroy()
    swarm.node.destroy_subscription(subscription)
    states = [each.state for each in said]
    assert "pausing" in states
    assert states[-1] != "pausing"


def test_goals_are_taken_in_the_frames_of_the_robot_only(swarm):
    goal = action.NavigateToPose.Goal()
    goal.pose.pose.orientation.w = 1.0
    client = ActionClient(swarm.node, action.NavigateToPose, "/Srobot1/navigate_to_pose")
    swarm.spin_until(client.server_is_ready, START_LIMIT)
    taken = {}
    for frame in ("base_link", "Srobot1/base_scan", "Srobot2/base_link", "wheel_left_link", "base"):
        goal.pose.header.frame_id = frame
        taken[frame] = swarm.result_of(client.send_goal_async(goal)).accepted
    client.destroy()
    assert [frame for frame, accepted in taken.items() if accepted] == [
        "base_link", "Srobot1/base_scan",
    ]  # fmt: skip


def test_a_map_may_have_any_name(load_map, tmp_path):
    file = tmp_path / "a#b;c?d%20e.yaml"
    (tmp_path / "free.pgm").write_bytes(b"P5 40 40 255\n" + bytes([254]) * 1600)
    text = "image: free.pgm\nresolution: 0.5\norigin: [-10.0, -10.0, 0.0]\nnegate: 0\n"
    file.write_text(text + "occupied_thresh: 0.65\nfree_thresh: 0.25\n")
    for url in (str(file), file.as_uri()):
        assert load_map(url, "Srobot2") == srv.LoadMap.Response.RESULT_SUCCESS


def test_a_speed_limit_on_nav2s_topic_is_kept(swarm):
    odometry = []
    heard = swarm.node.create_subscription(Odometry, "/Srobot1/odom", odometry.append, 10)
    limits = swarm.node.create_publisher(SpeedLimit, "/Srobot1/speed_limit", 10)
    swarm.spin_until(lambda: limits.get_subscription_count() > 0)
    swarm.spin(1.0)  # the robot has to find the publisher as well
    limits.publish(SpeedLimit(percentage=True, speed_limit=50.0))
    # Where it stands depends on how long it was steered by hand.
    target = max(FREE_PLACES, key=place(swarm).distance)
    goal = action.NavigateToPose.Goal(pose=pose_stamped(target, 0))
    answer = run(swarm, action.NavigateToPose, "navigate_to_pose", goal)
    assert (answer.status, answer.result.error_msg) == (SUCCEEDED, "")
    fastest = max(message.twist.twist.linear.x for message in odometry)
    assert 0.12 < fastest < 0.13 * 1.05
    limits.publish(SpeedLimit())
    swarm.node.destroy_subscription(heard)
    swarm.node.destroy_publisher(limits)
