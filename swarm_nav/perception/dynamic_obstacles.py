"""Decides which marks of the obstacle layer may be a walking person.

A mark is restless until it has been there for long. How long that takes depends on the body's
history. A body that was seen to walk, by hits where rays had passed shortly before, scan after
scan, may be a person who pauses. One that appeared and stood at once counts as an object sooner,
and one that never moved sooner still. Young marks near a mover's belong to it.
"""

from __future__ import annotations

import collections
import math

import numpy as np
from numpy.typing import NDArray

from swarm_common.model.records import FloatArray
from swarm_nav.perception import dynamic_obstacle_kernels
from swarm_nav.perception.obstacle_kernels import Beam
from swarm_nav.planning.distance_kernels import Place

STILL_TICKS = 80  # after which a mark that never moved is an object,
CAME_TICKS = 200  # a mark that came and has stood since,
MOVER_TICKS = 3000  # and a mark that was seen walking
LIMITS = (STILL_TICKS, CAME_TICKS, MOVER_TICKS)  # by motion
WALK_TICKS = 4  # between two arrivals of a walking body; a standing one arrives for PAST_SCANS only
PAST_SCANS = 2  # earlier scans in which the way of a moving thing is looked for
FREE_MARGIN = 0.15  # [m] beyond a place that a ray must have gone to show that it was free
GONE_TICKS = 30  # after which the mark of a moving body, if not hit again, is dropped
BODY = 0.3  # [m] within which marks belong to one body
WALKING = LIMITS.index(MOVER_TICKS)
WALKED_CELL = 0.2  # [m] of the places that are remembered where somebody walked,
WALKED_TICKS = 300  # and for how long
NO_PLACES: FloatArray = np.zeros((0, 2))


class DynamicObstacles:
    """Age and motion of marks; row k of each array is about mark k."""

    def __init__(self, cell: float) -> None:
        """Start without marks.

        Args:
            cell: [m] edge of the cells that marks are rounded to.
        """
        self._cell = cell
        self._past: collections.deque[tuple[NDArray[np.float32], Place]] = collections.deque(
            maxlen=PAST_SCANS
        )
        self._walked: dict[tuple[int, int], int] = {}  # cell: tick at which somebody walked there
        self.clear()

    def clear(self) -> None:
        """Forget all marks, but not where somebody walked."""
        self._births = np.zeros(0, np.int64)  # tick in which each mark appeared
        self._hit_ticks = np.zeros(0, np.int64)  # in which it was last hit
        self._motion = np.zeros(0, np.int64)  # index into LIMITS

    def keep(self, mask: NDArray[np.bool_]) -> None:
        """Forget some marks.

        Args:
            mask: (n,) bool, False for those to forget.
        """
        self._births, self._motion = self._births[mask], self._motion[mask]
        self._hit_ticks = self._hit_ticks[mask]

    def present(self, tick: int) -> NDArray[np.bool_]:
        """Return which marks may still be there: a moving body that is out of sight goes away.

        Returns:
            (n,) bool.
        """
        present: NDArray[np.bool_] = (self._motion == 0) | (tick - self._hit_ticks < GONE_TICKS)
        return present

    def arrivals(
        self, hits: FloatArray, ranges: NDArray[np.float32], beam: Beam, pose: Place, reach: float
    ) -> FloatArray:
        """Return the hits at places through which rays passed two scans ago; remember this scan.

        Args:
            hits: Unexplained ones (k, 2) in map.
            ranges: Ranges (n,) [m] of the scan.
            reach: [m] up to which rays tell of free space.
        """
        past = self._past[0] if len(self._past) == PAST_SCANS else None
        self._past.append((ranges, pose))
        if past is None or len(hits) == 0:
            return hits[:0]
        has_come = np.zeros(len(hits), np.bool_)
        before, pose_before = past
        dynamic_obstacle_kernels.passed_through(
            hits, before, beam, pose_before, reach, FREE_MARGIN, has_come
        )
        return hits[has_come]

    def update(
        self, marks: FloatArray, old: FloatArray, hits: FloatArray, arrivals: FloatArray, tick: int
    ) -> None:
        """Store new marks.

        Args:
            marks: All of them (n, 2).
            old: Those that were kept (m, 2), in order.
            hits: Hits (k, 2) [m] in map from which the new ones come.
            arrivals: (j, 2) those of the hits that have come lately.
        """
        births = np.empty(len(marks), np.int64)
        hit_ticks = np.empty(len(marks), np.int64)
        motion = np.empty(len(marks), np.int64)
        dynamic_obstacle_kernels.inherit(
            marks,
            old,
            (self._births, self._motion, self._hit_ticks),
            hits,
            arrivals,
            (self._cell, BODY),
            (tick, LIMITS),
            WALK_TICKS,
            (births, motion, hit_ticks),
        )
        self._births, self._motion, self._hit_ticks = births, motion, hit_ticks
        walking = marks[(motion == WALKING) & (hit_ticks == tick)]
        for x, y in np.round(walking / WALKED_CELL).astype(int).tolist():
            self._walked[x, y] = tick

    def walked(self, tick: int) -> FloatArray:
        """Return the places (n, 2) [m] in map where somebody has walked lately."""
        if not self._walked:
            return NO_PLACES
        self._walked = {at: then for at, then in self._walked.items() if tick - then < WALKED_TICKS}
        return np.array(list(self._walked), np.float64).reshape(-1, 2) * WALKED_CELL

    def gap(self, marks: FloatArray, x: float, y: float, tick: int) -> float:
        """Return the distance [m] of a place from the nearest restless mark; inf without one.

        Args:
            marks: (n, 2) [m] in map, all of them.
            x: [m] of the place, in map.
            y: [m] of the place, in map.
        """
        if len(marks) == 0:
            return math.inf
        ages = (tick, LIMITS)
        return float(
            dynamic_obstacle_kernels.restless_gap(marks, self._births, self._motion, ages, x, y)
        )
