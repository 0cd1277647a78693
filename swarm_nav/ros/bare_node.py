"""The bare ROS node of a navigator, and its clock."""

from __future__ import annotations

from rclpy.context import Context
from rclpy.node import Node
from rclpy.parameter import Parameter
from rosgraph_msgs.msg import Clock

from swarm_common.middleware.rclpy_compat import time_source_without_topic
from swarm_common.middleware.ros_io import time_msg
from swarm_nav.ros.settings import NODE, USE_SIM_TIME, NodeSettings


def create_node(settings: NodeSettings, context: Context) -> Node:
    """Return the node `NAME/navigator`, with only what every robot needs.

    Args:
        settings: Name of the robot, which is the namespace.
    """
    return Node(
        NODE,
        namespace=settings.name,
        context=context,
        use_global_arguments=False,
        enable_rosout=False,
        start_parameter_services=False,
        parameter_overrides=[Parameter("start_type_description_service", value=False)],
    )


class TickClock:
    """Sets the clock of a node by the ticks that it sees anyway.

    A node with `use_sim_time` subscribes to /clock. That is one more wake-up per message and
    process, for a time that the stamp of each tick tells, too.
    """

    def __init__(self, node: Node) -> None:
        """Switch the node to simulated time, without a subscription to /clock."""
        self._source = time_source_without_topic(node)
        node.set_parameters([Parameter(USE_SIM_TIME, value=True)])

    def set(self, tick: int) -> None:
        """Set the clock of the node to a tick."""
        if self._source.ros_time_is_active:
            self._source.clock_callback(Clock(clock=time_msg(tick)))
