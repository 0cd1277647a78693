"""Plots of what was done when: a bar per robot, and the use of the stations."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.collections import PolyCollection
from matplotlib.figure import Figure
from matplotlib.patches import Patch

from swarm_common.model.records import FloatArray
from swarm_report.measures import AT_STATION, station_use
from swarm_report.run import RunData, Span
from swarm_report.style import BLACK, BLUE, LABELS, ORANGE, STATES, WIDE_WIDTH, figure

TALLEST = 8.0  # [in] of all bars
BAR = 0.85  # height of a bar, of that of its row
VECTOR_LIMIT = 1500  # bars beyond which they are drawn as pixels, to keep the SVG small


def timeline(run: RunData) -> Figure | None:
    """Return a bar per robot, coloured by its state; None without a state log."""
    spans = run.spans
    if not spans:
        return None
    count = len(run.robots)
    drawing = figure(1.3 + min(max(1.2, 0.16 * count), TALLEST), WIDE_WIDTH)
    axes = drawing.add_subplot()
    for state in {span.state: None for span in spans}:
        bars = PolyCollection(  # one of all is far cheaper than a patch of each
            list(_outlines([span for span in spans if span.state == state])),
            facecolors=STATES.get(state, BLACK),
            linewidths=0.0,
            rasterized=len(spans) > VECTOR_LIMIT,
        )
        axes.add_collection(bars, autolim=False)
    failed = [event for event in run.goals if event.outcome == "failed"]
    if failed:
        times, rows = [event.time for event in failed], [event.robot + 1 for event in failed]
        axes.plot(times, rows, "X", color=BLACK, markersize=5, clip_on=False)
    shown = [state for state in STATES if any(span.state == state for span in spans)]
    handles = [Patch(color=STATES[state], label=LABELS.get(state, state)) for state in shown]
    axes.legend(handles=handles, ncols=8, loc="lower left", bbox_to_anchor=(0.0, 1.0))
    axes.set_ylim(count + 0.6, 0.4)
    axes.set_xlim(0.0, max(run.end, 1.0))
    step = 1 if count <= 25 else 5 if count <= 60 else 10
    axes.set_yticks([1, *range(step, count + 1, step)] if step > 1 else range(1, count + 1))
    axes.grid(visible=False, axis="y")
    axes.set(xlabel="simulated time [s]", ylabel="number of the robot")
    return drawing


def _outlines(spans: Sequence[Span]) -> FloatArray:
    """Return the corners (n, 4, 2) of bars in the rows of their robots."""
    start = np.array([span.start for span in spans])
    end = np.array([span.end for span in spans])
    row = np.array([span.robot + 1.0 for span in spans])
    low, high = row - 0.5 * BAR, row + 0.5 * BAR
    x = np.stack([start, end, end, start], axis=1)
    return np.stack([x, np.stack([low, low, high, high], axis=1)], axis=2)


def stations(run: RunData) -> Figure | None:
    """Return how busy each station was, and how many robots waited for it."""
    uses = station_use(run)
    if not uses or run.series is None:
        return None
    drawing = figure(1.2 + 0.32 * len(uses))
    left, right = drawing.subplots(1, 2, sharey=True)
    rows = np.arange(len(uses))
    busy = [100.0 * (use.utilisation or 0.0) for use in uses.values()]
    bars = left.barh(rows, busy, color=BLUE, height=0.7)
    left.bar_label(bars, [f"{use.goals} goals" for use in uses.values()], padding=3, fontsize=7)
    left.set_xlim(0.0, 118.0)
    left.set_xticks(range(0, 101, 25))
    left.set_xlabel(f"time with a robot within {AT_STATION:g} m [%]")
    left.set_yticks(rows, list(uses))
    left.invert_yaxis()
    left.set_title("Use of the stations", loc="left")
    queued = [use.queue for use in uses.values()]
    right.barh(rows, queued, color=ORANGE, height=0.7)
    right.set_xlim(0.0, max(0.1, 1.1 * max(queued)))
    right.set_xlabel("robots in its queue or holding for it, on average")
    for axes in (left, right):
        axes.grid(visible=False, axis="y")
    return drawing
