"""Plots over the map: trajectories, and heat maps of presence and of waiting."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import PolyCollection
from matplotlib.colors import ListedColormap, LogNorm, Normalize
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from swarm_common.model.records import FloatArray
from swarm_common.model.zones import keepout_area, speed_area, triangles
from swarm_report.measures import IDLE, LOST
from swarm_report.run import RunData, Series
from swarm_report.style import (
    BLACK,
    CYCLE,
    LINE_STYLES,
    ORANGE,
    VERMILLION,
    YELLOW,
    extent,
    map_axes,
)

FEW = 8  # robots that a colour each can tell apart
WIDE = 20.0  # from this ratio of largest to smallest on, the scale is logarithmic
PALEST = 0.2  # of a colour scale: paler colours do not stand out from white paper
CELL = 0.25  # [m] of the heat maps


def trajectories(run: RunData) -> Figure | None:
    """Return where each robot drove; None without a time series."""
    series = run.series
    if series is None or len(series.times) < 2:
        return None
    drawing, axes = map_axes(run.grid)
    _draw_lines(axes, run, series)
    _draw_stations(axes, run)
    _draw_zones(axes, run)
    _draw_crashes(axes, run)
    if len(run.robots) > FEW:
        scale = mpl.cm.ScalarMappable(mpl.colors.Normalize(1, len(run.robots)), "viridis")
        bar = drawing.colorbar(scale, ax=axes, label="number of the robot", shrink=0.7)
        bar.locator = MaxNLocator(integer=True)
    axes.set_title("True trajectories (one position a second)", loc="left")
    axes.legend(loc="upper left", bbox_to_anchor=(0.0, -0.1), ncols=4, fontsize=8)
    return drawing


def _draw_lines(axes: Axes, run: RunData, series: Series) -> None:
    count = len(run.robots)
    colors = mpl.colormaps["viridis"](np.linspace(0.0, 1.0, max(count, 2)))
    few = count <= FEW
    width, alpha = (1.3, 0.9) if few else (0.7, 0.6)
    look: dict[str, Any] = {"linewidth": width, "alpha": alpha, "rasterized": not few}
    for robot, name in enumerate(run.robots):
        x, y = series.poses[:, robot, 0], series.poses[:, robot, 1]
        color = CYCLE[robot % len(CYCLE)] if few else colors[robot]
        style = LINE_STYLES[robot % len(LINE_STYLES)] if few else "-"
        label = name if few else None
        axes.plot(x, y, style, color=color, label=label, zorder=3, **look)
    shown = CYCLE[:count] if few else colors
    rim: dict[str, Any] = {"edgecolors": BLACK, "linewidths": 0.4, "zorder": 4}
    for sample, marker, label in ((0, "^", "start"), (-1, "o", "end")):
        x, y = series.poses[sample, :, :2].T
        axes.scatter(x, y, s=16, c=shown, marker=marker, label=label, **rim)


def _draw_stations(axes: Axes, run: RunData) -> None:
    for name, pose in run.sites.stations.items():
        axes.plot(pose.x, pose.y, "s", color="none", markeredgecolor=BLACK, markersize=6, zorder=5)
        axes.annotate(
            name, (pose.x, pose.y), xytext=(5, 5), textcoords="offset points", fontsize=7, zorder=6
        )


def _draw_zones(axes: Axes, run: RunData) -> None:
    zones = run.sites.zones
    if not zones:
        return
    areas = ((keepout_area, VERMILLION, "keepout zone"), (speed_area, YELLOW, "speed limit"))
    for area_of, color, label in areas:
        if corners := triangles(area_of(zones)):
            pieces = np.array(corners).reshape(-1, 3, 2)
            axes.add_collection(
                PolyCollection(list(pieces), facecolors=color, alpha=0.35, label=label, zorder=2)
            )


def _draw_crashes(axes: Axes, run: RunData) -> None:
    crashes = run.report.get("breaches", {}).get("collisions", [])
    if crashes:
        axes.scatter(
            [crash["x"] for crash in crashes], [crash["y"] for crash in crashes],
            marker="X", s=70, c=VERMILLION, edgecolors=BLACK, linewidths=0.6, zorder=7,
            label=f"collision ({len(crashes)})",
        )  # fmt: skip


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


def density(run: RunData) -> Figure | None:
    """Draw where the robots spent their time; None without a time series."""
    heat = presence_heat(run)
    return None if heat is None else _draw_heat(run, heat, "Presence of robots", "YlGnBu")


def waiting(run: RunData) -> Figure | None:
    """Draw where robots lost time; return None if that is not known."""
    heat = waiting_heat(run)
    title = "Time lost"
    return None if heat is None else _draw_heat(run, heat, title, "YlOrRd")


def _seconds_per_sample(series: Series) -> FloatArray:
    """Return how much time (T,) [s] each sample stands for."""
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


def _draw_heat(run: RunData, heat: Heat, title: str, colors: str) -> Figure:
    """Return a map of seconds per square metre."""
    drawing, axes = map_axes(run.grid)
    axes.set_title(title, loc="left")
    values = heat.values
    if values.max() <= 0.0:
        axes.text(0.5, 0.5, "nowhere", transform=axes.transAxes, ha="center", zorder=8)
        return drawing
    low = values[values > 0.0].min()
    is_wide = values.max() > WIDE * low
    image = axes.imshow(
        np.ma.masked_less_equal(values.T, 0.0),
        origin="lower",
        extent=heat.extent,
        cmap=ListedColormap(mpl.colormaps[colors](np.linspace(PALEST, 1.0, 256))),
        norm=LogNorm(low, values.max()) if is_wide else Normalize(0.0, values.max()),
        interpolation="nearest",
        zorder=1,
    )
    label = f"robot-seconds per m² (cells of {CELL:g} m)"
    drawing.colorbar(image, ax=axes, label=label, shrink=0.8)
    for pose in run.sites.stations.values():
        axes.plot(pose.x, pose.y, "s", color="none", markeredgecolor=ORANGE, markersize=5, zorder=5)
    return drawing
