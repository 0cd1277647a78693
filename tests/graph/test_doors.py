"""A running swarm that somebody lies to: nobody dies, nobody obeys, all of it is counted."""

import contextlib
import math
import struct
import time
from collections import Counter

import numpy as np
import pytest
from geometry_msgs.msg import PoseStamped, PoseWithCovarianceStamped, TwistStamped
from nav2_msgs.action import (
    BackUp,
    ComputePathThroughPoses,
    DriveOnHeading,
    FollowPath,
    NavigateToPose,
    Spin,
)
from nav2_msgs.msg import SpeedLimit
from nav_msgs.msg import OccupancyGrid, Odometry
from rcl_interfaces.srv import SetParameters
from rclpy.action import ActionClient
from rclpy.parameter import Parameter
from rclpy.qos import QoSProfile
from sensor_msgs.msg import LaserScan
from swarm_interfaces.msg import Beacon, Mission, NeighborArray

from swarm_common.files.map_io import load_map, map_path
from swarm_common.middleware import ros_io
from swarm_common.model.beacon import empty_beacons, serialize_beacon, serialize_neighbors
from swarm_common.model.grid import Grid

BURST = 1000
FORGED = empty_beacons(1)
FORGED["id"], FORGED["held_size"], FORGED["wanted_size"] = 2, 2_000_000_000, 2_000_000_000
LITTLE, BIG = b"\x00\x01\x00\x00", b"\x00\x00\x00\x00"
NO_MESSAGES = (
    LITTLE,  # four bytes
    BIG + bytes(100),
    LITTLE + b"\xff" * 2000,  # counts of 2^32 - 1, numbers that are NaN
    LITTLE + struct.pack("<iI", -(2**31), 0) + bytes(3000),
    LITTLE + struct.pack("<iI", 2**31 - 1, 0) + bytes(3000),
    serialize_beacon(FORGED[0]),
    serialize_neighbors(1, 0, FORGED),
)
TOPICS = {
    "odom": (Odometry, ros_io.RELIABLE),
    "scan": (LaserScan, ros_io.SENSOR),
    "neighbors": (NeighborArray, ros_io.RELIABLE),
    "cmd_vel": (TwistStamped, ros_io.RELIABLE),
    "beacon": (Beacon, ros_io.RELIABLE),
    "initialpose": (PoseWithCovarianceStamped, ros_io.RELIABLE),
    "goal_pose": (PoseStamped, ros_io.RELIABLE),
    "speed_limit": (SpeedLimit, ros_io.RELIABLE),
    "mission": (Mission, ros_io.LATCHED),
}


def counts(*processes):
    total: Counter[str] = Counter()
    for process in processes:
        for event in process.named("rejected"):
            total.update(event["counts"])
    return total


def check_that_all_go_on(swarm):
    before = swarm.sim_time()
    swarm.spin_until(lambda: swarm.sim_time() > before + 2.0)
    assert swarm.host.named("died") == []
    assert swarm.world.popen.poll() is None
    assert swarm.world.named("progress")[-1]["answering"] == len(swarm.names)


@pytest.mark.parametrize("name", TOPICS)
def test_no_message_on_a_topic_ends_anybody(swarm, name):
    """At b11a34e each of the tick's topics ended the world or the navigator."""
    kind, quality = TOPICS[name]
    publisher = swarm.node.create_publisher(kind, f"/Srobot1/{name}", quality)
    swarm.spin_until(lambda: publisher.get_subscription_count() > 0)
    for data in NO_MESSAGES * 2:
        with contextlib.suppress(RuntimeError):  # too long for a type of bounded size
            publisher.publish(data)
        swarm.spin(0.05)
    check_that_all_go_on(swarm)
    if name != "mission":  # of which nearly all bytes make sense
        swarm.spin_until(lambda: counts(swarm.host, swarm.world)[name] > 0)
    if name in ("cmd_vel", "beacon"):
        found = [(event["topic"], event["node"]) for event in swarm.world.named("foreign")]
        assert found.count((f"/Srobot1/{name}", "/tester")) == 1
    swarm.node.destroy_publisher(publisher)


def test_only_its_navigator_drives_a_robot(swarm):
    """At b11a34e a second publisher drove it at full speed without a word."""
    places: list[tuple[float, float]] = []

    def note(message):
        place = message.pose.pose.position
        places.append((place.x, place.y))

    listener = swarm.node.create_subscription(Odometry, "/Srobot2/ground_truth", note, 10)
    publisher = swarm.node.create_publisher(TwistStamped, "/Srobot2/cmd_vel", ros_io.RELIABLE)
    swarm.spin_until(lambda: publisher.get_subscription_count() > 0 and bool(places))
    ticks = swarm.node.create_subscription(
        Odometry, "/Srobot2/odom", lambda odom: publisher.publish(drive(odom)), 10
    )
    swarm.spin(4.0)
    assert max(math.dist(places[0], place) for place in places) < 0.01
    swarm.spin_until(
        lambda: (
            ("/Srobot2/cmd_vel", "/tester")
            in [(event["topic"], event["node"]) for event in swarm.world.named("foreign")]
        )
    )
    for subscription in (listener, ticks):
        swarm.node.destroy_subscription(subscription)
    swarm.node.destroy_publisher(publisher)


def drive(odom):
    command = TwistStamped(header=odom.header)
    command.twist.linear.x = 0.26
    return command


def wrong_maps():
    right = load_map(map_path("slim_blockage"))
    other = Grid(np.zeros((40, 40), np.int8), 0.05, -1.0, -1.0)
    messages = [ros_io.grid_msg(other, 0)]
    for resolution in (0.0, math.nan, -1.0):
        messages.append(ros_io.grid_msg(right, 0))
        messages[-1].info.resolution = resolution
    return messages


def test_only_the_map_of_its_parameters_is_taken(swarm):
    """One with a resolution of 0 or NaN ended every navigator at once."""
    publisher = swarm.node.create_publisher(OccupancyGrid, "/map", ros_io.LATCHED)
    swarm.spin_until(lambda: publisher.get_subscription_count() >= len(swarm.names))
    before = counts(swarm.host)["map"]
    for message in wrong_maps():
        publisher.publish(message)
        swarm.spin(0.5)
    check_that_all_go_on(swarm)
    swarm.spin_until(lambda: counts(swarm.host)["map"] == before + 4 * len(swarm.names))
    swarm.node.destroy_publisher(publisher)


def place(x, y=0.0):
    stamped = PoseStamped()
    stamped.header.frame_id = "map"
    stamped.pose.position.x, stamped.pose.position.y = x, y
    stamped.pose.orientation.w = 1.0
    return stamped


def test_absurd_goals_are_refused(swarm):
    """Each of them ended the navigator at b11a34e."""
    ahead, behind = DriveOnHeading.Goal(speed=0.1), BackUp.Goal(speed=0.1)
    ahead.target.x = behind.target.x = 1e9
    follow = FollowPath.Goal()
    follow.path.poses = [place(0.0), place(1e9)]
    goals = {
        "navigate_to_pose": (NavigateToPose, NavigateToPose.Goal(pose=place(1e308))),
        "drive_on_heading": (DriveOnHeading, ahead),
        "backup": (BackUp, behind),
        "follow_path": (FollowPath, follow),
        "spin": (Spin, Spin.Goal(target_yaw=1e30)),
    }
    for name, (kind, goal) in goals.items():
        client = ActionClient(swarm.node, kind, f"/Srobot1/{name}")
        swarm.spin_until(client.server_is_ready)
        assert not swarm.result_of(client.send_goal_async(goal)).accepted, name
        client.destroy()
    swarm.spin_until(lambda: set(counts(swarm.host)) >= set(goals))
    check_that_all_go_on(swarm)


def test_an_absurd_parameter_is_refused(swarm):
    request = SetParameters.Request()
    request.parameters = [Parameter("costmap.scan_timeout", value=1e308).to_parameter_msg()]
    response = swarm.call(SetParameters, "/Srobot1/navigator/set_parameters", request)
    assert not response.results[0].successful
    assert "costmap.scan_timeout" in response.results[0].reason
    check_that_all_go_on(swarm)


def test_every_goal_of_a_burst_is_answered(swarm):
    """At b11a34e 20 of 1,000 were: the service kept the newest ten requests between two looks."""
    deep = QoSProfile(depth=2 * BURST)
    client = ActionClient(
        swarm.node,
        NavigateToPose,
        "/Srobot1/navigate_to_pose",
        goal_service_qos_profile=deep,
        result_service_qos_profile=deep,
    )
    swarm.spin_until(client.server_is_ready)
    swarm.spin(0.5)
    goals = (place(0.0, 3.0), place(math.nan))
    asked = [
        client.send_goal_async(NavigateToPose.Goal(pose=goals[number % 2]))
        for number in range(BURST)
    ]
    start = time.monotonic()
    swarm.spin_until(lambda: all(future.done() for future in asked), 60.0)
    assert sum(future.result().accepted for future in asked) == BURST // 2
    assert time.monotonic() - start < 60.0
    check_that_all_go_on(swarm)
    client.destroy()


def test_many_plans_at_once_are_made_between_the_ticks_or_refused(swarm):
    """100 legs took six seconds, for which all robots waited; 600 leave each second a tick."""
    client = ActionClient(
        swarm.node, ComputePathThroughPoses, "/Srobot1/compute_path_through_poses"
    )
    swarm.spin_until(client.server_is_ready)
    ticks: set[tuple[int, int]] = set()

    def count_tick(odom):
        ticks.add((odom.header.stamp.sec, odom.header.stamp.nanosec))

    hearing = swarm.node.create_subscription(Odometry, "/Srobot2/odom", count_tick, 1000)
    swarm.spin_until(lambda: ticks)
    goals = [place(-2.0 + 0.007 * n, 3.0 * (-1) ** n + 0.003 * n) for n in range(600)]
    ticks.clear()  # from here on: the answer may be heard late, when all is planned
    handle = swarm.result_of(client.send_goal_async(ComputePathThroughPoses.Goal(goals=goals)))
    assert handle.accepted
    future = handle.get_result_async()
    swarm.spin_until(future.done, 120.0)
    result = future.result().result
    assert result.error_code == 0, result.error_msg
    assert len(result.path.poses) > len(goals)
    swarm.spin(0.5)  # what came meanwhile waits in the queue
    planning = result.planning_time.sec + 1e-9 * result.planning_time.nanosec
    assert len(ticks) >= planning - 1.0, "more than a second of planning without a tick"
    swarm.node.destroy_subscription(hearing)
    handle = swarm.result_of(
        client.send_goal_async(ComputePathThroughPoses.Goal(goals=[place(0.0)] * 5000))
    )
    refused = swarm.result_of(handle.get_result_async()).result
    assert refused.error_code != 0
    assert "5000 poses" in refused.error_msg
    client.destroy()
