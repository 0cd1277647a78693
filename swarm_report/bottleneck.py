"""Where robots lost most time to each other, in words; nothing where nothing stands out.

Every second that robots spent holding or waiting is put down to a station (they held for it, or
waited close to it) or else to the place where they waited. One of them is called the bottleneck if
its part of all these seconds is large, and clearly larger than that of the next.
"""

from __future__ import annotations

from collections import defaultdict
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.spatial import cKDTree

from swarm_common.model.records import FloatArray
from swarm_report.measures import HOLDING, LostTime, lost_time, station_use
from swarm_report.run import RunData
from swarm_report.tables import percent

NEAR = 1.5  # [m] within which waiting is put down to a station, or to one place
CELL = 0.25  # [m] to which places are rounded
LEAST_LOSS = 0.02  # share of the robots' time below which nobody looks for a reason
LEAST_SHARE = 0.25  # of all holding and waiting, for a bottleneck
MOST_NAMED = 3  # stations and places, where none stands out
LEAST_LEAD = 1.5  # times the next one's seconds


@dataclass(frozen=True, slots=True)
class Bottleneck:
    """The station or place to which most of the lost time is put down."""

    station: str  # its name; empty for a place
    x: float  # [m] of the station or place in map
    y: float  # [m] likewise
    seconds: float  # holding for it and waiting near it, summed over the robots
    lost: LostTime  # all holding and waiting
    utilisation: float | None = None  # of the station; None for a place, or if unknown

    @property
    def words(self) -> str:
        """The finding in words."""
        where = f"{self.station} at " if self.station else "The floor around "
        total = self.lost.seconds
        x, y = (round(value, 1) + 0.0 for value in (self.x, self.y))  # no -0.0
        line = (
            f"{where}({x:.1f}, {y:.1f}) is the bottleneck: "
            f"{100.0 * self.seconds / total:.0f} % of all holding and waiting"
            f" ({self.seconds:.0f} of {total:.0f} robot-seconds) was"
            f" {'for it or ' if self.station else ''}within {NEAR:g} m of it"
        )
        if self.utilisation is not None:
            line += f"; a robot was there {100.0 * self.utilisation:.0f} % of the time"
        return f"{line}. Holding and waiting took {percent(self.lost.share)} of the robots' time."

    def as_json(self) -> dict[str, Any]:
        """Return it for report.json."""
        return {
            "station": self.station or None,
            "x": round(self.x, 3),
            "y": round(self.y, 3),
            "seconds": round(self.seconds, 1),
            "share": round(self.seconds / self.lost.seconds, 4),
            "words": self.words,
        }


def find_bottleneck(run: RunData) -> Bottleneck | None:
    """Return the bottleneck; None if nothing stands out, or waits were not recorded."""
    found = _candidates(run)
    if not found or found[0].seconds < LEAST_SHARE * found[0].lost.seconds:
        return None
    if len(found) > 1 and found[0].seconds < LEAST_LEAD * found[1].seconds:
        return None
    return found[0]


def lost_words(run: RunData) -> str:
    """Return where most time was lost; empty if little was, or if waits were not recorded."""
    one, found = find_bottleneck(run), _candidates(run)
    if one is not None or not found:
        return "" if one is None else one.words
    total, share = found[0].lost.seconds, found[0].lost.share
    most = ", ".join(
        f"{place.station or f'the floor around ({place.x:.1f}, {place.y:.1f})'}"
        f" {100.0 * place.seconds / total:.0f} %"
        for place in found[:MOST_NAMED]
    )
    return (
        f"Holding and waiting took {percent(share)} of the robots' time. No single station or"
        f" place is the bottleneck; most of it was at {most}."
    )


def _candidates(run: RunData) -> list[Bottleneck]:
    """Return stations and places by the time lost to them, most first; none if little was lost."""
    lost = lost_time(run)
    if lost is None or lost.share < LEAST_LOSS:
        return []
    by_station, stray = _lost_seconds(run)
    found: list[Bottleneck] = []
    uses = station_use(run)
    for name, seconds in by_station.items():
        pose = run.sites.stations.get(name)
        if pose is not None:
            use = uses[name].utilisation if name in uses else None
            found.append(Bottleneck(name, pose.x, pose.y, seconds, lost, use))
    found += [
        Bottleneck("", float(x), float(y), float(seconds), lost) for x, y, seconds in _places(stray)
    ]
    return sorted(found, key=lambda one: -one.seconds)


def _lost_seconds(run: RunData) -> tuple[dict[str, float], FloatArray]:
    """Return the seconds by station, and those elsewhere as rows of x, y [m], seconds."""
    by_station: dict[str, float] = defaultdict(float)
    for span in run.spans:
        if span.state == HOLDING:
            by_station[span.station] += span.length
    places, series = run.sites.stations, run.series
    if series is None:
        return by_station, np.zeros((0, 3))
    names = list(places)
    spots = np.array([[places[name].x, places[name].y] for name in names]).reshape(-1, 2)
    stray = []
    for wait in run.waits:
        sample = min(int(np.searchsorted(series.times, wait.time)), len(series.times) - 1)
        here = series.poses[sample, wait.robot, :2]
        if not np.isfinite(here).all():
            continue
        apart = np.hypot(*(spots - here).T)
        if apart.size and apart.min() <= NEAR:
            by_station[names[int(apart.argmin())]] += wait.duration
        else:
            stray.append((*here, wait.duration))
    return by_station, np.array(stray, float).reshape(-1, 3)


def _places(stray: FloatArray) -> list[tuple[float, float, float]]:
    """Return the two circles of radius `NEAR` with most waiting: x, y [m], seconds of each.

    A circle's centre is a cell in which somebody waited; the second takes what the first has left.
    """
    cells, index = np.unique(np.round(stray[:, :2] / CELL), axis=0, return_inverse=True)
    spots = CELL * cells
    seconds = np.bincount(index.ravel(), stray[:, 2], minlength=len(spots))
    found: list[tuple[float, float, float]] = []
    while len(spots) and len(found) < 2:
        around = cKDTree(spots).query_ball_point(spots, NEAR)
        sums = [float(seconds[near].sum()) for near in around]
        members = around[int(np.argmax(sums))]
        x, y = np.average(spots[members], axis=0, weights=seconds[members])
        found.append((float(x), float(y), max(sums)))
        spots, seconds = np.delete(spots, members, axis=0), np.delete(seconds, members)
    return found
