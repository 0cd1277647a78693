"""How plots look: colours that colour-blind readers tell apart, sizes, and what all share.

The colours are those of Okabe and Ito (2008); no two of a plot differ in red and green only.
"""

from __future__ import annotations

from contextlib import AbstractContextManager
from typing import Any

import matplotlib as mpl

from swarm_common.model import palette
from swarm_common.model.grid import Grid
from swarm_common.model.palette import css

BLUE, ORANGE, GREEN, VERMILLION, SKY, PINK, YELLOW, BLACK = map(css, palette.HUES)
GREY = "#B8B8B8"
CYCLE = (BLUE, ORANGE, GREEN, VERMILLION, SKY, PINK, YELLOW, BLACK)
# By the state that a robot shows; in the order of the legend.
STATES = {state: css(color) for state, color in palette.STATES.items()}
LABELS = {"pausing": "pausing (service)", "idle": "idle (no goal)"}
GROUPS = {"world": BLUE, "navigators": ORANGE, "operator": GREEN, "recorder": PINK, "viewer": SKY}
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


def extent(grid: Grid) -> tuple[float, float, float, float]:
    """Return left, right, bottom, top [m] of a map."""
    right = grid.origin_x + grid.width * grid.resolution
    top = grid.origin_y + grid.height * grid.resolution
    return grid.origin_x, right, grid.origin_y, top
