"""Three navigators and their world on a real graph, as users and other tools see them."""

import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest
from nav2_msgs.srv import ManageLifecycleNodes
from nav_msgs.msg import OccupancyGrid, Odometry
from rcl_interfaces.msg import Parameter, ParameterValue
from rcl_interfaces.srv import GetParameters, SetParametersAtomically
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from sensor_msgs.msg import LaserScan
from swarm_interfaces.msg import RobotStatus, Verdict

from swarm_common.middleware.ros_io import tick_of
from swarm_nav.core.config import NavConfig, parameter_values
from tests.graph.conftest import START_LIMIT

SCRIPT = Path(__file__).with_name("plain_navigator.py")
DOUBLE, BOOL = 3, 1  # rcl_interfaces/ParameterType
LATCHED = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
BEST_EFFORT = QoSProfile(depth=5, reliability=ReliabilityPolicy.BEST_EFFORT)

TOPICS = {
    "odom": "nav_msgs/msg/Odometry",
    "scan": "sensor_msgs/msg/LaserScan",
    "neighbors": "swarm_interfaces/msg/NeighborArray",
    "beacon": "swarm_interfaces/msg/Beacon",
    "cmd_vel": "geometry_msgs/msg/TwistStamped",
    "imu": "sensor_msgs/msg/Imu",
    "ground_truth": "nav_msgs/msg/Odometry",
    "joint_states": "sensor_msgs/msg/JointState",
    "tf": "tf2_msgs/msg/TFMessage",
    "tf_static": "tf2_msgs/msg/TFMessage",
    "robot_description": "std_msgs/msg/String",
    "status": "swarm_interfaces/msg/RobotStatus",
    "mission": "swarm_interfaces/msg/Mission",
    "plan": "nav_msgs/msg/Path",
    "local_plan": "nav_msgs/msg/Path",
    "global_costmap/costmap": "nav_msgs/msg/OccupancyGrid",
    "local_costmap/costmap": "nav_msgs/msg/OccupancyGrid",
    **{
        f"{space}_costmap/{name}": kind
        for space in ("global", "local")
        for name, kind in (
            ("costmap_raw", "nav2_msgs/msg/Costmap"),
            ("costmap_updates", "map_msgs/msg/OccupancyGridUpdate"),
            ("costmap_raw_updates", "nav2_msgs/msg/CostmapUpdate"),
        )
    },
    "local_costmap/published_footprint": "geometry_msgs/msg/PolygonStamped",
    "amcl_pose": "geometry_msgs/msg/PoseWithCovarianceStamped",
    "particle_cloud": "nav2_msgs/msg/ParticleCloud",
    "initialpose": "geometry_msgs/msg/PoseWithCovarianceStamped",
    "goal_pose": "geometry_msgs/msg/PoseStamped",
}
LIFECYCLE_NODES = (
    "amcl", "behavior_server", "bt_navigator", "controller_server", "map_server", "planner_server"
)  # fmt: skip
SERVICES = {
    **{f"{node}/get_state": "lifecycle_msgs/srv/GetState" for node in LIFECYCLE_NODES},
    "lifecycle_manager_navigation/manage_nodes": "nav2_msgs/srv/ManageLifecycleNodes",
    "lifecycle_manager_navigation/is_active": "std_srvs/srv/Trigger",
    "map_server/load_map": "nav2_msgs/srv/LoadMap",
    "global_costmap/clear_entirely_global_costmap": "nav2_msgs/srv/ClearEntireCostmap",
    "local_costmap/clear_entirely_local_costmap": "nav2_msgs/srv/ClearEntireCostmap",
    "global_costmap/get_costmap": "nav2_msgs/srv/GetCostmap",
    "local_costmap/get_costmap": "nav2_msgs/srv/GetCostmap",
    "navigator/set_parameters": "rcl_interfaces/srv/SetParameters",
    "navigator/get_parameters": "rcl_interfaces/srv/GetParameters",
}
ACTIONS = {
    "navigate_to_pose": "NavigateToPose",
    "navigate_through_poses": "NavigateThroughPoses",
    "follow_waypoints": "FollowWaypoints",
    "follow_path": "FollowPath",
    "compute_path_to_pose": "ComputePathToPose",
    "compute_path_through_poses": "ComputePathThroughPoses",
    "spin": "Spin",
    "backup": "BackUp",
    "drive_on_heading": "DriveOnHeading",
    "wait": "Wait",
}
SHARED_TOPICS = {"/clock", "/map", "/parameter_events", "/rosout"}
SHARED_SPACES = ("/sim/", "/tester/")


ROBOTS = 3


def collect(swarm, kind, topic, quality=10, count=1):
    """Return messages of a topic."""
    messages = []
    subscription = swarm.node.create_subscription(kind, topic, messages.append, quality)
    try:
        swarm.spin_until(lambda: len(messages) >= count)
    finally:
        swarm.node.destroy_subscription(subscription)
    return messages


def test_every_namespace_holds_everything_of_its_robot_and_nothing_lies_outside(swarm):
    expected_topics = {f"/{n}/{topic}": kind for n in swarm.names for topic, kind in TOPICS.items()}
    expected_services = {
        f"/{n}/{name}": kind for n in swarm.names for name, kind in SERVICES.items()
    }
    for name in swarm.names:
        for action, kind in ACTIONS.items():
            space = f"/{name}/{action}/_action"
            expected_topics[f"{space}/feedback"] = f"nav2_msgs/action/{kind}_FeedbackMessage"
            expected_topics[f"{space}/status"] = "action_msgs/msg/GoalStatusArray"
            expected_services[f"{space}/send_goal"] = f"nav2_msgs/action/{kind}_SendGoal"
            expected_services[f"{space}/get_result"] = f"nav2_msgs/action/{kind}_GetResult"
            expected_services[f"{space}/cancel_goal"] = "action_msgs/srv/CancelGoal"

    def listed(pairs):
        return {name: kinds[0] for name, kinds in pairs}

    def is_complete():
        topics = listed(swarm.node.get_topic_names_and_types())
        services = listed(swarm.node.get_service_names_and_types())
        return (
            expected_topics.items() <= topics.items()
            and expected_services.items() <= services.items()
            and nodes() >= expected_nodes
        )

    def nodes():
        return {f"{space}/{name}" for name, space in swarm.node.get_node_names_and_namespaces()}

    faces = ["navigator", *LIFECYCLE_NODES]
    expected_nodes = {f"/{name}/{face}" for name in swarm.names for face in faces}
    expected_nodes |= {"/sim/world", "//tester"}
    swarm.spin_until(is_complete, START_LIMIT)
    mine = tuple(f"/{name}/" for name in swarm.names)
    topics = set(listed(swarm.node.get_topic_names_and_types()))
    outside = {name for name in topics if not name.startswith((*mine, *SHARED_SPACES))}
    assert outside <= SHARED_TOPICS
    services = set(listed(swarm.node.get_service_names_and_types()))
    assert [name for name in services if not name.startswith((*mine, *SHARED_SPACES))] == []
    assert nodes() == expected_nodes


def test_only_parameter_events_of_a_navigator_lie_outside_its_namespace(swarm):
    for name in swarm.names:
        topics = swarm.node.get_publisher_names_and_types_by_node("navigator", f"/{name}")
        outside = [topic for topic, _ in topics if not topic.startswith(f"/{name}/")]
        assert outside == ["/parameter_events"]  # as of every node


def test_scans_come_in_the_namespace_of_the_robot_and_its_navigator_listens(swarm):
    """The original published /robotN/scan while the namespaces were SrobotN: it drove blind."""

    def listeners(topic):
        known = swarm.node.get_subscriptions_info_by_topic(topic)
        return {(info.node_namespace, info.node_name) for info in known}

    for name in swarm.names:
        scan = collect(swarm, LaserScan, f"/{name}/scan", BEST_EFFORT)[0]
        assert scan.header.frame_id == "base_scan"
        assert len(scan.ranges) == 360
        swarm.spin_until(lambda: (f"/{name}", "navigator") in listeners(f"/{name}/scan"))  # noqa: B023


def test_odometry_map_costmap_and_verdict_are_there(swarm):
    """A tick that a robot is slow to answer is published again: as it was, with its stamp."""
    ticks = {}

    def take(message):
        assert ticks.setdefault(tick_of(message.header.stamp), message) == message

    subscription = swarm.node.create_subscription(Odometry, "/Srobot1/odom", take, 100)
    try:
        swarm.spin_until(lambda: len(ticks) >= 3)
    finally:
        swarm.node.destroy_subscription(subscription)
    first = min(ticks)
    assert list(ticks) == list(range(first, first + len(ticks)))
    header = ticks[first].header
    assert (header.frame_id, ticks[first].child_frame_id) == ("odom", "base_footprint")
    grid = collect(swarm, OccupancyGrid, "/map", LATCHED)[0]
    assert grid.info.resolution == pytest.approx(0.05)
    costmap = collect(swarm, OccupancyGrid, "/Srobot2/local_costmap/costmap", LATCHED)[0]
    assert costmap.info.width * costmap.info.resolution == pytest.approx(3.0, abs=0.2)
    assert set(costmap.data) <= set(range(-1, 101))
    verdict = collect(swarm, Verdict, "/sim/verdict")[0]
    assert verdict.robots == 3
    assert verdict.collisions_robot_robot == verdict.collisions_robot_world == 0


def set_parameter(swarm, name, value):
    kind = BOOL if isinstance(value, bool) else DOUBLE
    field = "bool_value" if isinstance(value, bool) else "double_value"
    parameter = Parameter(name=name, value=ParameterValue(type=kind, **{field: value}))
    request = SetParametersAtomically.Request(parameters=[parameter])
    service = "/Srobot3/navigator/set_parameters_atomically"
    return swarm.call(SetParametersAtomically, service, request).result


def get_parameter(swarm, name):
    request = GetParameters.Request(names=[name])
    return swarm.call(GetParameters, "/Srobot3/navigator/get_parameters", request).values[0]


def test_parameters_of_the_brain_can_be_read_and_set(swarm):
    assert get_parameter(swarm, "max_vel_x").double_value == pytest.approx(0.26)
    assert get_parameter(swarm, "use_sim_time").bool_value
    assert get_parameter(swarm, "robot_id").integer_value == 3
    assert set_parameter(swarm, "max_vel_x", 0.15).successful
    assert get_parameter(swarm, "max_vel_x").double_value == 0.15
    names = list(parameter_values(NavConfig()))
    request = GetParameters.Request(names=names)
    answer = swarm.call(GetParameters, "/Srobot3/navigator/get_parameters", request)
    assert [name for name, value in zip(names, answer.values, strict=True) if value.type == 0] == []


@pytest.mark.parametrize(
    ("name", "value", "reason"),
    [
        ("max_vel_x", -1.0, "max_vel_x is -1.0; it must be more than 0"),
        ("max_vel_x", 3.0, "max_vel_x is 3.0; a turtlebot3_waffle reaches 0.26"),
        ("goal_checker.xy_goal_tolerance", 0.0, "goal_checker.xy_goal_tolerance is 0.0"),
        ("autostart", False, "read-only"),
        ("no_such_parameter", 1.0, "undeclared"),
    ],
)
def test_impossible_parameters_are_refused_with_the_reason(swarm, name, value, reason):
    result = set_parameter(swarm, name, value)
    assert not result.successful
    assert reason in result.reason


@pytest.mark.timeout(300)
def test_a_plain_nav2_script_drives_two_robots_at_once(swarm):
    environment = os.environ | {"ROS_DOMAIN_ID": str(swarm.domain)}
    poses = swarm.world.named("spawn")[0]["poses"]
    scripts = [
        subprocess.Popen(
            (sys.executable, str(SCRIPT), name, *(str(number) for number in pose)),
            env=environment,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
        )
        for name, pose in zip(swarm.names[:2], poses, strict=False)
    ]
    try:
        outputs = [script.communicate(timeout=250)[0].decode() for script in scripts]
    finally:
        for script in scripts:
            script.kill()
    assert [script.returncode for script in scripts] == [0, 0], "\n".join(outputs)


def manage(swarm, name, command):
    service = f"/{name}/lifecycle_manager_navigation/manage_nodes"
    request = ManageLifecycleNodes.Request(command=command)
    return swarm.call(ManageLifecycleNodes, service, request).success


def test_lifecycle_pause_and_resume(swarm):
    def state():
        return collect(swarm, RobotStatus, "/Srobot2/status")[0].state

    assert manage(swarm, "Srobot2", ManageLifecycleNodes.Request.PAUSE)
    swarm.spin_until(lambda: state() == "inactive")
    assert manage(swarm, "Srobot2", ManageLifecycleNodes.Request.RESUME)
    swarm.spin_until(lambda: state() == "idle")
    assert manage(swarm, "Srobot2", ManageLifecycleNodes.Request.SHUTDOWN)
    assert not manage(swarm, "Srobot2", ManageLifecycleNodes.Request.RESUME)
    assert manage(swarm, "Srobot2", ManageLifecycleNodes.Request.STARTUP)
    swarm.spin_until(lambda: state() == "idle")


def late_ticks(swarm):
    return swarm.world.named("progress")[-1].get("late_ticks", 0)


def test_killing_one_navigator_leaves_the_others_running(swarm):
    """Last in this file: Srobot3 is gone afterwards."""
    os.kill(swarm.pid_of("Srobot3"), signal.SIGKILL)
    swarm.host.wait_for("died")
    died = swarm.host.named("died")
    assert [(event["robot"], event["returncode"]) for event in died] == [("Srobot3", -9)]
    os.write(swarm.world.control_fd, b'{"cmd": "dead", "robot": "Srobot3"}\n')
    before, late = swarm.sim_time(), late_ticks(swarm)
    swarm.spin_until(lambda: swarm.sim_time() > before + 4.0, START_LIMIT)
    assert late_ticks(swarm) == late  # nobody waited for it up to the wall limit
    assert swarm.world.named("progress")[-1]["answering"] == 2
    for name in swarm.names[:2]:
        collect(swarm, RobotStatus, f"/{name}/status")
