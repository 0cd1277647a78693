"""Simulated time of a navigator's node, from the ticks that it sees anyway.

A node with `use_sim_time` subscribes to /clock. That is one more wake-up per message and process,
for a time that the stamp of each tick tells, too.
"""

from __future__ import annotations

from rclpy.node import Node
from rclpy.parameter import Parameter
from rosgraph_msgs.msg import Clock

from swarm_common.middleware.rclpy_compat import time_source_without_topic
from swarm_common.middleware.ros_io import time_msg

USE_SIM_TIME = "use_sim_time"


class TickClock:
    """Sets the clock of a node that was created without simulated time."""

    def __init__(self, node: Node) -> None:
        self._source = time_source_without_topic(node)
        node.set_parameters([Parameter(USE_SIM_TIME, value=True)])

    def set(self, tick: int) -> None:
        """It is this tick now."""
        if self._source.ros_time_is_active:
            self._source.clock_callback(Clock(clock=time_msg(tick)))
