"""A costmap on Nav2's topics: whole and in parts, as occupancy and with its raw costs.

Nav2 sends either whole costmaps (`always_send_full_costmap`, which its bring-up sets) or what has
changed. Here a subscriber of whole costmaps gets them, and a subscriber of changes gets changes.
"""

from __future__ import annotations

import array
from collections.abc import Callable

import numpy as np
from map_msgs.msg import OccupancyGridUpdate
from nav2_msgs.msg import Costmap as CostmapMsg
from nav2_msgs.msg import CostmapUpdate
from nav_msgs.msg import OccupancyGrid
from rclpy.node import Node
from rclpy.publisher import Publisher

from swarm_common.middleware import ros_io
from swarm_common.model.records import Pose
from swarm_nav.behaviour.costmap import Window, changed_window
from swarm_nav.interfaces import Costmap
from swarm_nav.ros.nav2.demand import OnDemand

OTHERS = (  # beside the costmap as an occupancy grid
    (CostmapMsg, "costmap_raw"),
    (OccupancyGridUpdate, "costmap_updates"),
    (CostmapUpdate, "costmap_raw_updates"),
)


class CostmapTopics:
    """The topics of one costmap; nothing is composed for nobody.

    Attributes:
        is_wanted: Whether somebody listened to one of them at the last look.
    """

    def __init__(
        self,
        node: Node,
        space: str,
        period: int,
        compose: Callable[[], Costmap],
        on_demand: OnDemand,
    ) -> None:
        """Create the topics.

        Args:
            space: `global_costmap` or `local_costmap`.
            period: Ticks between two costmaps.
            compose: Returns the costmap as it is now.
            on_demand: Receives the topics that few listen to.
        """
        self.is_wanted = False
        self._node = node
        self._space = space
        self._period = period
        self._compose = compose
        self._whole = node.create_publisher(OccupancyGrid, f"{space}/costmap", ros_io.LATCHED)
        self._others: dict[str, Publisher] = {}
        self._wanted: set[str] = set()
        self._last: Costmap | None = None  # that changes are told against
        names = [f"{space}/{name}" for _, name in OTHERS]
        on_demand.offer_topics(names, self._create_others)

    def _create_others(self) -> None:
        for kind, name in OTHERS:
            topic = f"{self._space}/{name}"
            self._others[name] = self._node.create_publisher(kind, topic, ros_io.LATCHED)

    def poll_subscribers(self) -> None:
        """Find out what is listened to."""
        topics = {"costmap": self._whole, **self._others}
        self._wanted = {name for name, topic in topics.items() if topic.get_subscription_count()}
        self.is_wanted = bool(self._wanted)
        if self._wanted.isdisjoint(CHANGES):
            self._last = None

    def publish(self, tick: int) -> None:
        """Publish what is listened to, if the costmap is due at this tick."""
        if not self.is_wanted or tick % self._period:
            return
        costmap = self._compose()
        if "costmap" in self._wanted:
            self._whole.publish(occupancy_msg(costmap, tick))
        if "costmap_raw" in self._wanted:
            self._others["costmap_raw"].publish(costmap_msg(costmap, tick))
        if not self._wanted.isdisjoint(CHANGES):
            self._publish_changes(costmap, tick)

    def _publish_changes(self, costmap: Costmap, tick: int) -> None:
        last, self._last = self._last, costmap
        window = None if last is None else changed_window(last, costmap)
        if window is None:
            return
        for name, encode in CHANGES.items():
            if name in self._wanted:
                self._others[name].publish(encode(costmap, window, tick))


def occupancy_msg(costmap: Costmap, tick: int) -> OccupancyGrid:
    """Return nav_msgs/OccupancyGrid; Nav2's costs are scaled to 0 to 100 and -1 for unknown."""
    cells = ros_io.OCCUPANCY_FROM_COST[costmap.cells]
    origin = (costmap.origin_x, costmap.origin_y)
    return ros_io.occupancy_msg(cells, costmap.resolution, origin, tick, "map")


def costmap_msg(costmap: Costmap, tick: int) -> CostmapMsg:
    """Return nav2_msgs/Costmap."""
    message = CostmapMsg(header=ros_io.header(tick, "map"))
    info = message.metadata
    info.update_time = message.header.stamp
    info.layer = "master"
    info.resolution = float(costmap.resolution)
    info.size_y, info.size_x = costmap.cells.shape
    info.origin = ros_io.pose_msg(Pose(costmap.origin_x, costmap.origin_y, 0.0))
    message.data = array.array("B", costmap.cells.tobytes())
    return message


def occupancy_update(costmap: Costmap, window: Window, tick: int) -> OccupancyGridUpdate:
    """Return a part of a costmap as map_msgs/OccupancyGridUpdate."""
    cells = ros_io.OCCUPANCY_FROM_COST[costmap.cells[window.rows, window.columns]]
    message = OccupancyGridUpdate(header=ros_io.header(tick, "map"))
    message.x, message.y = window.columns.start, window.rows.start
    message.height, message.width = cells.shape
    message.data = array.array("b", cells.tobytes())
    return message


def costmap_update(costmap: Costmap, window: Window, tick: int) -> CostmapUpdate:
    """Return a part of a costmap as nav2_msgs/CostmapUpdate."""
    costs = np.ascontiguousarray(costmap.cells[window.rows, window.columns])
    message = CostmapUpdate(header=ros_io.header(tick, "map"))
    message.x, message.y = window.columns.start, window.rows.start
    message.size_y, message.size_x = costs.shape
    message.data = array.array("B", costs.tobytes())
    return message


CHANGES = {"costmap_updates": occupancy_update, "costmap_raw_updates": costmap_update}
