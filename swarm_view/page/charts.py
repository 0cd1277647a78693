"""Curves of the run on one page: lanes, goals per minute, robots by state, clearance, speed."""

from __future__ import annotations

import html
from typing import Any

import numpy as np
import viser
from viser import uplot

from swarm_common.model.palette import BLUE, GREEN, STATES, css, state_color
from swarm_common.model.records import FloatArray
from swarm_view.state.history import History

HEIGHT = 150  # [px]
LANE = 12  # [px] of a robot's bar
COLUMNS = 400  # shorter parts of a bar are left out
PERIOD = 5.0  # [s] of wall time between two drawings
GREY = "#888888"  # of axes, on light and dark ground
NONE = np.zeros(1)


class Charts:
    """A tab for each curve, beside the time line."""

    def __init__(self, client: Any, panel: Any) -> None:
        gui, self._due, self._seen = client.gui, 0.0, (-1, 0.0)
        with panel.add_tab("Robots", viser.Icon.TIMELINE):
            self._lanes = gui.add_html("")
        with panel.add_tab("Throughput", viser.Icon.CHART_LINE):
            self._rate = _plot(gui, [("goals per minute", css(GREEN))], "goals per minute")
        with panel.add_tab("States", viser.Icon.CHART_AREA_LINE):
            series = [(state, css(color)) for state, color in reversed(STATES.items())]
            self._states = _plot(gui, series, "robots", is_filled=True)
        with panel.add_tab("Clearance", viser.Icon.RULER_MEASURE):
            label = "smallest clearance so far [m]"
            self._clearance = _plot(gui, [(label, css(BLUE))], "clearance [m]")
        with panel.add_tab("Speed", viser.Icon.GAUGE):
            self._speed = _plot(gui, [("real-time factor", css(BLUE))], "times real time")

    def update(self, history: History, now: float) -> None:
        """Show what has happened; `now` is wall time."""
        seen = history.revision, history.span[1]
        if now < self._due or seen == self._seen:
            return
        self._due, self._seen = now + PERIOD, seen
        times, rates = history.throughput()
        _fill(self._rate, times, rates[None])
        times, counts = history.states(list(STATES))
        _fill(self._states, times, np.cumsum(counts, axis=0)[::-1])  # the largest area lies below
        self._lanes.content = lanes_html(history)
        times, factors = history.factors()
        _fill(self._speed, times, factors[None])
        times, gaps = history.clearance()
        _fill(self._clearance, times, gaps[None])


def _fill(plot: Any, times: FloatArray, values: FloatArray) -> None:
    if len(times):
        plot.data = (times, *values)


def lanes_html(history: History) -> str:
    """Return a bar for each robot in the colours of its states; a click goes to that time."""
    start, end = history.span
    length = max(1.0, end - start)
    lanes = history.lanes(length / COLUMNS)
    rows = []
    for robot, spans in lanes.items():
        paths: dict[str, str] = {}
        for since, until, state in spans:
            left, wide = 1000.0 * (since - start) / length, 1000.0 * (until - since) / length
            paths[state] = f"{paths.get(state, '')}M{left:.1f} 5h{wide:.1f}"
        bars = "".join(
            f"<path d='{path}' stroke='{css(state_color(state))}' stroke-width='10'/>"
            for state, path in paths.items()
        )
        rows.append(
            f"<div style='display:flex;align-items:center;height:{LANE}px'>"
            f"<span style='width:5.5em;overflow:hidden;font-size:0.72rem;line-height:{LANE}px'>"
            f"{html.escape(robot)}</span>"
            f"<div data-swarm-line data-start='{start:.2f}' data-end='{start + length:.2f}'"
            f" style='flex:1;height:{LANE - 2}px;cursor:pointer'><svg viewBox='0 0 1000 10'"
            f" preserveAspectRatio='none' width='100%' height='{LANE - 2}'>{bars}</svg></div></div>"
        )
    return f"<div style='max-height:{HEIGHT}px;overflow:auto;padding:0 0.8em'>{''.join(rows)}</div>"


def _plot(gui: Any, curves: list[tuple[str, str]], label: str, *, is_filled: bool = False) -> Any:
    lines = [
        uplot.Series(label=name, stroke=color, width=0 if is_filled else 2)
        | ({"fill": color} if is_filled else {})
        for name, color in curves
    ]
    axes = tuple(
        uplot.Axis(
            label=text, stroke=GREY, labelSize=18, size=34, font="11px sans-serif",
            labelFont="11px sans-serif", grid=uplot.Axis_Grid(stroke="#88888833", width=1),
        )
        for text in ("simulated time [s]", label)
    )  # fmt: skip
    return gui.add_uplot(
        data=(NONE, *(NONE for _ in curves)),
        series=(uplot.Series(label="time [s]"), *lines),
        scales={"x": uplot.Scale(time=False)},
        axes=axes,
        height=HEIGHT,
    )
