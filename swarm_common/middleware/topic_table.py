"""Every topic of a swarm that people look at or record: name, type, quality. Knows no ROS.

A list for recorder, RViz and Foxglove. Who publishes does not read it, and names the topic again:
swarm_sim/ros/ (mostly links.py), and answer.py, views.py and node.py of swarm_nav/ros/.
`test_the_table_of_topics_is_that_of_the_graph` (tests/graph/test_recording.py) compares it with the
graph of a running swarm. Not in it: `mission`, on which an operator announces goals to a robot.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace


@dataclass(frozen=True, slots=True)
class Topic:
    """A topic as its publisher offers it."""

    name: str  # relative to a robot's namespace unless it starts with a slash
    type: str  # like ``nav_msgs/msg/Path``
    is_reliable: bool = True  # else best effort
    is_latched: bool = False  # transient local: latecomers get the last message
    # offset [bytes] of sec and nanosec in a serialized message; None without a stamp
    stamp_at: int | None = 4
    many: bool = False  # whether several nodes publish on it
    depth: int = 10  # of the publisher's history
    # whether every message counts, so that a lower rate would lose something
    is_event: bool = False
    is_optional: bool = False  # whether only some robots have it
    comes_first: bool = False  # whether the world publishes it before time begins


WORLD_TOPICS = (
    Topic("/clock", "rosgraph_msgs/msg/Clock", comes_first=True),
    Topic("/map", "nav_msgs/msg/OccupancyGrid", is_latched=True, depth=1, comes_first=True),
    Topic("/sim/verdict", "swarm_interfaces/msg/Verdict", is_event=True),
    Topic(
        "/sim/scene",
        "visualization_msgs/msg/MarkerArray",
        is_latched=True,
        stamp_at=None,
        depth=1,
        comes_first=True,
    ),
    Topic("/sim/tf", "tf2_msgs/msg/TFMessage", stamp_at=8, depth=100, comes_first=True),
    Topic("/sim/movers", "visualization_msgs/msg/MarkerArray", stamp_at=8),
)
ROBOT_TOPICS = (
    *(
        Topic(name, kind, is_latched=True, stamp_at=None, depth=1, comes_first=True)
        for name, kind in (
            ("robot_description", "std_msgs/msg/String"),
            ("tf_static", "tf2_msgs/msg/TFMessage"),
        )
    ),
    Topic("tf", "tf2_msgs/msg/TFMessage", stamp_at=8, many=True, depth=100),
    Topic("joint_states", "sensor_msgs/msg/JointState"),
    Topic("odom", "nav_msgs/msg/Odometry"),
    Topic("scan", "sensor_msgs/msg/LaserScan", depth=5),
    Topic("imu", "sensor_msgs/msg/Imu"),
    Topic("battery_state", "sensor_msgs/msg/BatteryState", is_optional=True),
    Topic("ground_truth", "nav_msgs/msg/Odometry"),
    Topic("neighbors", "swarm_interfaces/msg/NeighborArray"),
    Topic("beacon", "swarm_interfaces/msg/Beacon"),
    Topic("cmd_vel", "geometry_msgs/msg/TwistStamped"),
    Topic("status", "swarm_interfaces/msg/RobotStatus", is_event=True),
    Topic("plan", "nav_msgs/msg/Path", depth=1),
    Topic("local_plan", "nav_msgs/msg/Path", depth=1),
    Topic("global_costmap/costmap", "nav_msgs/msg/OccupancyGrid", is_latched=True, depth=1),
    Topic("local_costmap/costmap", "nav_msgs/msg/OccupancyGrid", is_latched=True, depth=1),
    Topic("local_costmap/published_footprint", "geometry_msgs/msg/PolygonStamped", depth=1),
    Topic("amcl_pose", "geometry_msgs/msg/PoseWithCovarianceStamped", is_latched=True, depth=1),
    Topic("particle_cloud", "nav2_msgs/msg/ParticleCloud", is_reliable=False, depth=5),
)
# The same costmaps in Nav2's other forms: raw costs, and what has changed. Not recorded.
COSTMAP_TOPICS = tuple(
    Topic(f"{space}_costmap/{name}", kind, is_latched=True, depth=1)
    for space in ("global", "local")
    for name, kind in (
        ("costmap_raw", "nav2_msgs/msg/Costmap"),
        ("costmap_updates", "map_msgs/msg/OccupancyGridUpdate"),
        ("costmap_raw_updates", "nav2_msgs/msg/CostmapUpdate"),
    )
)
# What a robot listens to, for the tools of RViz and Foxglove.
ORDERS = (
    Topic("initialpose", "geometry_msgs/msg/PoseWithCovarianceStamped"),
    Topic("goal_pose", "geometry_msgs/msg/PoseStamped"),
    Topic("speed_limit", "nav2_msgs/msg/SpeedLimit"),
)


def robot_topic(robot: str, name: str) -> Topic:
    """Return a topic of a robot by its relative name, with its full name.

    Raises:
        KeyError: If there is none of that name.
    """
    by_name = {topic.name: topic for topic in (*ROBOT_TOPICS, *ORDERS)}
    return replace(by_name[name], name=f"/{robot}/{name}")


def all_topics(robots: Iterable[str]) -> list[Topic]:
    """Return every topic of a swarm with its full name: the world's, then robot by robot."""
    return [
        *WORLD_TOPICS,
        *(
            replace(topic, name=f"/{robot}/{topic.name}")
            for robot in robots
            for topic in ROBOT_TOPICS
        ),
    ]
