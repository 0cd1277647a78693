"""Costs of other robots on the search lattice: to go around them, or as walls for a refuge."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from swarm_common.model.beacon import MODE_YIELD
from swarm_nav.planning import distance_kernels
from swarm_nav.planning.search_kernels import WALL
from swarm_nav.traffic.robot_state import RobotView

# Extra cost per metre of a place
PASSING = 0.5  # of a robot that drives or makes way, and where somebody has walked lately
STANDING = 3.0  # of a robot that stands, and of one that has to be pushed
BARRED = 50.0  # of a robot without a refuge, and of what only the LiDAR sees
TAKEN = 300.0  # of a robot that cannot be pushed
MOVING_SPEED = 0.05  # [m/s] above which a robot is on its way
PARKING_GAP = 0.1  # [m] beyond the reach between parked robots, and to one that cannot be pushed


def stamp(
    grid: NDArray[np.float32], robot: RobotView, points: object, radius: float, value: float
) -> None:
    """Raise the lattice cells within `radius` of the points to at least `value`.

    Args:
        grid: (h, w) lattice of costs; changed.
        points: (n, 2) [m] in map, or one point.
        radius: [m]
    """
    block = np.ascontiguousarray(points, np.float64).reshape(-1, 2)
    frame = robot.planner.lattice.frame
    distance_kernels.stamp_discs(grid, frame, block, len(block), radius, np.float32(value))


def stamp_tubes(
    grid: NDArray[np.float32],
    robot: RobotView,
    margins: NDArray[np.float64] | float,
    values: NDArray[np.float32] | float,
) -> None:
    """Stamp what each neighbour holds, and requested if it is gone.

    Args:
        grid: (h, w) lattice of costs; changed.
        margins: [m] beyond the distance that the robot keeps from each, (n,) or one for all.
        values: Cost per metre, (n,) or one for all.
    """
    neighbors = robot.neighbors
    beacons = neighbors.beacons
    frame = robot.planner.lattice.frame
    radii = robot.radius + beacons["radius"].astype(np.float64) + margins
    heights = np.broadcast_to(np.float32(values), radii.shape).astype(np.float32)
    wanted_sizes = np.where(neighbors.gone, beacons["wanted_size"], 0).astype(np.uint32)
    for points, sizes in (
        (beacons["held"], beacons["held_size"]),
        (beacons["wanted"], wanted_sizes),
    ):
        # a single row would be contiguous, several are not: numba would compile a second time
        block, counts = np.ascontiguousarray(points), np.ascontiguousarray(sizes)
        distance_kernels.stamp_rows(grid, frame, block, counts, radii, heights)


def stamp_obstacles(grid: NDArray[np.float32], robot: RobotView, value: float) -> None:
    """Stamp what the LiDAR sees beyond map and beacons.

    Args:
        grid: (h, w) lattice of costs; changed.
    """
    points = robot.obstacle_points()
    if len(points):
        stamp(grid, robot, points, robot.obstacle_clearance + 0.03, value)


def congestion(robot: RobotView) -> NDArray[np.float32]:
    """Return the extra costs under which a way to the goal is planned."""
    extra = robot.planner.no_extra()
    neighbors = robot.neighbors
    speeds = np.abs(neighbors.heads["twist"][:, 0].astype(np.float64))
    values = np.where(speeds > MOVING_SPEED, PASSING, STANDING)
    values[neighbors.heads["mode"] == MODE_YIELD] = PASSING
    values[neighbors.stuck] = BARRED
    # the coarse lattice must not let a path graze a robot that cannot be pushed
    margins = np.where(neighbors.immovable, PARKING_GAP, 0.0)
    stamp_tubes(extra, robot, margins, values)
    if neighbors.immovable.any():  # what they hold is never granted: the last of all ways
        values[neighbors.immovable] = TAKEN
        stamp_tubes(extra, robot, 0.0, values)
    walked = robot.obstacles.walked(robot.tick)
    stamp(extra, robot, walked, robot.obstacle_clearance, PASSING)
    stamp_obstacles(extra, robot, BARRED)
    return extra


def refuge_costs(
    robot: RobotView, is_higher: NDArray[np.bool_], margin: float
) -> NDArray[np.float32]:
    """Return extra costs for making way: robots that rank higher, are stuck or served, are walls.

    Args:
        is_higher: (n,) neighbours that cannot be pushed for this.
        margin: [m] to keep from other robots beyond the reach.
    """
    extra = robot.planner.no_extra()
    neighbors = robot.neighbors
    is_wall = is_higher | neighbors.unyielding
    stamp_tubes(extra, robot, margin, np.where(is_wall, WALL, STANDING))
    stamp_obstacles(extra, robot, float(WALL))
    return extra
