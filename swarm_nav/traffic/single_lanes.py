"""Single-lane passages: which direction goes first through a door too narrow for two robots.

A robot does not enter such a passage, or the mouth before it, while a robot with a higher priority
is about to come through it the other way. A robot is barred by higher priorities only, and never
while it makes way. So the highest robot is never held up, and no two robots wait for each other
here. The rule only orders conflicts that the reservation would otherwise solve by pushing robots
back out of the door.

Robots that go the same way follow each other: one that is about to go through behind a higher one
inherits its priority, less one, until it is out (priority inheritance). So a door changes its
direction after a group of robots, not after each. The group ends with its hops at the latest.
"""

from __future__ import annotations

import functools
from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from swarm_nav.planning import search_kernels
from swarm_nav.planning.cells import distance_cells, label
from swarm_nav.planning.terrain import NODE_MARGIN, Terrain
from swarm_nav.traffic import single_lane_kernels
from swarm_nav.traffic.robot_state import RobotView

MOUTH = 1.5  # [m] around a single-lane passage that is kept free, too
WAY_POINTS = 80  # path points, 4 m, of the own path on which the far end is looked for
RIM = 2.0  # cells beside a node in which a robot counts as being on it
FEWEST_PLACES = 4  # of a room; fewer are a bend or a junction of single lanes

Mask = NDArray[np.bool_]


@functools.lru_cache(maxsize=4)
def passing_areas(terrain: Terrain, radius: float) -> Mask:
    """Return the lattice cells (height, width) of the floor on which two robots pass each other.

    Args:
        radius: [m] safety radius: two robots keep twice that between their centres.
    """
    lattice = terrain.lattice
    half = np.empty_like(lattice.clearance)
    single_lane_kernels.half_width(lattice.clearance, lattice.step, half)
    # two rows of nodes that far apart fit in for sure, and two smooth paths
    kept = max(terrain.radius + NODE_MARGIN + lattice.step / 2, terrain.wall_clearance)
    least = kept + radius
    wide = np.asarray((lattice.base < search_kernels.WALL) & (half >= least), np.bool_)
    for part in connected_components(wide):
        places = single_lane_kernels.places(part, 2.0 * radius / lattice.step, FEWEST_PLACES)
        if places < FEWEST_PLACES:
            wide &= ~part
    return wide


def connected_components(mask: Mask) -> Iterator[Mask]:
    """Yield the connected components of a mask, one by one.

    Args:
        mask: (h, w); cells hang together across edges and corners.

    Yields:
        (h, w), one component each, in the order of their first cells.
    """
    labels = label(mask)
    for number in range(1, int(labels.max(initial=0)) + 1):
        yield labels == number


def with_rim(labels: NDArray[np.int16], is_open: Mask) -> NDArray[np.int16]:
    """Return labels that also hold for cells in walls within two cells, where robots may stand.

    A robot that cuts a corner stands beside the nodes of the lattice; it is where the nearest of
    them is, as in `Lattice.node_of`.

    Args:
        labels: (h, w) of open cells, 0 elsewhere.
        is_open: (h, w).
    """
    wider = labels.copy()
    near = distance_cells(labels > 0) <= RIM
    single_lane_kernels.flood(near & ~is_open, wider, 0, 0)
    return wider


@functools.lru_cache(maxsize=4)
def single_lanes(terrain: Terrain, radius: float) -> NDArray[np.int16] | None:
    """Return labels (height, width) of single-lane passages with their mouths, 0 elsewhere.

    Args:
        radius: [m] safety radius.

    Returns:
        Labels from 1, or None if the map has no such passage.
    """
    lattice = terrain.lattice
    is_free = lattice.base < search_kernels.WALL
    is_single = is_free & ~passing_areas(terrain, radius)
    if not is_single.any():
        return None
    labels = label(is_single)
    near = distance_cells(is_single) * lattice.step <= MOUTH
    single_lane_kernels.flood(is_free & near, labels, 0, 0)
    return labels


class SingleLanes:
    """Keeps one robot out of a single-lane passage while it is another robot's turn."""

    why = "comes through a single lane"  # the robot that is waited for

    def __init__(self) -> None:
        self._base = 0  # priority without that
        self._passing: tuple[Terrain, float] | None = None  # that the labels are for
        self._labels: NDArray[np.int16] | None = None

    def barrier(self, robot: RobotView, last: int) -> tuple[int, int]:
        """Return (index of the last point that may be claimed, row of the robot waited for).

        Args:
            last: Index of the last path point that is wanted; (last, -1) if nothing is in the way.
        """
        if robot.passing != self._passing:
            self._passing = robot.passing
            self._labels = single_lanes(*robot.passing)
            robot.donations.lane = 0
        if self._labels is None:
            return last, -1
        tube, neighbors = robot.tube, robot.neighbors
        way = tube.points[tube.stop : tube.stop + WAY_POINTS]
        frame = robot.planner.lattice.frame
        if not robot.donations.lane:
            self._base = robot.own_priority
        if not single_lane_kernels.entry_of(self._labels, frame, way, last - tube.stop):
            self._follow(robot, 0)
            return last, -1
        count, row, inherited = single_lane_kernels.barrier(
            self._labels,
            frame,
            way,
            last - tube.stop,
            (robot.priority, robot.robot_id, robot.donations.yields_for),
            self._base,
            neighbors.columns(),
        )
        self._follow(robot, int(inherited))
        return tube.stop + count, row

    def _follow(self, robot: RobotView, inherited: int) -> None:
        """Inherit, and keep what was inherited until the robot is out of the passage."""
        if inherited:
            robot.donations.lane = max(robot.donations.lane, inherited)
        elif robot.donations.lane:
            assert self._labels is not None
            frame, pose = robot.planner.lattice.frame, robot.pose
            places = ((pose.x, pose.y), robot.stop_point)
            if not any(single_lane_kernels.label_at(self._labels, frame, *at) for at in places):
                robot.donations.lane = 0
