"""The world for those who look at it: geometry once, poses of all robots every tick if wanted."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from geometry_msgs.msg import Point
from rclpy.node import Node
from rclpy.serialization import serialize_message
from tf2_msgs.msg import TFMessage
from visualization_msgs.msg import Marker, MarkerArray

from swarm_common.files.layout_io import LAYOUT_FILE, TrackLayout, read_layout
from swarm_common.middleware import ros_io
from swarm_common.middleware.cdr import TransformsWriter
from swarm_common.model.records import FloatArray, Pose
from swarm_common.model.zones import keepout_area, speed_area, triangles
from swarm_describe.worlds.scene import Scene
from swarm_recording.run_trace import TOPICS, RunTrace
from swarm_sim.ros.viewing.markers import body_markers, marker_of, set_scale
from swarm_sim.world.world import World

WALKER = (0.84, 0.37, 0.00, 1.0)  # colour
WALKER_HEIGHT = 1.7  # [m]
BASE = "base_footprint"
STATION, CIRCUIT = (0.18, 0.55, 0.34, 0.9), (0.90, 0.60, 0.00, 0.9)  # colours
KEEPOUT, SLOW = (0.84, 0.37, 0.30, 0.5), (0.94, 0.89, 0.26, 0.5)
LAYOUT, LAYOUT_SIZE = (0.35, 0.45, 0.75, 0.9), (0.03, 0.12)  # colour; [m] of edges and nodes
ZONE_HEIGHT = 0.01  # [m]
MOVER_TICKS = 5  # between two moments for which the trace keeps people and objects
GRAIN = 1024.0  # parts of a metre and a radian in the trace: short numbers pack well
STATION_SIZE = (0.5, 0.02)  # [m] diameter and height of the disc


class ScenePublisher:
    """The topics `/sim/scene`, `/sim/tf` and `/sim/movers`."""

    def __init__(
        self, node: Node, scene: Scene, world: World, trace: RunTrace | None = None
    ) -> None:
        """Create the topics, and publish what never moves.

        Args:
            trace: Keeps the same for replays; None if nobody wants that.
        """
        self._trace = trace
        self._world = world
        self.renew(world.names)
        make = node.create_publisher
        self._scene = make(MarkerArray, "/sim/scene", ros_io.LATCHED)
        self._tf = make(TFMessage, "/sim/tf", ros_io.TRANSFORMS)
        self._movers = make(MarkerArray, "/sim/movers", ros_io.RELIABLE)
        markers = MarkerArray(markers=scene_markers(scene))
        self._scene.publish(markers)
        if trace is not None:
            trace.write(TOPICS["/sim/scene"], 0, serialize_message(markers))
        self._movers_seen = Movers(world)
        self._tf_readers = self._mover_readers = 0
        self._kept = -1  # tick

    def renew(self, present: Sequence[str]) -> None:
        """Show these robots from now on."""
        self._rows = [self._world.names.index(name) for name in present]
        self._writer = TransformsWriter("map", [f"{name}/{BASE}" for name in present])
        self._is_stale = True

    def poll_viewers(self, tick: int) -> None:
        """See who listens; they get what is new to them, also while the world is paused."""
        before = self._tf_readers, self._mover_readers
        self._tf_readers = self._tf.get_subscription_count()
        self._mover_readers = self._movers.get_subscription_count()
        has_newcomers = self._tf_readers > before[0] or self._mover_readers > before[1]
        if has_newcomers or self._is_stale:
            self._is_stale = False
            self.publish(tick)

    def publish(self, tick: int) -> None:
        """Publish the poses of all robots to whoever has subscribed."""
        poses = self._world.poses[self._rows]
        if self._tf_readers:
            self._tf.publish(self._writer.encode(tick, poses))
        keeps_movers = self._trace is not None and tick % MOVER_TICKS == 0
        if self._mover_readers or keeps_movers:
            markers = self._movers_seen.markers(tick)
            if markers and self._mover_readers:
                self._movers.publish(MarkerArray(markers=markers))
            if markers and self._trace is not None and keeps_movers:
                data = serialize_message(MarkerArray(markers=markers))
                self._trace.write(TOPICS["/sim/movers"], tick, data)
        if self._trace is not None and tick > self._kept:
            self._kept = tick
            rounded = np.round(GRAIN * poses) / GRAIN
            self._trace.write(TOPICS["/sim/tf"], tick, self._writer.encode(tick, rounded))


def scene_markers(scene: Scene) -> list[Marker]:
    """Return the markers of all that never moves: bodies, stations, circuits, layout, zones."""
    markers: list[Marker] = []
    for body in (*scene.fixed, *scene.decor):
        markers += body_markers(body, "body", len(markers))
    for number, (name, pose) in enumerate(scene.sites.stations.items()):
        markers += _station_markers(name, pose, number)
    markers += [
        _line(name, points, number)
        for number, (name, points) in enumerate(scene.sites.circuits.items())
    ]
    if (path := scene.directory / LAYOUT_FILE).is_file():
        markers += _layout_markers(read_layout(path)[0])
    zones = scene.sites.zones
    areas = (("keepout", KEEPOUT, keepout_area), ("speed_limit", SLOW, speed_area))
    for space, color, area_of in areas:
        if zones and (points := triangles(area_of(zones))):
            marker = marker_of(space, 0, Marker.TRIANGLE_LIST, color, 0)
            marker.pose = ros_io.pose_msg(Pose(0.0, 0.0, 0.0))
            set_scale(marker, 1.0, 1.0, 1.0)
            marker.points = [Point(x=x, y=y, z=ZONE_HEIGHT) for x, y in points]
            markers.append(marker)
    return markers


def _station_markers(name: str, pose: Pose, number: int) -> list[Marker]:
    disc = marker_of("station", number, Marker.CYLINDER, STATION, 0)
    disc.pose = ros_io.pose_msg(pose)
    disc.pose.position.z = 0.5 * STATION_SIZE[1]
    disc.text = name
    set_scale(disc, STATION_SIZE[0], STATION_SIZE[0], STATION_SIZE[1])
    label = marker_of("station_name", number, Marker.TEXT_VIEW_FACING, (0.1, 0.1, 0.1, 1.0), 0)
    label.pose = ros_io.pose_msg(pose)
    label.pose.position.z = 0.5
    label.scale.z = 0.3
    label.text = name
    return [disc, label]


def _line(name: str, points_map: Sequence[Sequence[float]], number: int) -> Marker:
    marker = marker_of("circuit", number, Marker.LINE_STRIP, CIRCUIT, 0)
    marker.pose = ros_io.pose_msg(Pose(0.0, 0.0, 0.0))
    marker.scale.x = 0.05
    marker.text = name
    closed = [*points_map, points_map[0]]
    marker.points = [Point(x=float(x), y=float(y), z=0.02) for x, y in closed]
    return marker


def _layout_markers(layout: TrackLayout) -> list[Marker]:
    """Return the edges and the nodes of a fleet control's layout."""
    places = {
        node.node_id: Point(x=node.node_position.x, y=node.node_position.y, z=ZONE_HEIGHT)
        for node in layout.nodes
        if node.map_id == layout.map_id
    }
    ends = [(edge.start_node_id, edge.end_node_id) for edge in layout.edges]
    lines = [places[end] for pair in ends if places.keys() >= {*pair} for end in pair]
    markers = []
    kinds = ("layout_edges", Marker.LINE_LIST, lines), ("layout_nodes", Marker.POINTS, places)
    for size, (space, kind, points) in zip(LAYOUT_SIZE, kinds, strict=True):
        marker = marker_of(space, 0, kind, LAYOUT, 0)
        marker.pose = ros_io.pose_msg(Pose(0.0, 0.0, 0.0))
        set_scale(marker, size, size, 0.0)
        marker.points = list(points.values() if isinstance(points, dict) else points)
        if marker.points:
            markers.append(marker)
    return markers


class Movers:
    """Markers of walkers, vehicles and things; markers of things that are gone are deleted once."""

    def __init__(self, world: World) -> None:
        self._world = world
        self._ids: dict[tuple[str, int], int] = {}  # by name of the body and number of its part
        self._shown: set[int] = set()

    def markers(self, tick: int) -> list[Marker]:
        """Return the markers that turn what is shown into what there is."""
        markers = [walker_marker(i, disc, tick) for i, disc in enumerate(self._world.walkers())]
        objects = [m for body in self._world.objects() for m in body_markers(body, "object", 0)]
        for marker in objects:
            marker.id = self._ids.setdefault((marker.text, marker.id), len(self._ids))
            marker.header.stamp = ros_io.time_msg(tick)
        shown = {marker.id for marker in objects}
        gone = sorted(self._shown - shown)
        self._shown = shown
        header = ros_io.header(tick, "map")
        deleted = [Marker(header=header, ns="object", id=n, action=Marker.DELETE) for n in gone]
        return [*markers, *objects, *deleted]


def walker_marker(number: int, disc: FloatArray, tick: int) -> Marker:
    """Return the marker of a walker."""
    marker = marker_of("walker", number, Marker.CYLINDER, WALKER, tick)
    marker.pose = ros_io.pose_msg(Pose(float(disc[0]), float(disc[1]), 0.0))
    marker.pose.position.z = 0.5 * WALKER_HEIGHT
    set_scale(marker, 2.0 * disc[2], 2.0 * disc[2], WALKER_HEIGHT)
    return marker
