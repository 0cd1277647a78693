"""The bare ROS node of a navigator."""

from __future__ import annotations

from rclpy.context import Context
from rclpy.node import Node
from rclpy.parameter import Parameter

from swarm_nav.ros.settings import NODE, NodeSettings

# Parameter changes are announced inside the robot's namespace, as everything of a robot.
REMAPPING = ("--ros-args", "-r", "/parameter_events:=parameter_events")


def create_node(settings: NodeSettings, context: Context) -> Node:
    """Return the node `/SrobotK/navigator`, with only what every robot needs."""
    return Node(
        NODE,
        namespace=settings.name,
        context=context,
        cli_args=list(REMAPPING),
        use_global_arguments=False,
        enable_rosout=False,
        start_parameter_services=False,
        parameter_overrides=[Parameter("start_type_description_service", value=False)],
    )
