"""Bodies as markers for those who look at the world."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from geometry_msgs.msg import Point
from std_msgs.msg import ColorRGBA
from visualization_msgs.msg import Marker

from swarm_common.middleware import ros_io
from swarm_common.model.shapes import (
    Box,
    Color,
    Cylinder,
    Hull,
    Mesh,
    MeshFile,
    Shape,
    Sphere,
    Transform,
    quaternion_of,
)
from swarm_describe.worlds.scene import Body

WALL, BLOCK = (0.80, 0.81, 0.83, 1.0), (0.72, 0.60, 0.44, 1.0)  # where no colour is given
WALL_HEIGHT = 1.5  # [m] from which a body counts as a wall


def body_markers(body: Body, space: str, first: int) -> Iterator[Marker]:
    """Yield markers, named like the body; one without visuals looks like what it collides with.

    Args:
        first: Id of the first marker; the others follow.
    """
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
    """Return the marker of a shape; None for the ground.

    Args:
        rgba: From 0 to 1; None for the usual colour, or that of the mesh file.
    """
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
    marker = marker_of("", 0, kind, rgba or (WALL if is_wall else BLOCK), 0)
    set_scale(marker, *size)
    _place(marker, map_from_shape)
    if isinstance(shape, Hull | Mesh):
        corners = [Point(x=float(x), y=float(y), z=float(z)) for x, y, z in shape.vertices]
        marker.points = [corners[index] for face in shape.faces for index in face]
    elif isinstance(shape, MeshFile):
        marker.mesh_resource = f"file://{shape.path}"
        marker.mesh_use_embedded_materials = rgba is None
    return marker


def marker_of(space: str, number: int, kind: int, rgba: Sequence[float], tick: int) -> Marker:
    """Return a marker in the map frame that has no place and size yet."""
    marker = Marker(header=ros_io.header(tick, "map"), ns=space, id=number, type=kind)
    marker.action = Marker.ADD
    marker.color = ColorRGBA(**dict(zip("rgba", map(float, rgba), strict=True)))
    return marker


def set_scale(marker: Marker, x: float, y: float, z: float) -> None:
    """Set a marker's size [m]."""
    marker.scale.x, marker.scale.y, marker.scale.z = float(x), float(y), float(z)


def _place(marker: Marker, map_from_shape: Transform) -> None:
    place, turn = marker.pose.position, marker.pose.orientation
    place.x, place.y, place.z = (float(value) for value in map_from_shape[:3, 3])
    turn.x, turn.y, turn.z, turn.w = quaternion_of(map_from_shape[:3, :3])
