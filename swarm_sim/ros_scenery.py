"""The world for those who look at it: geometry once, poses of all robots every tick if wanted."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence

from geometry_msgs.msg import Point
from rclpy.node import Node
from std_msgs.msg import ColorRGBA
from tf2_msgs.msg import TFMessage
from visualization_msgs.msg import Marker, MarkerArray

from swarm_common import ros_io
from swarm_common.records import FloatArray, Pose
from swarm_common.shapes import (
    Box,
    Color,
    Cylinder,
    Hull,
    Mesh,
    MeshFile,
    Shape,
    Sphere,
    Transform,
)
from swarm_common.wire import TransformsWriter
from swarm_sim.scene import Body, Scene
from swarm_sim.world import World

BASE = "base_footprint"
COLORS = {  # of what the world file gives no colour
    "wall": (0.80, 0.81, 0.83, 1.0),
    "block": (0.72, 0.60, 0.44, 1.0),
    "station": (0.18, 0.55, 0.34, 0.9),
    "circuit": (0.90, 0.60, 0.00, 0.9),
    "walker": (0.84, 0.37, 0.00, 1.0),
}
WALL_HEIGHT = 1.5  # [m] from which a body counts as a wall
STATION_SIZE = (0.5, 0.02)  # [m] diameter and height of the disc


class Scenery:
    """The topics `/sim/scene`, `/sim/tf` and `/sim/movers`."""

    def __init__(self, node: Node, scene: Scene, world: World) -> None:
        """Create the topics and publish what never changes."""
        self._world = world
        self.renew(world.names)
        make = node.create_publisher
        self._scene = make(MarkerArray, "/sim/scene", ros_io.LATCHED)
        self._tf = make(TFMessage, "/sim/tf", ros_io.TRANSFORMS)
        self._movers = make(MarkerArray, "/sim/movers", ros_io.RELIABLE)
        self._scene.publish(MarkerArray(markers=scene_markers(scene)))
        self._tf_readers = self._mover_readers = 0

    def renew(self, present: Sequence[str]) -> None:
        """Show these robots from now on."""
        self._rows = [self._world.names.index(name) for name in present]
        self._writer = TransformsWriter("map", [f"{name}/{BASE}" for name in present])
        self._is_stale = True

    def look_for_viewers(self, tick: int) -> None:
        """See who listens; they get what is new to them, also while the world is paused."""
        before = self._tf_readers, self._mover_readers
        self._tf_readers = self._tf.get_subscription_count()
        self._mover_readers = self._movers.get_subscription_count()
        has_newcomers = self._tf_readers > before[0] or self._mover_readers > before[1]
        if has_newcomers or self._is_stale:
            self._is_stale = False
            self.publish(tick)

    def publish(self, tick: int) -> None:
        """Publish where everybody is, to whom it may concern."""
        if self._tf_readers:
            self._tf.publish(self._writer.encode(tick, self._world.poses[self._rows]))
        if self._mover_readers:
            markers = mover_markers(self._world, tick)
            if markers:
                self._movers.publish(MarkerArray(markers=markers))


def scene_markers(scene: Scene) -> list[Marker]:
    """Return the markers of what never moves: bodies, stations, circuits."""
    markers: list[Marker] = []
    for body in (*scene.fixed, *scene.decor):
        markers += _body_markers(body, "body", len(markers))
    for number, (name, pose) in enumerate(scene.sites.stations.items()):
        markers += _station_markers(name, pose, number)
    markers += [
        _line(name, points, number)
        for number, (name, points) in enumerate(scene.sites.circuits.items())
    ]
    return markers


def mover_markers(world: World, tick: int) -> list[Marker]:
    """Return the markers of who and what moves beside the robots."""
    markers = [walker_marker(i, disc, tick) for i, disc in enumerate(world.walkers())]
    for body in world.objects():
        markers += _body_markers(body, "object", len(markers))
    for marker in markers:
        marker.header.stamp = ros_io.time_msg(tick)
    return markers


def walker_marker(number: int, disc: FloatArray, tick: int) -> Marker:
    """Return the marker of a walker at (x, y) with a radius."""
    height = 1.7
    marker = _marker("walker", number, Marker.CYLINDER, COLORS["walker"], tick)
    marker.pose = ros_io.pose_msg(Pose(float(disc[0]), float(disc[1]), 0.0))
    marker.pose.position.z = 0.5 * height
    _scale(marker, 2.0 * disc[2], 2.0 * disc[2], height)
    return marker


def _body_markers(body: Body, space: str, first: int) -> Iterable[Marker]:
    """Return what a body looks like; one that does not say so looks like what it collides with."""
    shapes: list[tuple[Shape | MeshFile, Transform, Color | None]] = [
        (item.shape, item.body_from_visual, item.color) for item in body.visuals
    ] or [(part.shape, part.body_from_part, None) for part in body.parts]
    for shape, body_from_shape, color in shapes:
        marker = shape_marker(shape, body.world_from_body @ body_from_shape, color)
        if marker is not None:
            marker.ns, marker.id, marker.text = space, first, body.name
            first += 1
            yield marker


def shape_marker(
    shape: Shape | MeshFile, map_from_shape: Transform, rgba: Color | None = None
) -> Marker | None:
    """Return the marker of a shape; None for the ground."""
    if isinstance(shape, Box):
        kind, size = Marker.CUBE, shape.size
    elif isinstance(shape, Cylinder):
        kind, size = Marker.CYLINDER, (2.0 * shape.radius, 2.0 * shape.radius, shape.length)
    elif isinstance(shape, Sphere):
        kind, size = Marker.SPHERE, (2.0 * shape.radius,) * 3
    elif isinstance(shape, Hull | Mesh):
        kind, size = Marker.TRIANGLE_LIST, (1.0, 1.0, 1.0)
    elif isinstance(shape, MeshFile):
        kind, size = Marker.MESH_RESOURCE, shape.scale
    else:
        return None
    is_wall = isinstance(shape, Box) and size[2] >= WALL_HEIGHT
    marker = _marker("", 0, kind, rgba or COLORS["wall" if is_wall else "block"], 0)
    _scale(marker, *size)
    _place(marker, map_from_shape)
    if isinstance(shape, Hull | Mesh):
        corners = [Point(x=float(x), y=float(y), z=float(z)) for x, y, z in shape.vertices]
        marker.points = [corners[index] for face in shape.faces for index in face]
    elif isinstance(shape, MeshFile):
        marker.mesh_resource = f"file://{shape.path}"
        marker.mesh_use_embedded_materials = rgba is None
    return marker


def _station_markers(name: str, pose: Pose, number: int) -> list[Marker]:
    disc = _marker("station", number, Marker.CYLINDER, COLORS["station"], 0)
    disc.pose = ros_io.pose_msg(pose)
    disc.pose.position.z = 0.5 * STATION_SIZE[1]
    disc.text = name
    _scale(disc, STATION_SIZE[0], STATION_SIZE[0], STATION_SIZE[1])
    label = _marker("station_name", number, Marker.TEXT_VIEW_FACING, (0.1, 0.1, 0.1, 1.0), 0)
    label.pose = ros_io.pose_msg(pose)
    label.pose.position.z = 0.5
    label.scale.z = 0.3
    label.text = name
    return [disc, label]


def _line(name: str, points_map: Sequence[Sequence[float]], number: int) -> Marker:
    marker = _marker("circuit", number, Marker.LINE_STRIP, COLORS["circuit"], 0)
    marker.pose = ros_io.pose_msg(Pose(0.0, 0.0, 0.0))
    marker.scale.x = 0.05
    marker.text = name
    closed = [*points_map, points_map[0]]
    marker.points = [Point(x=float(x), y=float(y), z=0.02) for x, y in closed]
    return marker


def _marker(space: str, number: int, kind: int, rgba: Sequence[float], tick: int) -> Marker:
    marker = Marker(header=ros_io.header(tick, "map"), ns=space, id=number, type=kind)
    marker.action = Marker.ADD
    marker.color = ColorRGBA(**dict(zip("rgba", map(float, rgba), strict=True)))
    return marker


def _scale(marker: Marker, x: float, y: float, z: float) -> None:
    marker.scale.x, marker.scale.y, marker.scale.z = float(x), float(y), float(z)


def _place(marker: Marker, map_from_shape: Transform) -> None:
    place, turn = marker.pose.position, marker.pose.orientation
    place.x, place.y, place.z = (float(value) for value in map_from_shape[:3, 3])
    turn.x, turn.y, turn.z, turn.w = quaternion(map_from_shape[:3, :3])


def quaternion(rotation: FloatArray) -> tuple[float, float, float, float]:
    """Return (x, y, z, w) of a rotation matrix."""
    r = rotation
    w, x, y, z = (
        0.5 * math.sqrt(max(0.0, 1.0 + a * r[0, 0] + b * r[1, 1] + c * r[2, 2]))
        for a, b, c in ((1, 1, 1), (1, -1, -1), (-1, 1, -1), (-1, -1, 1))
    )
    x = math.copysign(x, r[2, 1] - r[1, 2])
    y = math.copysign(y, r[0, 2] - r[2, 0])
    z = math.copysign(z, r[1, 0] - r[0, 1])
    norm = math.hypot(w, x, y, z)
    return x / norm, y / norm, z / norm, w / norm
