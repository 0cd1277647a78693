"""Safety layer: the space that a robot holds, asks for and announces.

The held tube H is the polyline from the pose to the committed stop; discs of the robot's safety
radius around it belong to the robot. Motion happens inside H only. H grows point by point along
the path, and only over points whose request all near neighbours have acknowledged and that none
of them holds or requests with a better priority (`tube_kernels.extend`, rules G1..G5 of
ARCHITECTURE.md).
Shrinking it is always safe.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from swarm_common.beacon import HELD_POINTS, INTENT_POINTS, WANTED_POINTS
from swarm_common.records import FloatArray, Pose
from swarm_nav import path_kernels, tube_kernels
from swarm_nav.planner import SPACING

REMEMBERED = 32  # beacons whose requests are remembered
INTENT_STRIDE = 2  # path points per intent point: 10 cm


class Tube:
    """Path with the indices of the robot on it, of the end of the held part and of its corners."""

    def __init__(
        self, pose: Pose, confirmations: int, held_length: float, wanted_length: float
    ) -> None:
        """Hold the place under the robot."""
        self.configure(confirmations, held_length, wanted_length)
        self.corner_angle = 0.5
        self._held: FloatArray = np.empty((HELD_POINTS, 2))
        self.is_reverse = False
        self.reset(pose)

    def configure(self, confirmations: int, held_length: float, wanted_length: float) -> None:
        """Take new parameters; space is confirmed anew."""
        self._held_points = max(1, round(held_length / SPACING))
        self._wanted_points = min(WANTED_POINTS, max(1, round(wanted_length / SPACING)))
        self._confirmations = min(confirmations, REMEMBERED)
        self._requests: NDArray[np.int64] = np.zeros((0, 2), np.int64)

    def reset(self, pose: Pose) -> None:
        """Drop path, claim and request; keep the place under the robot."""
        self.points: FloatArray = np.array(((pose.x, pose.y),))
        self.near = 0
        self.stop = 0
        self.corners: list[int] = []
        self.is_withdrawn = False
        self.is_reverse = False
        self.forget_requests()

    @property
    def stop_point(self) -> tuple[float, float]:
        """Where the robot is going to stand if nothing more is granted; plans start here."""
        return float(self.points[self.stop, 0]), float(self.points[self.stop, 1])

    @property
    def is_complete(self) -> bool:
        """Whether the whole path is held."""
        return self.stop >= len(self.points) - 1

    def adopt(self, path: FloatArray, is_reverse: bool = False) -> None:
        """Continue from the stop point along `path` (n, 2), which starts there."""
        kept = self.points[self.near : self.stop + 1]
        self.points = np.ascontiguousarray(np.vstack((kept, path[1:])))
        self.stop -= self.near
        self.near = 0
        self.is_reverse = is_reverse
        self.corners = path_kernels.corners(self.points, self.corner_angle).tolist()
        self.forget_requests()

    def cut(self) -> None:
        """Give up the path beyond the stop point."""
        if len(self.points) > self.stop + 1:
            self.points = self.points[: self.stop + 1]
            self.corners = [k for k in self.corners if k < self.stop]
            self.forget_requests()

    def release_ahead(self, keep: int) -> None:
        """Shrink the held part to `keep` points ahead of the robot and forget the requests."""
        self.stop = min(self.stop, self.near + keep)
        self.forget_requests()

    @property
    def span(self) -> tuple[int, int, int]:
        """(stop, last point wanted now, last point requested in enough beacons)."""
        last = min(self.near + self._held_points, len(self.points) - 1)
        is_confirmed = len(self._requests) >= self._confirmations
        confirmed = int(self._requests[-self._confirmations, 1]) if is_confirmed else -1
        return self.stop, max(self.stop, last), confirmed

    @property
    def requests(self) -> NDArray[np.int64]:
        """(k, 2): tick and last point of the requests published since the last change."""
        return self._requests

    def forget_requests(self) -> None:
        """Have space confirmed anew: what was requested is no longer what is requested."""
        self._requests = self._requests[:0]

    def withdraw(self) -> None:
        """Ask for nothing in the next beacon."""
        self.is_withdrawn = True

    def publish(self, pose: Pose, tick: int) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return (held, wanted, intent) for the beacon of `tick`, and remember what was requested.

        They are views that the next call or a change of the path overwrites.
        """
        ahead = self.points[self.near + 1 : self.stop + 1][: HELD_POINTS - 1]
        held = self._held[: len(ahead) + 1]
        held[0] = pose.x, pose.y
        held[1:] = ahead
        end = min(self.stop + self._wanted_points, len(self.points) - 1)
        if self.is_withdrawn:
            self.is_withdrawn = False
            self.forget_requests()
            wanted = self.points[:0]
        else:
            entry = np.array(((tick, end),), np.int64)
            self._requests = np.concatenate((self._requests[1 - REMEMBERED :], entry))
            wanted = self.points[self.stop + 1 : end + 1]
        intent = self.points[self.stop :: INTENT_STRIDE][:INTENT_POINTS]
        return held, wanted, intent

    def advance(self, pose: Pose, limit: int) -> None:
        """Move the robot's index to the nearest point from here up to `limit`."""
        self.near = tube_kernels.nearest_ahead(self.points, self.near, limit, pose.x, pose.y)

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


def padded(points: NDArray[np.float64], capacity: int) -> tuple[NDArray[np.float32], int]:
    """Return the first `capacity` points as a float32 block (capacity, 2) and their number."""
    block = np.zeros((capacity, 2), np.float32)
    size = min(len(points), capacity)
    block[:size] = points[:size]
    return block, size
