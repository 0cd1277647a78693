"""Plots over the map: trajectories, and heat maps of presence and of waiting."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from swarm_common.model.records import FloatArray
from swarm_report.measures import IDLE, LOST
from swarm_report.run import RunData, Series
from swarm_report.style import extent

FEW = 8  # robots that a colour each can tell apart
WIDE = 20.0  # from this ratio of largest to smallest on, the scale is logarithmic
PALEST = 0.2  # of a colour scale: paler colours do not stand out from white paper
CELL = 0.25  # [m] of the heat maps


@dataclass(frozen=True, slots=True)
class Heat:
    """Robot-seconds per square metre on a grid of the map."""

    values: FloatArray  # (width, height) of cells, x first
    extent: tuple[float, float, float, float]  # left, right, bottom, top [m]

    @property
    def steps(self) -> tuple[float, float]:
        """Width and height of a cell [m]."""
        left, right, bottom, top = self.extent
        return (right - left) / self.values.shape[0], (top - bottom) / self.values.shape[1]


def presence_heat(run: RunData) -> Heat | None:
    """Return where the robots spent their time; None without a time series."""
    series = run.series
    if series is None or len(series.times) < 2:
        return None
    is_busy = run.states_at(series.times) != IDLE  # a robot at home says nothing about the traffic
    return _heat(run, series, is_busy * _seconds_per_sample(series)[:, None])


def waiting_heat(run: RunData) -> Heat | None:
    """Return where robots lost time; None if that is not known."""
    series = run.series
    if series is None or len(series.times) < 2 or not run.spans:
        return None
    is_lost = np.isin(run.states_at(series.times), LOST)
    return _heat(run, series, is_lost * _seconds_per_sample(series)[:, None])


def _seconds_per_sample(series: Series) -> FloatArray:
    steps = np.diff(series.times)
    return np.append(steps, steps[-1])


def _heat(run: RunData, series: Series, weights: FloatArray) -> Heat:
    x, y = series.poses[..., 0].ravel(), series.poses[..., 1].ravel()
    there = np.isfinite(x) & np.isfinite(y)
    x, y = x[there], y[there]
    left, right, bottom, top = (
        extent(run.grid)
        if run.grid is not None
        else (x.min() - 1.0, x.max() + 1.0, y.min() - 1.0, y.max() + 1.0)
    )
    edges = [
        np.linspace(low, high, max(2, round((high - low) / CELL)) + 1)
        for low, high in ((left, right), (bottom, top))
    ]
    heat, *_ = np.histogram2d(x, y, bins=edges, weights=weights.ravel()[there])
    return Heat(heat / CELL**2, (left, right, bottom, top))
