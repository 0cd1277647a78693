"""Interface of the navigator's node that actions and services need."""

from __future__ import annotations

from typing import Protocol

from geometry_msgs.msg import PoseStamped
from rclpy.node import Node

from swarm_common.middleware.rejections import Rejections
from swarm_common.model.grid import Grid
from swarm_common.model.records import Pose
from swarm_nav.core.lifecycle import Lifecycle
from swarm_nav.ros.nav2.map_bounds import MapBounds


class ServedNode(Protocol):
    """The face of `swarm_nav.ros.node.NavigatorNode` towards what it serves."""

    node: Node
    lifecycle: Lifecycle
    rejections: Rejections
    tick: int
    map_bounds: MapBounds  # of the map at hand

    def change_lifecycle(self, command: str) -> bool:
        """Carry out a command of the lifecycle manager.

        Args:
            command: Name of a transition in `core.lifecycle`, like `startup` or `pause`.

        Returns:
            False if it makes no sense now.
        """

    def to_map(self, stamped: PoseStamped) -> Pose:
        """Return a pose of one of the robot's frames in map.

        Args:
            stamped: In map, odom, or a link fixed to the robot; an empty frame means map.

        Raises:
            ValueError: If the frame is unknown, a number makes no sense, or the pose is far off the
                map.
        """

    def receive_map(self, grid: Grid) -> None:
        """Navigate on another map from now on.

        Args:
            grid: Upright, in the same map frame.

        Raises:
            MapError: If the map has too many cells when it is divided into finer ones.
        """
