"""Topics that the view reads, and which of them a robot's layers need."""

from __future__ import annotations

from enum import Enum

from swarm_common.middleware.topic_table import WORLD_TOPICS, Topic, robot_topic
from swarm_common.model.robot_names import natural

SCENE, TF, MOVERS, MAP = "/sim/scene", "/sim/tf", "/sim/movers", "/map"
VERDICT = "/sim/verdict"
STATUS, DESCRIPTION = "status", "robot_description"
STATUS_TYPE = "swarm_interfaces/msg/RobotStatus"
_WORLD = {topic.name: topic for topic in WORLD_TOPICS}


class Layer(Enum):
    """Layer that can be shown of one robot; the value is the topic in its namespace."""

    SCAN = "scan"
    PLAN = "plan"
    LOCAL_PLAN = "local_plan"
    MOTION = "beacon"
    LOCAL_COSTMAP = "local_costmap/costmap"
    GLOBAL_COSTMAP = "global_costmap/costmap"
    FOOTPRINT = "local_costmap/published_footprint"
    PARTICLES = "particle_cloud"


LABELS = {
    Layer.SCAN: "LiDAR scan",
    Layer.PLAN: "Global plan",
    Layer.LOCAL_PLAN: "Local plan",
    Layer.MOTION: "Committed motion",
    Layer.LOCAL_COSTMAP: "Local costmap",
    Layer.GLOBAL_COSTMAP: "Global costmap",
    Layer.FOOTPRINT: "Footprint",
    Layer.PARTICLES: "Particles",
}
SHOWN_AT_FIRST = frozenset({Layer.SCAN, Layer.PLAN, Layer.LOCAL_PLAN, Layer.MOTION})


def type_of(topic: str) -> str:
    """Return the message type of a topic that the view reads."""
    return _entry(topic).type


def is_latched(topic: str) -> bool:
    """Whether a latecomer gets the last message."""
    return _entry(topic).is_latched


def _entry(topic: str) -> Topic:
    return _WORLD[topic] if topic in _WORLD else robot_topic(*split(topic))


def split(topic: str) -> tuple[str, str]:
    """Return (robot, topic in its namespace)."""
    _, robot, rest = topic.split("/", 2)
    return robot, rest


def robots_in(types: dict[str, str]) -> list[str]:
    """Return the robots among the topics, sorted, agv2 before agv10."""
    names = {
        split(topic)[0]
        for topic, kind in types.items()
        if kind == STATUS_TYPE and topic.endswith(f"/{STATUS}") and topic.count("/") == 2
    }
    return sorted(names, key=natural)


def of_layer(robot: str, layer: Layer) -> str:
    """Return the topic of a robot's layer."""
    return f"/{robot}/{layer.value}"
