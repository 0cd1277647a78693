"""Long robots: passages that the footprint fits through straight, but not the circle around it.

Where its circle fits, it may turn anywhere, like every robot. A *slot* is a place where
only its polygon fits, on one of eight lines, all the way from room to room: it is entered and left
straight, forwards or backwards, and no robot turns in it. Turning happens in front of it. So
the lattice stays one of places, and slots are nodes with moves along one line only.

Whatever the plan says, `Oblong.admitted` lets no twist pass whose way to standstill brings the
polygon nearer to a mapped wall or to anything that the LiDAR sees than the gap below.
"""

from __future__ import annotations

import functools
import itertools
import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from swarm_common.model.records import CONTROL_PERIOD, FloatArray, Pose, RobotSpec, Twist
from swarm_nav.planning import oblong_kernels as kernels
from swarm_nav.planning import path_kernels
from swarm_nav.planning.distance_kernels import Field, Frame, Place

WALL_GAP = 0.045  # [m] between polygon and walls in a slot, as planned
LEAST_GAP = 0.02  # [m] below which no twist takes it
OBSTACLE_GAP = 0.03  # [m] the same from LiDAR hits that the map does not explain
RIM_SPACING = 0.04  # [m] between the points of the rim at which the clearance is looked up
FILL_SPACING = 0.1  # [m] between those inside
SLOT_COST = 3.0  # cost factor of a metre in a slot: worth a detour
MOUTH_BEND = 0.06  # [rad] of the path at a slot's mouth that is turned on the spot
RUN_IN = 0.5  # [m] over which a robot that starts beside a slot's line comes back to it
BRAKING_SHARE = 0.5  # of the drive's acceleration with which a heavy robot stops at least
SHARES = (1.0, 0.5, 0.25)  # of a twist that are tried


@dataclass(frozen=True)
class Oblong:
    """The outline of a long robot; corners in base_footprint, counter-clockwise."""

    footprint: tuple[tuple[float, float], ...]
    radius: float  # [m] of the circle around it
    half_width: float  # [m]

    @classmethod
    def of(cls, spec: RobotSpec) -> Oblong | None:
        """Return the outline of a long robot, None for a robot that is planned with its circle."""
        if not spec.is_oblong:
            return None
        return cls(spec.footprint, spec.circumscribed_radius, spec.half_width)

    @functools.cached_property
    def corners(self) -> FloatArray:
        """Corners (n, 2)."""
        return np.array(self.footprint)

    @functools.cached_property
    def planned(self) -> FloatArray:
        """Discs (k, 3) that keep `WALL_GAP`."""
        return cover(self.corners, WALL_GAP)

    @functools.cached_property
    def least(self) -> FloatArray:
        """Discs (k, 3) that keep `LEAST_GAP`."""
        return cover(self.corners, LEAST_GAP)

    def admitted(
        self,
        field: tuple[FloatArray, Frame],
        obstacles_map: FloatArray,
        pose_map: Pose,
        now: Twist,
        wish: Twist,
        acceleration: tuple[float, float],
    ) -> Twist:
        """Return the largest scaling of a twist that keeps the polygon clear.

        Args:
            obstacles_map: LiDAR hits (n, 2) [m] that the map does not explain.
            acceleration: Accelerations of the drive, [m/s²] and [rad/s²].

        Returns:
            The scaled wish; a standstill if no scaling is clear. A robot that is too near already
            may move away.
        """
        points = np.ascontiguousarray(obstacles_map)
        walls = Field(*field)
        around = kernels.NearObstacles(points, self.corners, OBSTACLE_GAP)
        pose = Place(pose_map.x, pose_map.y, pose_map.yaw)
        v_acc, w_acc = (BRAKING_SHARE * a for a in acceleration)
        limits = kernels.Ramp(v_acc, w_acc, CONTROL_PERIOD)
        for share in SHARES:
            twist = Twist(share * wish.vx, share * wish.vy, share * wish.wz)
            change = kernels.TwistChange(twist.vx, twist.wz, now.vx, now.wz)
            before, worst = kernels.worst_slack(walls, self.least, around, pose, change, limits)
            if worst >= min(0.0, before):
                return twist
        return Twist()


def cover(corners: FloatArray, gap: float) -> FloatArray:
    """Return discs (k, 3) that cover a polygon and a rim around it.

    A point outside polygon and discs is at least √(gap² - (RIM_SPACING / 2)²) from the polygon.

    Args:
        corners: Corners (n, 2) [m] of a convex polygon, counter-clockwise.
        gap: [m] to keep, at least half of `RIM_SPACING` less a centimetre.
    """
    rows: list[tuple[float, float, float]] = []
    ends = np.roll(corners, -1, axis=0)
    for a, b in zip(corners, ends, strict=True):
        count = max(1, math.ceil(math.dist(a, b) / RIM_SPACING))
        rows += [(*(a + (b - a) * k / count), gap) for k in range(count)]
    low, high = corners.min(axis=0), corners.max(axis=0)
    normals = np.column_stack((corners[:, 1] - ends[:, 1], ends[:, 0] - corners[:, 0]))
    normals /= np.hypot(*normals.T)[:, None]
    for x in np.arange(low[0], high[0] + FILL_SPACING / 2, FILL_SPACING):
        for y in np.arange(low[1], high[1] + FILL_SPACING / 2, FILL_SPACING):
            depth = float(((np.array((x, y)) - corners) * normals).sum(axis=1).min())
            if depth > 0.0:
                rows.append((x, y, min(0.75 * FILL_SPACING, depth + gap)))
    return np.array(rows, np.float64)


class Slots:
    """Places on a lattice through which a long robot drives straight.

    Attributes:
        axes: (height, width) int8, index of the line of a slot, -1 elsewhere.
        room: (height, width) bool, where its circle fits.
    """

    def __init__(
        self, oblong: Oblong, field: Field, clearance: FloatArray, frame: Frame, room: float
    ) -> None:
        """Find the slots.

        Args:
            clearance: (height, width) the same on the lattice.
            room: [m] clearance from which the robot may turn.
        """
        self._frame = frame
        fits = np.empty(clearance.shape, np.uint8)
        limits = kernels.Band(oblong.half_width, room)
        kernels.fitting_axes(clearance, frame, field, oblong.planned, limits, fits)
        self.axes: NDArray[np.int8] = np.empty(clearance.shape, np.int8)
        kernels.choose_axes(clearance, room, fits, self.axes)
        self.room: NDArray[np.bool_] = clearance >= room

    def is_slot(self, points: FloatArray) -> NDArray[np.bool_]:
        """Return which points lie in a slot's cell.

        Args:
            points: (n, 2) [m] in map.

        Returns:
            (n,); False outside the lattice.
        """
        columns = np.floor((points[:, 0] - self._frame.origin_x) / self._frame.step).astype(
            np.int64
        )
        rows = np.floor((points[:, 1] - self._frame.origin_y) / self._frame.step).astype(np.int64)
        height, width = self.axes.shape
        inside = (rows >= 0) & (rows < height) & (columns >= 0) & (columns < width)
        result = np.zeros(len(points), np.bool_)
        result[inside] = self.axes[rows[inside], columns[inside]] != kernels.NO_AXIS
        return result

    def pieces(self, course: FloatArray) -> list[tuple[FloatArray, bool]]:
        """Cut a course of nodes into pieces through slots and between them.

        A piece through slots reaches from the last node before to the first one behind them.

        Args:
            course: (n, 2) [m] in map, n > 1.

        Returns:
            The pieces in order, each with whether it leads through slots. Each begins with the
            point that the one before ends with.
        """
        inner = self.is_slot(course)
        straight = inner[:-1] | inner[1:]
        cuts = [0, *(np.flatnonzero(straight[1:] != straight[:-1]) + 1), len(course) - 1]
        return [(course[a : b + 1], bool(straight[a])) for a, b in itertools.pairwise(cuts)]

    def corners(self, points: FloatArray, angle: float) -> NDArray[np.int64]:
        """Return the indices where a path is turned on the spot: bends, and bends at mouths.

        Args:
            points: (n, 2) [m] in map.
            angle: [rad] beyond which a bend is turned on the spot anywhere; at mouths it is
                `MOUTH_BEND`.

        Returns:
            (k,) indices of points, in rising order.
        """
        inner = self.is_slot(points)
        mouths = np.flatnonzero(inner[1:] != inner[:-1]) + 1
        sharp = path_kernels.corners(points, MOUTH_BEND)
        near = [k for k in sharp if len(mouths) and np.abs(mouths - k).min() <= 3 and not inner[k]]
        return np.union1d(path_kernels.corners(points, angle), np.array(near, np.int64))
