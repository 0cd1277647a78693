"""Says whether the ROS graph has changed, so that a process asks the graph then, not by the clock.

A question to the graph costs the more the more robots there are: rmw goes through all endpoints
that it knows. rclpy has no way to wait for a change; rcl has a guard condition for it.
https://docs.ros.org/en/jazzy/p/rcl: `rcl_node_get_graph_guard_condition`
"""

from __future__ import annotations

from rclpy.context import Context
from rclpy.node import Node

from swarm_common.middleware import rclpy_compat
from swarm_common.middleware.rcl_take import libraries


class GraphWatch:
    """Watches the graph of a context, of which all nodes see the same changes.

    A context has one at most, as whoever asks takes the change.
    """

    def __init__(self, context: Context) -> None:
        """Watch from now on."""
        rcl, _ = libraries()
        self._condition = rcl.rcl_node_get_graph_guard_condition
        self._add = rcl.rcl_wait_set_add_guard_condition
        self._set = rclpy_compat.wait_set(context, guards=1)

    def has_changed(self, node: Node) -> bool:
        """Whether nodes, topics or services have come or gone since the last question.

        Args:
            node: Any node of the context.
        """
        self._set.clear_entities()
        self._add(self._set.pointer, self._condition(node.handle.pointer), None)
        self._set.wait(0)
        return bool(self._set.is_ready("guard_condition", 0))
