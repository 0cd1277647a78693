"""Overlay of one page on all robots: names and states, trails, committed motion."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from swarm_common.model.palette import HELD, INTENT, PLAN, RGB, TRAIL, linear, state_color
from swarm_common.model.records import FloatArray
from swarm_view.scene.images import grid_lines
from swarm_view.scene.labels import LabelWish, PlacedLabel, arrange
from swarm_view.scene.shapes import lifted, polyline, raised
from swarm_view.scene.views import Camera
from swarm_view.state.swarm import Swarm
from swarm_view.state.topics import Layer

LABEL_HEIGHT = 0.2  # [m]
LABEL_SCALE = 0.8
LETTERS = "".join(chr(code) for code in range(65, 123))  # before a robot's number
LINE_HEIGHT = 0.015  # [m]
MOVED = 0.01  # [m] from which a label goes with its robot
STYLES: dict[str, tuple[RGB, float]] = {
    "trails": (TRAIL, 0.03),
    "claims": (HELD, 0.08),
    "plans": (PLAN, 0.035),
    "way": (INTENT, 0.04),
}


class Overlay:
    """The nodes under `/labels` and `/all` in the scene of one page."""

    def __init__(self, scene: Any, swarm: Swarm) -> None:
        self._scene = scene
        self.swarm = swarm
        self._labels: dict[str, Any] = {}
        self._lines: dict[str, Any] = {}

    def draw_labels(
        self, names: Sequence[str], poses: FloatArray, sizes: FloatArray, camera: Camera
    ) -> None:
        """Label stations and these robots as far as there is room, the first ones first.

        Args:
            poses: (n, 3) of all robots, in map.
            sizes: (n,) [m] of all robots' marks.
        """
        wishes = []
        for name in names:
            index = self.swarm.index(name)
            if index is not None and index < min(len(poses), len(sizes)):
                place = np.array([poses[index, 0], poses[index, 1], LABEL_HEIGHT])
                state = self.swarm.states.get(name)
                text = name if state is None else f"{name} {state.state}"
                texts = (text, name, name.lstrip(LETTERS) or name)
                wishes.append(LabelWish(name, texts, place, float(sizes[index])))
        stations = self.swarm.stations
        wishes += [LabelWish(f"station {name}", (name,), place) for name, place in stations.items()]
        wishes += self._numbers()
        count = min(len(poses), len(sizes))
        marks = lifted(poses[:count, :2], 0.0), sizes[:count]
        placed = arrange(wishes, camera, LABEL_SCALE, marks)
        for name in self._labels.keys() - placed.keys():
            self._labels.pop(name).remove()
        for name, label in placed.items():
            self._label(name, label)

    def _numbers(self) -> list[LabelWish]:
        """Return the labels of the grid's lines, along the lower and the left edge of the map."""
        raster = self.swarm.map
        if raster is None:
            return []
        (left, low), (width, depth) = raster.origin, raster.size
        places = {f"x {x}": (float(x), low, 0.0) for x in grid_lines(left, left + width)}
        places |= {f"y {y}": (left, float(y), 0.0) for y in grid_lines(low, low + depth)}
        return [LabelWish(name, (name,), np.array(place)) for name, place in places.items()]

    def _label(self, name: str, placed: PlacedLabel) -> None:
        label = self._labels.get(name)
        if label is not None and label.anchor != placed.anchor:
            label.remove()
            label = None
        if label is None:
            self._labels[name] = self._scene.add_label(
                f"/labels/{name}",
                placed.text,
                position=placed.place,
                anchor=placed.anchor,
                font_screen_scale=LABEL_SCALE,
            )
            return
        if label.text != placed.text:
            label.text = placed.text
        if np.abs(label.position - placed.place).max() > MOVED:
            label.position = placed.place

    def draw_trails(self, *, wanted: bool) -> None:
        """Draw where the robots have been, or no more."""
        self._draw("trails", self.swarm.trails.segments() if wanted else None)

    def draw_claims(self, *, wanted: bool) -> None:
        """Draw the space that each robot holds, or remove it."""
        self._draw("claims", self._claims() if wanted else None)

    def draw_plans(self, robots: Sequence[str]) -> None:
        """Draw the plans of these robots in the colours of their states, and no others."""
        parts, colors = [np.zeros((0, 2, 2))], [np.zeros((0, 2, 3), np.uint8)]
        for robot in robots:
            _, points = self.swarm.layer(robot, Layer.PLAN)
            if points is None or len(points) < 2:
                continue
            parts.append(polyline(points, 0.0)[:, :, :2])
            state = self.swarm.states.get(robot)
            color = state_color("" if state is None else state.state)
            colors.append(np.full((len(points) - 1, 2, 3), linear(color), np.uint8))
        segments, paint = np.concatenate(parts), np.concatenate(colors)
        if "plans" in self._lines and len(segments):
            known = self._lines["plans"]
            if known.points.shape != (len(segments), 2, 3):
                self._lines.pop("plans").remove()
            elif not np.array_equal(known.colors, paint):
                known.colors = paint
        self._draw("plans", segments, paint)

    def draw_way(self, points: FloatArray | None) -> None:
        """Draw where a robot has been (n, 2), in map; None for nothing."""
        self._draw("way", None if points is None else polyline(points, 0.0)[:, :, :2])

    def _claims(self) -> FloatArray:
        parts = [np.zeros((0, 2, 2))]
        for name in self.swarm.names:
            _, motion = self.swarm.layer(name, Layer.MOTION)
            if motion is not None and len(motion.held) > 1:
                parts.append(polyline(motion.held, 0.0)[:, :, :2])
        return np.concatenate(parts)

    def _draw(
        self, name: str, segments: FloatArray | None, paint: NDArray[np.uint8] | None = None
    ) -> None:
        if segments is None or not len(segments):
            if name in self._lines:
                self._lines.pop(name).remove()
            return
        points = raised(segments, LINE_HEIGHT)
        if name in self._lines:
            if not np.array_equal(self._lines[name].points, points.astype(np.float32)):
                self._lines[name].points = points.astype(np.float32)
            return
        color, width = STYLES[name]
        self._lines[name] = self._scene.add_line_segments(
            f"/all/{name}", points, color if paint is None else paint, thickness=width
        )
