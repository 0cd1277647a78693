"""Who and what moves beside the robots, as markers that keep their ids."""

from __future__ import annotations

from visualization_msgs.msg import Marker

from swarm_common.middleware import ros_io
from swarm_common.model.records import FloatArray, Pose
from swarm_sim.ros.viewing.markers import body_markers, marker_of, set_scale
from swarm_sim.world.world import World

WALKER = (0.84, 0.37, 0.00, 1.0)  # colour
WALKER_HEIGHT = 1.7  # [m]


class Movers:
    """Markers of walkers, vehicles and things; markers of things that are gone are deleted once."""

    def __init__(self, world: World) -> None:
        self._world = world
        self._ids: dict[tuple[str, int], int] = {}  # by name of the body and number of its part
        self._shown: set[int] = set()

    def markers(self, tick: int) -> list[Marker]:
        """Return what changes what is shown to what there is."""
        markers = [walker_marker(i, disc, tick) for i, disc in enumerate(self._world.walkers())]
        objects = [m for body in self._world.objects() for m in body_markers(body, "object", 0)]
        for marker in objects:
            marker.id = self._ids.setdefault((marker.text, marker.id), len(self._ids))
            marker.header.stamp = ros_io.time_msg(tick)
        shown = {marker.id for marker in objects}
        gone = sorted(self._shown - shown)
        self._shown = shown
        return [*markers, *objects, *(_deleted(number, tick) for number in gone)]


def walker_marker(number: int, disc: FloatArray, tick: int) -> Marker:
    """Return the marker of a walker.

    Args:
        disc: x, y, radius (3,) [m] in the map frame.
    """
    marker = marker_of("walker", number, Marker.CYLINDER, WALKER, tick)
    marker.pose = ros_io.pose_msg(Pose(float(disc[0]), float(disc[1]), 0.0))
    marker.pose.position.z = 0.5 * WALKER_HEIGHT
    set_scale(marker, 2.0 * disc[2], 2.0 * disc[2], WALKER_HEIGHT)
    return marker


def _deleted(number: int, tick: int) -> Marker:
    return Marker(header=ros_io.header(tick, "map"), ns="object", id=number, action=Marker.DELETE)
