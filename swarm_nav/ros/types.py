"""Loading of the C side of all message types before the navigators are forked.

A type is loaded at its first use. All types of a navigator take a tenth of a second of CPU time per
process. Loaded once in the parent, they cost the children nothing.
"""

from __future__ import annotations

from collections.abc import Iterable
from types import ModuleType
from typing import Any

import rclpy.node
import rclpy.parameter_service
import rclpy.time_source
from rclpy.type_support import check_for_type_support

from swarm_nav.ros import node
from swarm_nav.ros.nav2 import goals as ros_goals
from swarm_nav.ros.nav2 import lifecycle_services
from swarm_nav.ros.nav2 import plans as ros_plans
from swarm_nav.ros.nav2 import services as ros_services
from swarm_nav.ros.nav2 import tasks as ros_tasks
from swarm_nav.ros.nav2 import views as ros_views

USERS: tuple[ModuleType, ...] = (
    rclpy.node,
    rclpy.parameter_service,
    rclpy.time_source.rosgraph_msgs.msg,
    node,
    lifecycle_services,
    ros_goals,
    ros_plans,
    ros_services,
    ros_tasks,
    ros_views,
)


def load_type_supports() -> None:
    """Load every message, service and action type that a module of a navigator names."""
    for kind in interface_types(USERS):
        check_for_type_support(kind)


def interface_types(modules: Iterable[ModuleType]) -> list[Any]:
    """Return the message, service and action types among the names in modules, each once.

    Args:
        modules: Modules that import what they use by name.
    """
    return list(
        {
            value: None
            for module in modules
            for value in vars(module).values()
            if isinstance(value, type) and hasattr(type(value), "__import_type_support__")
        }
    )
