"""A distance on the floor of one page, from one place to another."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from swarm_common.model.palette import PINK
from swarm_common.model.records import FloatArray
from swarm_view.scene.shapes import lifted

HEIGHT = 0.05  # [m]
WIDTH = 0.04  # [m]


class Ruler:
    """The nodes under `/ruler` in the scene of one page."""

    def __init__(self, scene: Any) -> None:
        self._scene = scene
        self._drawn: list[Any] = []
        self._start: FloatArray | None = None

    def clear(self) -> None:
        """Measure nothing any more."""
        for node in self._drawn:
            node.remove()
        self._drawn = []
        self._start = None

    def point(self, place: FloatArray) -> float | None:
        """Take a place (2,) in map; return the distance [m] from the one before, if there is one.

        The place after that begins another measurement.
        """
        if self._start is None:
            self.clear()
            self._start = place
            self._drawn.append(
                self._scene.add_icosphere(
                    "/ruler/start", radius=WIDTH, color=PINK, position=(*place, HEIGHT)
                )
            )
            return None
        return self.measure(self._start, place)

    def measure(self, start: FloatArray, end: FloatArray) -> float:
        """Draw the distance between two places (2,) in map, and return it [m]."""
        self.clear()
        distance = math.dist(start, end)
        points = lifted(np.array([start, end]), HEIGHT)
        self._drawn = [
            self._scene.add_line_segments("/ruler/line", points[None], PINK, thickness=WIDTH),
            self._scene.add_label(
                "/ruler/label", f"{distance:.2f} m", position=points.mean(axis=0),
                anchor="bottom-center",
            ),
        ]  # fmt: skip
        return distance
