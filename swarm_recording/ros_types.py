"""Message classes and qualities of service by the names in the table of topics."""

from __future__ import annotations

import importlib
from typing import Any

from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy

from swarm_common.middleware.topic_table import Topic
from swarm_common.model.errors import ConfigError


def message_class(name: str) -> Any:
    """Return the class of a message type like ``nav_msgs/msg/Path``.

    Raises:
        ConfigError: If it is not installed.
    """
    try:
        package, kind, short = name.split("/")
        return getattr(importlib.import_module(f"{package}.{kind}"), short)
    except (ImportError, AttributeError, ValueError):
        raise ConfigError(f"the type {name or 'without a name'} is not installed") from None


def quality(topic: Topic, depth: int) -> QoSProfile:
    """Return the quality of a topic of the table or of a bag."""
    reliable, effort = ReliabilityPolicy.RELIABLE, ReliabilityPolicy.BEST_EFFORT
    latched, volatile = DurabilityPolicy.TRANSIENT_LOCAL, DurabilityPolicy.VOLATILE
    return QoSProfile(
        depth=depth,
        reliability=reliable if topic.is_reliable else effort,
        durability=latched if topic.is_latched else volatile,
    )
