"""Content of an RViz window: one robot; the whole swarm; the whole swarm with its models."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

from swarm_common.middleware.topic_table import WORLD_TOPICS, Topic, robot_topic

Display = dict[str, Any]
FIXED_FRAME = "map"
PLUGINS = "rviz_default_plugins"
COLORS = (  # as in the reports
    "0; 114; 178",
    "230; 159; 0",
    "0; 158; 115",
    "213; 94; 0",
    "86; 180; 233",
    "204; 121; 167",
)


def robot_config(robot: str, index: int = 0) -> dict[str, Any]:
    """Return the configuration for one robot: everything that Nav2's own view shows."""
    color = COLORS[index % len(COLORS)]

    def topic(name: str) -> Topic:
        return robot_topic(robot, name)

    displays = [
        _grid(),
        _map("Map", _world_topic("/map"), "map", 1.0),
        _map("Global costmap", topic("global_costmap/costmap"), "costmap", 0.3, is_enabled=False),
        _map("Local costmap", topic("local_costmap/costmap"), "costmap", 0.6),
        _robot_model(topic("robot_description")),
        _frames(),
        _scan(topic("scan")),
        _path("Global plan", topic("plan"), color, 0.04),
        _path("Local plan", topic("local_plan"), "240; 228; 66", 0.05),
        _polygon("Footprint", topic("local_costmap/published_footprint"), color),
        _display(
            "ParticleCloud",
            "Particles",
            plugin="nav2_rviz_plugins",
            values={"Topic": _source(topic("particle_cloud")), "Color": "0; 158; 115"},
        ),
        _display(
            "PoseWithCovariance",
            "Estimated pose",
            values={"Topic": _source(topic("amcl_pose")), "Color": color},
        ),
    ]
    return _config(displays, _tools([robot]))


def swarm_config(robots: Sequence[str]) -> dict[str, Any]:
    """Return the configuration for all robots, with the displays in the frame `map`."""
    frames = _display("TF", "Robots (true poses)", values={"Show Names": True, "Marker Scale": 1.0})
    return _of_all(robots, frames, lambda _: [])


def merged_config(robots: Sequence[str]) -> dict[str, Any]:
    """Return the configuration for all robots with their models, in one tree of frames.

    The frames are those of `frame_relay`: with the robot's name in front.
    """
    return _of_all(robots, _frames(), lambda robot: [
        _robot_model(robot_topic(robot, "robot_description"), prefix=robot)
    ])  # fmt: skip


def _of_all(
    robots: Sequence[str], frames: Display, models: Callable[[str], list[Display]]
) -> dict[str, Any]:
    displays = [
        _grid(),
        _map("Map", _world_topic("/map"), "map", 1.0),
        _markers("Scene", _world_topic("/sim/scene")),
        _markers("People and vehicles", _world_topic("/sim/movers")),
        frames,
    ]
    for index, robot in enumerate(robots):
        color = COLORS[index % len(COLORS)]
        displays.append(_group(robot, [*models(robot), *_ways(robot, color)]))
    return _config(displays, _tools(robots[:1]))


@dataclass(frozen=True, slots=True)
class NamedTopic:
    """A topic that a configuration names: by which display or tool, and with which quality."""

    shown_by: str
    name: str
    reliability: str
    durability: str


def named_topics(config: Any, shown_by: str = "") -> list[NamedTopic]:
    """Return every topic that a configuration names."""
    if isinstance(config, list):
        return [found for item in config for found in named_topics(item, shown_by)]
    if not isinstance(config, dict):
        return []
    if "Reliability Policy" in config:
        quality = (config["Reliability Policy"], config["Durability Policy"])
        return [NamedTopic(shown_by, config["Value"], *quality)]
    kind = str(config.get("Class") or shown_by).split("/")[-1]
    return [found for item in config.values() for found in named_topics(item, kind)]


# Parts


def _world_topic(name: str) -> Topic:
    return next(topic for topic in WORLD_TOPICS if topic.name == name)


def _source(topic: Topic) -> dict[str, Any]:
    """Return how to subscribe, with the quality that the publisher offers."""
    return {
        "Value": topic.name,
        "Depth": 5,
        "History Policy": "Keep Last",
        "Reliability Policy": "Reliable" if topic.is_reliable else "Best Effort",
        "Durability Policy": "Transient Local" if topic.is_latched else "Volatile",
    }


def _display(
    kind: str, name: str, values: Display, *, plugin: str = PLUGINS, is_enabled: bool = True
) -> Display:
    return {
        "Class": f"{plugin}/{kind}",
        "Name": name,
        "Enabled": is_enabled,
        "Value": is_enabled,
        **values,
    }


def _group(name: str, displays: Sequence[Display]) -> Display:
    return {
        "Class": "rviz_common/Group",
        "Name": name,
        "Enabled": True,
        "Displays": list(displays),
    }


def _ways(robot: str, color: str) -> list[Display]:
    """Return where a robot is and what it plans, all of it in the frame `map`."""
    footprint = robot_topic(robot, "local_costmap/published_footprint")
    return [
        _polygon("Footprint", footprint, color),
        _path("Global plan", robot_topic(robot, "plan"), color, 0.03),
        _path("Local plan", robot_topic(robot, "local_plan"), color, 0.05),
    ]


def _frames() -> Display:
    values = {"Show Names": True, "Marker Scale": 0.5}
    return _display("TF", "Frames", is_enabled=False, values=values)


def _grid() -> Display:
    return _display("Grid", "Grid", values={"Cell Size": 1, "Plane Cell Count": 40, "Alpha": 0.3})


def _map(name: str, topic: Topic, scheme: str, alpha: float, *, is_enabled: bool = True) -> Display:
    return _display(
        "Map",
        name,
        is_enabled=is_enabled,
        values={
            "Topic": _source(topic),
            "Color Scheme": scheme,
            "Alpha": alpha,
            "Draw Behind": scheme == "map",
        },
    )


def _path(name: str, topic: Topic, color: str, width: float) -> Display:
    return _display(
        "Path",
        name,
        values={
            "Topic": _source(topic),
            "Color": color,
            "Line Style": "Billboards",
            "Line Width": width,
        },
    )


def _robot_model(topic: Topic, prefix: str = "") -> Display:
    return _display(
        "RobotModel",
        "Robot model",
        values={
            "Description Source": "Topic",
            "Description Topic": _source(topic),
            "TF Prefix": prefix,
            "Visual Enabled": True,
            "Collision Enabled": False,
        },
    )


def _scan(topic: Topic) -> Display:
    return _display(
        "LaserScan",
        "Scan",
        values={
            "Topic": _source(topic),
            "Style": "Flat Squares",
            "Size (m)": 0.03,
            "Color Transformer": "FlatColor",
            "Color": "213; 94; 0",
        },
    )


def _polygon(name: str, topic: Topic, color: str) -> Display:
    return _display("Polygon", name, values={"Topic": _source(topic), "Color": color})


def _markers(name: str, topic: Topic) -> Display:
    return _display("MarkerArray", name, values={"Topic": _source(topic)})


def _tools(robots: Sequence[str]) -> list[Display]:
    """Return the tools of a window; those that give orders talk to `robots`."""
    tools: list[Display] = [
        {"Class": f"{PLUGINS}/Interact", "Hide Inactive Objects": True},
        {"Class": f"{PLUGINS}/MoveCamera"},
        {"Class": f"{PLUGINS}/Select"},
        {"Class": f"{PLUGINS}/FocusCamera"},
        {"Class": f"{PLUGINS}/Measure", "Line color": "128; 128; 0"},
    ]
    for robot in robots:
        tools += [
            {
                "Class": f"{PLUGINS}/SetInitialPose",
                "Topic": _source(robot_topic(robot, "initialpose")),
                "Covariance x": 0.25,
                "Covariance y": 0.25,
                "Covariance yaw": 0.07,
            },
            {"Class": f"{PLUGINS}/SetGoal", "Topic": _source(robot_topic(robot, "goal_pose"))},
        ]
    return tools


def _config(displays: list[Display], tools: list[Display]) -> dict[str, Any]:
    """Return a whole configuration."""
    return {
        "Panels": [
            {"Class": "rviz_common/Displays", "Name": "Displays"},
            {"Class": "rviz_common/Tool Properties", "Name": "Tool Properties"},
            {"Class": "rviz_common/Views", "Name": "Views"},
            {"Class": "rviz_common/Time", "Name": "Time"},
        ],
        "Visualization Manager": {
            "Class": "",
            "Enabled": True,
            "Name": "root",
            "Global Options": {
                "Fixed Frame": FIXED_FRAME,
                "Background Color": "48; 48; 48",
                "Frame Rate": 30,
            },
            "Displays": displays,
            "Tools": tools,
            "Transformation": {"Current": {"Class": f"{PLUGINS}/TF"}},
            "Views": {
                "Current": {
                    "Class": f"{PLUGINS}/TopDownOrtho",
                    "Name": "Current View",
                    "Scale": 40,
                    "Target Frame": FIXED_FRAME,
                    "X": 0,
                    "Y": 0,
                }
            },
        },
        "Window Geometry": {"Width": 1280, "Height": 860},
    }
