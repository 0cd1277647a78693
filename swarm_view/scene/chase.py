"""The camera that goes with a robot."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from typing import Any

import numpy as np

from swarm_common.model.records import FloatArray

CLOSE_UP = np.array([-1.2, -2.4, 3.2])  # [m] of the camera from its robot
FOLLOWED = 1.0  # [m] within which a camera looks at the robot that it follows
COME = 0.1  # [m] the same for a page that may still show something else
MOVED = 1e-3  # [m] from which a robot has moved
SAME = 5e-3  # [m] between two views that are one
ECHOES = 30  # views of late that a page may still report
LOOK_PERIOD = 1.0  # [s] of wall time between two looks whether the camera has come
APPROACH = 10.0  # [s] for which that is doubted: a page that loads may put it elsewhere
PATIENCE = 0.25  # [s] of wall time for which the camera stays with a reader who turns the view

# Called with a target (3,) and the position (3,) from which to look at it, both in map.
Look = Callable[[FloatArray, FloatArray], None]


class Chase:
    """Keeps a robot in the middle of one page; its reader turns and zooms as before.

    The camera position that a page reports is late, and mostly an echo of our own orders. So the
    camera is never placed by a report. Only an offset from robot to camera that we did not order is
    adopted, because it is the reader's.
    """

    def __init__(self, camera: Any, look: Look) -> None:
        """Follow no robot yet; `camera` reports the page's `position` and `look_at`, each (3,)."""
        self._camera = camera
        self.look = look
        self._seen: FloatArray | None = None
        self._offset = CLOSE_UP
        self._told: deque[FloatArray] = deque(maxlen=ECHOES)
        self._look_due = self._doubt_end = self._turn_end = 0.0

    def expect(self, target: FloatArray, position: FloatArray) -> None:
        """Know a view that the page may take up by itself, however late: not the reader's."""
        self._told.append(position - target)

    def rest(self) -> None:
        """Leave the camera where it is; the next robot is come close to."""
        self._seen = None

    def follow(self, pose: FloatArray, now: float) -> None:
        """Go with a robot at `pose` (3,) in map; `now` is wall time."""
        place = np.array([pose[0], pose[1], 0.0])
        if self._seen is None:
            self._doubt_end = now + APPROACH
            self._offset = CLOSE_UP
            self._told += [self._camera.position - self._camera.look_at, CLOSE_UP]
        elif np.abs(place - self._seen).max() > MOVED:
            self._heed_reader(self._seen, now)
            if now < self._turn_end:
                return
        elif not self._is_lost(place, now):
            return
        self.look(place, place + self._offset)
        self._seen = place

    def _heed_reader(self, seen: FloatArray, now: float) -> None:
        """Follow the way in which the reader has turned and zoomed."""
        look_at = self._camera.look_at
        if now < self._doubt_end and np.abs(look_at - seen).max() > COME:
            return
        offset = self._camera.position - look_at
        if all(np.abs(offset - told).max() > SAME for told in self._told):
            self._offset = offset
            self._told.append(offset)
            self._turn_end = now + PATIENCE

    def _is_lost(self, place: FloatArray, now: float) -> bool:
        """Return whether the camera was put elsewhere after it was told to come here."""
        """Return whether the camera was put elsewhere after it was told to come here."""
        if now > self._doubt_end or now < self._look_due:
            return False
        self._look_due = now + LOOK_PERIOD
        return bool(np.abs(self._camera.look_at - place).max() > FOLLOWED)
