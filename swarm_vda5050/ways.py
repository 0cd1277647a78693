"""Where a robot may drive on an edge: along its trajectory, or in its corridor."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np
from scipy.interpolate import BSpline

from swarm_common.model.records import FloatArray, wrap_angle
from swarm_vda5050.messages import Edge, NodePosition, Trajectory

if TYPE_CHECKING:
    import shapely

SPACING = 0.05  # [m] between the points of a way
FINE = 50  # samples per control point
MOST_POINTS = 1000  # control points of a trajectory
LONGEST = 10_000.0  # [m] along them
HEAVIEST = 1e6  # weight of one
FARTHEST = 1e6  # [m] of anything from the origin of the map
NARROW = 0.3  # [m] of a corridor in which nothing is planned: the robot follows its middle line
ALONG = 0.35  # [rad] from the direction of a way that still is along it
TURNS = {  # [rad] by which an edge may turn off the one before, least and most, by its direction
    "left": (-ALONG, math.pi),
    "straight": (-math.pi / 4, math.pi / 4),
    "right": (-math.pi, ALONG),
}
TURNING_ROOM = 0.35  # [m] around a node, besides the body, that belongs to a corridor


def problem_of(trajectory: Trajectory) -> str:
    """Return what is wrong with a trajectory; empty if nothing is."""
    count, degree, knots = len(trajectory.control_points), trajectory.degree, _knots(trajectory)
    if not 1 <= degree < count <= MOST_POINTS:
        return f"degree {degree} and {count} control points, of at most {MOST_POINTS}"
    if len(knots) != count + degree + 1:
        return (
            f"{len(knots)} knots; {count} control points of degree {degree} need"
            f" {count + degree + 1}"
        )
    if (np.diff(knots) < 0.0).any() or not knots[degree] < knots[count]:
        return "the knots do not ascend"
    if not all(1.0 / HEAVIEST <= point.weight <= HEAVIEST for point in trajectory.control_points):
        return f"a weight that is not from {1.0 / HEAVIEST:g} to {HEAVIEST:g}"
    corners = np.array([(point.x, point.y) for point in trajectory.control_points])
    if not (np.abs(corners) <= FARTHEST).all() or not np.abs(knots).max() <= FARTHEST:
        return f"a number beyond {FARTHEST:g}"
    length = float(np.hypot(*np.diff(corners, axis=0).T).sum())
    if length > LONGEST:
        return f"{length:.0f} m of way; at most {LONGEST:.0f} m are taken"
    return ""


def line_of(edge: Edge, start: NodePosition, end: NodePosition) -> FloatArray:
    """Return the line (n, 2) [m] of an edge in map: its trajectory, or straight between its nodes.

    The trajectory has to be a valid one.
    """
    if edge.trajectory is None:
        line = np.array([(start.x, start.y), (end.x, end.y)])
    else:
        line = _curve(edge.trajectory)
    steps = np.hypot(*np.diff(line, axis=0).T)
    at = np.concatenate((np.zeros(1), np.cumsum(steps)))
    where = np.linspace(0.0, at[-1], max(2, round(at[-1] / SPACING) + 1))
    return np.column_stack([np.interp(where, at, line[:, axis]) for axis in (0, 1)])


def keeps_heading(edge: Edge) -> bool:
    """Whether the robot must have the heading of an edge when it enters it, and keep it there."""
    is_fixed = edge.rotation_allowed is False or edge.reach_orientation_before_entering
    return is_fixed or edge.orientation is not None


def _off_way(edge: Edge, line: FloatArray) -> list[float]:
    """Return the angles [rad] between the orientation of an edge and the directions of its line."""
    if edge.orientation is None:
        return [0.0]
    if edge.orientation_type != "GLOBAL":
        return [abs(wrap_angle(edge.orientation))]
    steps = np.diff(line, axis=0)
    ways = np.arctan2(steps[:, 1], steps[:, 0]).tolist()
    return [abs(wrap_angle(edge.orientation - way)) for way in ways]


def is_backwards(edge: Edge, line: FloatArray) -> bool:
    """Whether the orientation of an edge is against its direction, all along its line.

    Args:
        line: (n, 2) [m] in map, of the edge.
    """
    return min(_off_way(edge, line)) >= math.pi - ALONG


def heading_problem(edge: Edge, line: FloatArray, *, may_back: bool) -> str:
    """Return why a robot cannot have the orientation of an edge; empty if it can.

    Args:
        line: (n, 2) [m] in map, of the edge.
        may_back: Whether the robot drives backwards, too.
    """
    off = max(_off_way(edge, line))
    if off <= ALONG or (may_back and is_backwards(edge, line)):
        return ""
    ways = "forwards or backwards only" if may_back else "forwards only: it does not see behind"
    return (
        f"orientation is {edge.orientation:g} ({edge.orientation_type}), {off:.2f} rad off the way:"
        f" this robot drives {ways}"
    )


def direction_problem(edge: Edge, line: FloatArray, before: FloatArray | None) -> str:
    """Return why a robot without physical lines cannot keep the direction of an edge; empty if not.

    It follows the edge's own line, which has to turn off the one before as the direction says.

    Args:
        line: (n, 2) [m] in map, of the edge.
        before: Likewise of the edge before; None if the message has none.
    """
    if not edge.direction:
        return ""
    if edge.direction not in TURNS:
        return f"direction is '{edge.direction:.40}'; this robot knows {', '.join(TURNS)} only"
    if before is None:
        return ""
    (x, y), (last_x, last_y) = line[1] - line[0], before[-1] - before[-2]
    turn = wrap_angle(math.atan2(y, x) - math.atan2(last_y, last_x))
    least, most = TURNS[edge.direction]
    if least <= turn <= most:
        return ""
    return f"direction is '{edge.direction}', but the edge turns by {turn:.2f} rad"


def is_followed(edge: Edge) -> bool:
    """Whether the robot follows the line of an edge, in place of planning its way."""
    corridor = edge.corridor
    if keeps_heading(edge) or edge.direction:
        return True
    if corridor is None:
        return edge.trajectory is not None
    return corridor.left_width + corridor.right_width < NARROW


def needs_release(edge: Edge) -> bool:
    """Whether the robot follows the line of an edge until its corridor is granted."""
    corridor = edge.corridor
    return corridor is not None and corridor.release_required and not is_followed(edge)


def corridor_area(edge: Edge, line: FloatArray, radius: float) -> shapely.Geometry:
    """Return where the body of a robot may be on an edge with a corridor.

    Args:
        line: (n, 2) [m] in map, of the edge.
        radius: [m] of the body.
    """
    import shapely

    corridor = edge.corridor
    assert corridor is not None
    more = 0.0 if corridor.corridor_ref_point == "CONTOUR" else radius
    middle = shapely.LineString(line)
    sides = [
        middle.buffer(sign * (width + more), single_sided=True)
        for sign, width in ((1, corridor.left_width), (-1, corridor.right_width))
    ]
    ends = shapely.points(line[[0, -1]])
    return shapely.union_all([*sides, *shapely.buffer(ends, radius + TURNING_ROOM)])


def _knots(trajectory: Trajectory) -> FloatArray:
    if trajectory.knot_vector is not None:
        return np.array(trajectory.knot_vector, float)
    inner = np.linspace(0.0, 1.0, max(len(trajectory.control_points), 2))
    return np.array([0.0, *inner, 1.0])


def _curve(trajectory: Trajectory) -> FloatArray:
    """Return points (n, 2) of a NURBS: a B-spline in homogeneous coordinates."""
    points = np.array(
        [(p.x * p.weight, p.y * p.weight, p.weight) for p in trajectory.control_points]
    )
    knots, degree, count = _knots(trajectory), trajectory.degree, len(points)
    at = np.linspace(knots[degree], knots[count], FINE * count)
    at = np.union1d(at, knots[degree : count + 1])
    curve = BSpline(knots, points, degree)(at)
    return np.asarray(curve[:, :2] / curve[:, 2:])
