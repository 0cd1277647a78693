"""How plots look: colours that colour-blind readers tell apart, sizes, and what all share.

The colours are those of Okabe and Ito (2008); no two of a plot differ in red and green only.
"""

from __future__ import annotations

from contextlib import AbstractContextManager
from typing import Any

import matplotlib as mpl
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from swarm_common.model import palette
from swarm_common.model.grid import FREE, OCCUPIED, Grid
from swarm_common.model.palette import css

BLUE, ORANGE, GREEN, VERMILLION, SKY, PINK, YELLOW, BLACK = map(css, palette.HUES)
GREY = "#B8B8B8"
CYCLE = (BLUE, ORANGE, GREEN, VERMILLION, SKY, PINK, YELLOW, BLACK)
LINE_STYLES = ("-", "--", "-.", ":")
# By the state that a robot shows; in the order of the legend.
STATES = {state: css(color) for state, color in palette.STATES.items()}
LABELS = {"pausing": "pausing (service)", "idle": "idle (no goal)"}
GROUPS = {
    "world": BLUE, "navigators": ORANGE, "operator": GREEN, "recorder": PINK, "viewer": SKY,
}  # fmt: skip
SETTINGS = {
    "font.size": 9.0,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "grid.color": "#E6E6E6",
    "grid.linewidth": 0.6,
    "axes.axisbelow": True,
    "legend.frameon": False,
    "svg.fonttype": "path",
    "svg.hashsalt": "swarm",
    "figure.dpi": 100.0,
}
WIDTH, WIDE_WIDTH = 7.6, 15.2  # [in] half and all of the page


def settings() -> AbstractContextManager[None]:
    """Return a context within which plots look like ours."""
    wanted: Any = {**mpl.rcParamsDefault, **SETTINGS, "backend": "agg"}
    return mpl.rc_context(wanted)


def figure(height: float, width: float = WIDTH) -> Figure:
    """Return an empty figure; sizes in inches."""
    return Figure(figsize=(width, height), layout="constrained")


def plot(x: str, y: str, title: str = "", *, height: float) -> tuple[Figure, Axes]:
    """Return a figure with labelled axes; `height` is in inches."""
    drawing = figure(height)
    axes = drawing.add_subplot()
    axes.set(xlabel=x, ylabel=y)
    axes.set_title(title, loc="left")
    return drawing, axes


def legend_below(axes: Axes, columns: int = 2) -> None:
    """Draw the legend below the plot."""
    axes.legend(fontsize=8, ncols=columns, loc="upper left", bbox_to_anchor=(0.0, -0.18))


def map_axes(grid: Grid | None) -> tuple[Figure, Axes]:
    """Return a figure in metres of the map frame; walls are dark, unknown space is light grey."""
    aspect = grid.height / grid.width if grid is not None else 0.75
    drawing = figure(max(2.6, min(9.0, WIDTH * aspect * 0.88 + 0.5)), WIDTH)
    axes = drawing.add_subplot()
    if grid is not None:
        kind = (grid.cells == OCCUPIED) * 2 + (grid.cells == FREE) * 1
        shade = mpl.colors.ListedColormap(["#EDEDED", "#00000000", "#4D4D4D"])
        axes.imshow(
            kind, origin="lower", extent=extent(grid), cmap=shade, vmin=0, vmax=2,
            interpolation="nearest", zorder=2,
        )  # fmt: skip
    axes.set(aspect="equal", xlabel="x in map [m]", ylabel="y in map [m]")
    axes.grid(visible=False)
    return drawing, axes


def extent(grid: Grid) -> tuple[float, float, float, float]:
    """Return left, right, bottom, top [m] of a map."""
    right = grid.origin_x + grid.width * grid.resolution
    top = grid.origin_y + grid.height * grid.resolution
    return grid.origin_x, right, grid.origin_y, top
