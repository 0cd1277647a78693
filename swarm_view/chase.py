"""The camera that goes with a robot."""

from __future__ import annotations

from typing import Any

import numpy as np

from swarm_common.records import FloatArray

CLOSE_UP = np.array([-1.2, -2.4, 3.2])  # [m] of the camera from its robot
FOLLOWED = 1.0  # [m] within which a camera looks at the robot that it follows
MOVED = 1e-3  # [m] from which a robot has moved
LOOK_PERIOD = 1.0  # [s] of wall time between two looks whether the camera has come
APPROACH = 10.0  # [s] for which that is doubted: a page that loads may put it elsewhere


class Chase:
    """Keeps a robot in the middle of one page; its reader turns and zooms as before."""

    def __init__(self, client: Any) -> None:
        """Follow nobody yet; `client` is viser's handle of the page."""
        self._client = client
        self._seen: FloatArray | None = None
        self._offset = CLOSE_UP
        self._look_due = self._doubt_end = 0.0

    def rest(self) -> None:
        """Leave the camera where it is; the next robot is come close to."""
        self._seen = None

    def follow(self, pose: FloatArray, now: float) -> None:
        """Go with a robot at `pose` (3,) in map; `now` is wall time."""
        place = np.array([pose[0], pose[1], 0.0])
        if self._seen is None:
            self._offset = CLOSE_UP
            self._doubt_end = now + APPROACH
            self.look(place, place + self._offset)
        elif np.abs(place - self._seen).max() > MOVED:
            self._go_on(place, place - self._seen)
        elif self._is_lost(place, now):
            self.look(place, place + self._offset)
        else:
            return
        self._seen = place

    def _go_on(self, place: FloatArray, step: FloatArray) -> None:
        camera = self._client.camera
        if np.abs(camera.look_at - place).max() > FOLLOWED:  # it is not there yet
            self.look(place, place + self._offset)
            return
        self._offset = camera.position - camera.look_at
        with self._client.atomic():
            camera.position = camera.position + step  # viser takes look_at along

    def _is_lost(self, place: FloatArray, now: float) -> bool:
        """Return whether the camera was put elsewhere after it was told to come here."""
        if now > self._doubt_end or now < self._look_due:
            return False
        self._look_due = now + LOOK_PERIOD
        return bool(np.abs(self._client.camera.look_at - place).max() > FOLLOWED)

    def look(self, target: FloatArray, position: FloatArray) -> None:
        """Look from a position (3,) at a target (3,)."""
        with self._client.atomic():
            self._client.camera.position = position
            self._client.camera.look_at = target
