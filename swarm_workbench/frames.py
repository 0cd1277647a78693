"""Pictures of environments: the map, robots, goals and people, seen from above."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageDraw

from swarm_common.model.errors import SwarmError
from swarm_common.model.grid import Grid
from swarm_common.model.records import FloatArray, RobotSpec

LONGER_EDGE = 640  # [px]
COLOURS = ("#1f77b4", "#ff7f0e", "#2ca02c", "#d62728", "#9467bd", "#8c564b", "#e377c2", "#17becf")
PERSON = "#444444"
FREE, UNKNOWN, WALL = 255, 217, 77
Frame = NDArray[np.uint8]


class Painter:
    """Paints one frame after the other on a map."""

    def __init__(self, grid: Grid, spec: RobotSpec) -> None:
        """Paint the map, which all frames share."""
        shade = np.select([grid.cells == 0, grid.cells < 0], [FREE, UNKNOWN], WALL)
        self._scale = LONGER_EDGE / max(shade.shape)
        height, width = (round(size * self._scale) for size in shade.shape)
        plan = Image.fromarray(shade.astype(np.uint8)[::-1]).resize((width, height))
        self._plan = plan.convert("RGB")
        self._scale /= grid.resolution
        self._left, self._top = grid.origin_x, grid.origin_y + height / self._scale
        self._outline = np.array(spec.footprint)

    def paint(self, poses: FloatArray, goals: FloatArray, people: FloatArray) -> Frame:
        """Return a frame (h, w, 3).

        Args:
            poses: (n, 3) x, y, yaw of the robots in map.
            goals: (n, 2) [m] in map.
            people: (k, 3) x, y, radius [m] in map.
        """
        image = self._plan.copy()
        draw = ImageDraw.Draw(image)
        for x, y, radius in people.tolist():
            self._circle(draw, (x, y), radius, fill=PERSON)
        for index, (x, y, yaw) in enumerate(poses.tolist()):
            colour = COLOURS[index % len(COLOURS)]
            cos, sin = np.cos(yaw), np.sin(yaw)
            corners = self._outline @ np.array([[cos, sin], [-sin, cos]]) + (x, y)
            draw.polygon([self._pixel(corner) for corner in corners.tolist()], fill=colour)
            draw.line([self._pixel((x, y)), self._pixel((x + 0.2 * cos, y + 0.2 * sin))], "white")
            self._circle(draw, goals[index].tolist(), 0.12, outline=colour, width=2)
        return np.asarray(image)

    def _circle(self, draw: Any, centre: Any, radius: float, **colours: Any) -> None:
        x, y = self._pixel(centre)
        size = radius * self._scale
        draw.ellipse((x - size, y - size, x + size, y + size), **colours)

    def _pixel(self, point: Any) -> tuple[float, float]:
        return (point[0] - self._left) * self._scale, (self._top - point[1]) * self._scale


class PlanWindow:
    """Shows frames on the screen, by matplotlib."""

    def __init__(self) -> None:
        self._image: Any = None

    def show(self, frame: Frame) -> None:
        """Show a frame.

        Raises:
            SwarmError: If there is no screen.
        """
        import matplotlib
        from matplotlib import pyplot

        if matplotlib.get_backend().lower() == "agg":
            raise SwarmError("render_mode 'human' needs a screen; take 'rgb_array' for pictures")
        if self._image is None:
            axes = pyplot.subplots()[1]
            axes.set_axis_off()
            self._image = axes.imshow(frame)
            pyplot.show(block=False)
        self._image.set_data(frame)
        self._image.figure.canvas.draw_idle()
        self._image.figure.canvas.flush_events()

    def close(self) -> None:
        """Close it."""
        if self._image is not None:
            from matplotlib import pyplot

            pyplot.close(self._image.figure)
            self._image = None
