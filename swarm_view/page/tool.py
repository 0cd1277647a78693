"""RViz's tools on one page: a place on the floor, clicked, or dragged; and a ruler."""

from __future__ import annotations

import json
import math
from collections.abc import Callable
from enum import Enum
from typing import Any

import numpy as np

from swarm_common.model.palette import GOAL, PINK
from swarm_common.model.records import FloatArray
from swarm_view.scene.shapes import floor, lifted, on_floor
from swarm_view.scene.viser_compat import run_script
from swarm_view.state.decode import Raster

DRAG_LENGTH = 0.15  # [m] from which a drag gives a heading
ARROW_HEIGHT = 0.08  # [m]
RULER_HEIGHT, RULER_WIDTH = 0.05, 0.04  # [m]
Post = Callable[[Callable[[], None]], None]


class Tool(Enum):
    """Tool that the reader uses; the value is its name on the panel."""

    SELECT = "Select"
    GOAL = "Goal"
    INITIAL_POSE = "Initial pose"
    SPAWN = "Spawn"
    MEASURE = "Measure"
    MOVE = "Move"


BUTTONS = {tool: tool.value for tool in Tool} | {Tool.SPAWN: "Spawn by a click"}  # their labels
ORDERS = (Tool.GOAL, Tool.INITIAL_POSE)  # of a robot


# Called with the tool, the place (2,) in map and the tip (2,) of the arrow drawn there, if any.
Use = Callable[[Tool, FloatArray, FloatArray | None], None]


class Hand:
    """The selected tool of one page, and the floor that it points at. Runs on the main thread."""

    def __init__(self, client: Any, use: Use, post: Post) -> None:
        """Begin without a tool; `post` brings a call to the main thread.

        `use` is called with a tool that was used and has been dropped.
        """
        self.tool = Tool.SELECT
        self._client = client
        self._scene = client.scene
        self._use = use
        self._post = post
        self._floor: Any = None
        self._arrow: Any = None

    def take(self, tool: Tool, raster: Raster) -> None:
        """Select a tool that is used on the floor of a map."""
        self.drop()
        self.tool = tool
        self._show()
        (x, y), (width, depth) = raster.origin, raster.size
        vertices, faces = floor(x, y, x + width, y + depth)
        self._floor = self._scene.add_mesh_simple(
            "/tool/floor", vertices, faces, color=GOAL, opacity=0.06, position=(0.0, 0.0, 0.001),
            side="double", cast_shadow=False, receive_shadow=False,
        )  # fmt: skip
        self._floor.on_drag("left")(self._on_drag)

    def drop(self) -> None:
        """Go back to selecting."""
        self.tool = Tool.SELECT
        for node in (self._floor, self._arrow):
            if node is not None:
                node.remove()
        self._floor = self._arrow = None
        self._show()

    def _show(self) -> None:
        label = "" if self.tool is Tool.SELECT else BUTTONS[self.tool]
        run_script(self._client, f"window.swarm.press({json.dumps(label)})")

    def click(self, origin: FloatArray, direction: FloatArray) -> None:
        """Use the tool where a ray meets the floor."""
        point = on_floor(origin, direction)
        if point is not None:
            self._apply(point, None)

    def _on_drag(self, event: Any) -> None:
        """A drag on the floor; on viser's threads."""
        eye = np.array(event.client.camera.position)
        start = np.array(event.start_position)[:2]
        tip = on_floor(eye, np.array(event.end_position) - eye)
        if tip is None:
            return
        if event.phase == "end":
            self._post(lambda: self._apply(start, tip))
        else:
            self._post(lambda: self._draw_arrow(start, tip))

    def _draw_arrow(self, start: FloatArray, tip: FloatArray) -> None:
        if self._floor is not None and heading(start, tip) is not None:
            self._arrow = self._scene.add_arrows(
                "/tool/arrow",
                lifted(np.array([start, tip]), ARROW_HEIGHT)[None],
                GOAL,
                shaft_radius=0.03,
                head_radius=0.08,
                head_length=0.14,
            )

    def _apply(self, point: FloatArray, tip: FloatArray | None) -> None:
        tool = self.tool
        if tool is not Tool.SELECT:
            self.drop()
            self._use(tool, point, tip)


def heading(start: FloatArray, tip: FloatArray) -> float | None:
    """Return the yaw of a drag (2,) to (2,) in map; None if it is too short to say."""
    along = tip - start
    if np.hypot(*along) <= DRAG_LENGTH:
        return None
    return math.atan2(along[1], along[0])


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
        """Mark a place (2,) in map; return the distance [m] from the one before, if there is one.

        The place after that begins another measurement.
        """
        if self._start is not None:
            return self.measure(self._start, place)
        self.clear()
        self._start = place
        ball = self._scene.add_icosphere(
            "/ruler/start", radius=RULER_WIDTH, color=PINK, position=(*place, RULER_HEIGHT)
        )
        self._drawn.append(ball)
        return None

    def measure(self, start: FloatArray, end: FloatArray) -> float:
        """Draw the distance between two places (2,) in map, and return it [m]."""
        self.clear()
        distance = math.dist(start, end)
        points = lifted(np.array([start, end]), RULER_HEIGHT)
        self._drawn = [
            self._scene.add_line_segments("/ruler/line", points[None], PINK, thickness=RULER_WIDTH),
            self._scene.add_label(
                "/ruler/label",
                f"{distance:.2f} m",
                position=points.mean(axis=0),
                anchor="bottom-center",
            ),
        ]
        return distance
