"""Safety layer: the space that a robot holds, asks for and announces.

The held tube H is the part of the path from the robot to the committed stop; discs of the robot's
safety radius around it belong to the robot. Motion happens within `TOLERANCE` of H only. H grows
point by point along the path, and only over points whose request all near neighbours have
acknowledged and that none of them holds or requests with a better priority (`tube_kernels.extend`,
rules G1..G5 of docs/architecture/safety.md). It shrinks at either end only as far as the robot can
brake in the rest.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from swarm_common.model.beacon import HELD_POINTS, INTENT_POINTS, WANTED_POINTS
from swarm_common.model.records import FloatArray, Pose
from swarm_nav.planning import path_kernels
from swarm_nav.planning.oblong import Slots
from swarm_nav.planning.planner import SPACING
from swarm_nav.reservation import tube_kernels

REMEMBERED = 32  # beacons whose requests are remembered
ARRIVED = 0.03  # [m] from a corner or the end at which the robot stands on it
TOLERANCE = 0.036  # [m] from the held polyline: see Margin in docs/architecture/safety.md


class Tube:
    """Path with the indices of the robot on it, of both ends of the held part and of its corners.

    Attributes:
        points: (n, 2) [m] in map, the path.
        tail: Index of the first held point, which follows the robot along the path.
        stop: Index of the last held point.
    """

    def __init__(
        self, pose: Pose, confirmations: int, held_length: float, wanted_length: float
    ) -> None:
        """Hold the place of the robot, without a path.

        Args:
            confirmations: Beacons in which space is requested before it is taken.
            held_length: [m] of path held ahead.
            wanted_length: [m] requested beyond that.
        """
        self.configure(confirmations, held_length, wanted_length)
        self.corner_angle = 0.5
        self.slots: Slots | None = None  # of a long robot
        points = np.zeros((HELD_POINTS + WANTED_POINTS + INTENT_POINTS, 2), np.float32)
        self._blocks = np.split(points, (HELD_POINTS, HELD_POINTS + WANTED_POINTS))
        self.published: NDArray[np.uint32] = points.view(np.uint32).ravel()
        self.published_held = self._blocks[0], 0  # and how many of its points count
        self.published_sizes = (0, 0, 0)  # points that count of held, wanted, intent
        # room for twice as many: it is moved when it is full, not in each tick
        self._log: NDArray[np.int64] = np.zeros((2 * REMEMBERED, 2), np.int64)
        self._logged = 0  # rows of the log in use, the latest last
        self.is_reverse = False
        self.reset(pose)

    def configure(self, confirmations: int, held_length: float, wanted_length: float) -> None:
        """Apply new parameters; all space must be confirmed again.

        Args:
            confirmations: Beacons in which space is requested before it is taken.
            held_length: [m] of path held ahead.
            wanted_length: [m] requested beyond that.
        """
        self._held_points = max(1, round(held_length / SPACING))
        self._wanted_points = min(WANTED_POINTS, max(1, round(wanted_length / SPACING)))
        self._confirmations = min(confirmations, REMEMBERED)
        self._noted = 0

    def shrink_to_place(self, pose: Pose) -> None:
        """Drop path, claim and request; keep the point of the held space next to the robot.

        That is not its pose: others acknowledged the space, and a place beside it would move
        farther off with each call.
        """
        x, y = tube_kernels.nearest_on(self.points, self.tail, self.stop, pose.x, pose.y)
        self.reset(Pose(x, y, pose.yaw))

    def gap(self, pose: Pose) -> float:
        """Return the distance [m] of the robot to the held polyline."""
        x, y = tube_kernels.nearest_on(self.points, self.tail, self.stop, pose.x, pose.y)
        return math.hypot(x - pose.x, y - pose.y)

    def reset(self, pose: Pose) -> None:
        """Drop path, claim and request; hold a place that others need not know."""
        self.points: FloatArray = np.array(((pose.x, pose.y),))
        self.tail = self._near = self.stop = 0
        self._origin = pose.x, pose.y
        self.corners: list[int] = []
        self.corner = 0  # that is driven to: the next bend or the end, by `track`
        self.is_withdrawn = False
        self.is_reverse = False
        self.is_at_rest = False
        self.forget_requests()

    @property
    def stop_point(self) -> tuple[float, float]:
        """Place at which the robot will stand if nothing more is granted; plans start here."""
        return float(self.points[self.stop, 0]), float(self.points[self.stop, 1])

    @property
    def place(self) -> tuple[float, float]:
        """First held point (x, y) [m] in map."""
        return float(self.points[self.tail, 0]), float(self.points[self.tail, 1])

    @property
    def is_complete(self) -> bool:
        """Whether the whole path is held."""
        return self.stop >= len(self.points) - 1

    def adopt(self, path: FloatArray) -> None:
        """Continue from the stop point along a path.

        Args:
            path: (n, 2) [m] in map; it starts at the stop point.
        """
        self._follow(self.tail, self.points[: self.stop + 1], path)
        self.forget_requests()

    def lengthen(self, path: FloatArray) -> None:
        """Let the path go on from its end; what was requested stays requested.

        Args:
            path: (n, 2) [m] in map; it starts at the end.
        """
        first = min(self.tail, max(0, self.near - 1))  # where the robot comes from tells of a bend
        self._log[:, 1] -= first
        self._follow(first, self.points, path)

    def _follow(self, first: int, kept: FloatArray, path: FloatArray) -> None:
        rest = path_kernels.thinned(np.ascontiguousarray(path), ARRIVED)[1:]
        self.points = np.ascontiguousarray(np.vstack((kept[first:], rest)))
        self.tail, self._near, self.stop = self.tail - first, self._near - first, self.stop - first
        find = path_kernels.corners if self.slots is None else self.slots.corners
        self.corners = find(self.points, self.corner_angle).tolist()

    @staticmethod
    def end_of(path: FloatArray) -> tuple[float, float]:
        """Return the last point (x, y) of a path (n, 2), n > 1, as it is once it was adopted."""
        x, y = path_kernels.thinned(np.ascontiguousarray(path), ARRIVED)[-1].tolist()
        return x, y

    def cut(self) -> None:
        """Give up the path beyond the stop point."""
        if len(self.points) > self.stop + 1:
            self.points = self.points[: self.stop + 1]
            self.corners = [k for k in self.corners if k < self.stop]
            self.forget_requests()

    def release_beyond(self, last: int) -> None:
        """Shrink the held part; the robot must be able to stop in the rest.

        Requests are forgotten then: what was held and is given up was not requested.

        Args:
            last: Index of the last point that stays held, not before `near`.
        """
        if last < self.stop:
            self.stop = last
            self.forget_requests()

    @property
    def span(self) -> tuple[int, int, int]:
        """(stop, last point wanted now, last point requested in enough beacons)."""
        most = min(self.near + self._held_points, self.tail + HELD_POINTS - 2)  # fits a beacon
        last = min(most, len(self.points) - 1)
        is_known = self._noted >= self._confirmations
        confirmed = int(self._log[self._logged - self._confirmations, 1]) if is_known else -1
        return self.stop, max(self.stop, last), confirmed

    @property
    def requests(self) -> NDArray[np.int64]:
        """(k, 2): tick and last point of the requests published since the last change."""
        return self._log[self._logged - self._noted : self._logged]

    def forget_requests(self) -> None:
        """Discard confirmations, because the request has changed."""
        self._noted = 0

    def withdraw(self) -> None:
        """Ask for nothing in the next beacon."""
        self.is_withdrawn = True

    def publish(self, pose: Pose, tick: int) -> tuple[NDArray[np.float32], ...]:
        """Return the blocks of a beacon, and remember the request.

        Returns:
            (held, wanted, intent), each (n, 2) float32 [m] in map: views of `published` that the
            next call overwrites.
        """
        end = self.stop
        if self.is_withdrawn:
            self.is_withdrawn = False
            self.forget_requests()
        else:
            end = min(self.stop + self._wanted_points, len(self.points) - 1)
            self._record_request(tick, end)
        held, wanted, intent = self._blocks
        sizes = tube_kernels.publish(
            self.points, (pose.x, pose.y), (self.tail, self.stop, end), TOLERANCE,
            held, wanted, intent,
        )  # fmt: skip
        self.published_held, self.published_sizes = (held, sizes[0]), sizes
        return held[: sizes[0]], wanted[: sizes[1]], intent[: sizes[2]]

    def _record_request(self, tick: int, end: int) -> None:
        if self._logged == len(self._log):
            self._log[:REMEMBERED] = self._log[REMEMBERED:]
            self._logged = REMEMBERED
        self._log[self._logged, 0] = tick
        self._log[self._logged, 1] = end
        self._logged += 1
        self._noted = min(self._noted + 1, REMEMBERED)

    def track(self, pose: Pose) -> None:
        """Move the robot's index on along the path, up to the next corner or the held end.

        A corner that is held and that the robot stands on counts as passed.
        """
        corner = self.next_corner()
        self.advance(pose, min(corner, self.stop))
        if self.near < corner <= self.stop and self.gap_to(corner, pose) < ARRIVED:
            self.near = corner
            corner = self.next_corner()
        self.corner = corner

    def gap_to(self, index: int, pose: Pose) -> float:
        """Return the distance [m] of the robot to a point of the path."""
        return math.hypot(self.points[index, 0] - pose.x, self.points[index, 1] - pose.y)

    def advance(self, pose: Pose, limit: int) -> None:
        """Move the robot's index to the nearest point from here on."""
        self.near = self.nearest(pose, limit)

    def nearest(self, pose: Pose, limit: int) -> int:
        """Return the index of the nearest point from the robot's index on.

        That point itself counts where it was before it began to follow the robot.

        Args:
            limit: Index of the last point that may be the nearest.
        """
        x, y = self._origin
        gap = math.hypot(x - pose.x, y - pose.y)
        return int(tube_kernels.nearest_ahead(self.points, self.near, gap, limit, pose.x, pose.y))

    def follow_robot(self, tail: int) -> None:
        """Give up what lies before a point."""
        self.tail = tail
        self.near = max(self.near, tail)

    @property
    def near(self) -> int:
        """Index of the point nearest to the robot, from `tail` to `stop`."""
        return self._near

    @near.setter
    def near(self, index: int) -> None:
        if index != self._near:
            self._near = index
            self._origin = float(self.points[index, 0]), float(self.points[index, 1])

    def record_rest(self, pose: Pose, is_standing: bool) -> None:
        """Record whether the robot stands on its stop: then it stays, and holds that place only.

        Args:
            is_standing: Whether it has stopped.
        """
        x, y = self.stop_point
        is_there = self.near >= self.stop and math.hypot(x - pose.x, y - pose.y) < ARRIVED
        self.is_at_rest = is_standing and is_there
        if self.is_at_rest:
            self.tail = self.stop

    def next_corner(self) -> int:
        """Return the index of the next bend that is turned on the spot, or of the path's end."""
        for corner in self.corners:
            if corner > self.near:
                return corner
        return len(self.points) - 1

    def length_ahead(self) -> float:
        """Return the length [m] of the path beyond the robot."""
        rest = self.points[self.near :]
        if len(rest) < 2:
            return 0.0
        return float(np.hypot(np.diff(rest[:, 0]), np.diff(rest[:, 1])).sum())


COMPILED = False  # mypyc takes it for true: it reads attributes of classes, not of protocols
if TYPE_CHECKING and not COMPILED:
    from swarm_nav.reservation.tube_view import TubeView as TubeView
else:
    TubeView = Tube


def padded(points: NDArray[np.float64], capacity: int) -> tuple[NDArray[np.float32], int]:
    """Return points as a block of fixed size.

    Args:
        points: (n, 2).
        capacity: Points of the block; further points are left out.

    Returns:
        The block (capacity, 2) float32, zeros behind the points, and the number of points in it.
    """
    block = np.zeros((capacity, 2), np.float32)
    size = min(len(points), capacity)
    block[:size] = points[:size]
    return block, size
