"""What one page shows of all robots: names and states, trails, committed motion."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from swarm_common.model.palette import HELD, RGB, TRAIL
from swarm_common.model.records import FloatArray
from swarm_view.panel_text import label_text
from swarm_view.shapes import polyline, raised
from swarm_view.swarm import Swarm
from swarm_view.topics import Layer

LABEL_HEIGHT = 0.45  # [m]
LINE_HEIGHT = 0.015  # [m]
MOVED = 0.01  # [m] from which a label goes with its robot
STYLES: dict[str, tuple[RGB, float]] = {"trails": (TRAIL, 0.03), "claims": (HELD, 0.08)}


class Overlay:
    """The nodes under `/labels` and `/all` in the scene of one page."""

    def __init__(self, scene: Any, swarm: Swarm) -> None:
        """Draw nothing yet; `scene` is the client's."""
        self._scene = scene
        self._swarm = swarm
        self._labels: dict[str, Any] = {}
        self._lines: dict[str, Any] = {}

    def draw_labels(self, names: Sequence[str], poses: FloatArray) -> None:
        """Label these robots, and no others; `poses` (n, 3) of all robots in map."""
        places = {}
        for name in names:
            index = self._swarm.index(name)
            if index is not None and index < len(poses):
                places[name] = float(poses[index, 0]), float(poses[index, 1]), LABEL_HEIGHT
        for name in self._labels.keys() - places.keys():
            self._labels.pop(name).remove()
        for name, place in places.items():
            self._label(name, label_text(name, self._swarm.states.get(name)), place)

    def _label(self, name: str, text: str, place: tuple[float, float, float]) -> None:
        label = self._labels.get(name)
        if label is None:
            self._labels[name] = self._scene.add_label(
                f"/labels/{name}", text, position=place, anchor="bottom-center",
                font_screen_scale=0.8,
            )  # fmt: skip
            return
        if label.text != text:
            label.text = text
        if np.abs(label.position - place).max() > MOVED:
            label.position = place

    def draw_trails(self, *, wanted: bool) -> None:
        """Draw where the robots have been, or no more."""
        self._draw("trails", self._swarm.trails.segments() if wanted else None)

    def draw_claims(self, *, wanted: bool) -> None:
        """Draw the space that each robot holds, or no more."""
        self._draw("claims", self._claims() if wanted else None)

    def _claims(self) -> FloatArray:
        parts = [np.zeros((0, 2, 2))]
        for name in self._swarm.names:
            _, motion = self._swarm.layer(name, Layer.MOTION)
            if motion is not None and len(motion.held) > 1:
                parts.append(polyline(motion.held, 0.0)[:, :, :2])
        return np.concatenate(parts)

    def _draw(self, name: str, segments: FloatArray | None) -> None:
        if segments is None or not len(segments):
            if name in self._lines:
                self._lines.pop(name).remove()
            return
        points = raised(segments, LINE_HEIGHT)
        if name in self._lines:
            self._lines[name].points = points.astype(np.float32)
            return
        color, width = STYLES[name]
        self._lines[name] = self._scene.add_line_segments(
            f"/all/{name}", points, color, thickness=width
        )
