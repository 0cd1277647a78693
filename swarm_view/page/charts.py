"""Curves of the run on one page: goals per minute, robots by state, smallest clearance."""

from __future__ import annotations

from typing import Any

import numpy as np
import viser
from viser import uplot

from swarm_common.model.palette import BLUE, GREEN, STATES, css
from swarm_common.model.records import FloatArray
from swarm_view.state.history import History

HEIGHT = 150  # [px]
PERIOD = 5.0  # [s] of wall time between two drawings
GREY = "#888888"  # of axes, on light and dark ground
NONE = np.zeros(1)


class Charts:
    """A tab for each curve, beside the time line."""

    def __init__(self, client: Any, panel: Any) -> None:
        gui, self._due, self._seen = client.gui, 0.0, (-1, 0.0)
        with panel.add_tab("Throughput", viser.Icon.CHART_LINE):
            self._rate = _plot(gui, [("goals per minute", css(GREEN))], "goals per minute")
        with panel.add_tab("States", viser.Icon.CHART_AREA_LINE):
            series = [(state, css(color)) for state, color in STATES.items()]
            self._states = _plot(gui, series, "robots")
        with panel.add_tab("Clearance", viser.Icon.RULER_MEASURE):
            label = "smallest clearance so far [m]"
            self._clearance = _plot(gui, [(label, css(BLUE))], "clearance [m]")

    def update(self, history: History, now: float) -> None:
        """Show what has happened; `now` is wall time."""
        seen = history.revision, history.span[1]
        if now < self._due or seen == self._seen:
            return
        self._due, self._seen = now + PERIOD, seen
        times, rates = history.throughput()
        _fill(self._rate, times, rates[None])
        _fill(self._states, *history.states(list(STATES)))
        times, gaps = history.clearance()
        _fill(self._clearance, times, gaps[None])


def _fill(plot: Any, times: FloatArray, values: FloatArray) -> None:
    if len(times):
        plot.data = (times, *values)


def _plot(gui: Any, curves: list[tuple[str, str]], label: str) -> Any:
    lines = [uplot.Series(label=name, stroke=color, width=2) for name, color in curves]
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
