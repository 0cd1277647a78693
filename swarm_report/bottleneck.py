"""Where robots lost most time to each other, in words; nothing where nothing stands out.

Every second that robots lost (`LOST`) is put down to a station (they held for it, or stopped close
to it) or else to the place where they were. One of them is called the bottleneck if its part of all
these seconds is large, and clearly larger than that of the next.
"""

from __future__ import annotations

from collections import defaultdict
from dataclasses import dataclass
from typing import Any

import numpy as np

from swarm_common.model.records import FloatArray
from swarm_report.measures import HOLDING, LOST_WORDS, LostTime, lost_spans, lost_time, station_use
from swarm_report.run import RunData, Span
from swarm_report.tables import percent

NEAR = 1.5  # [m] within which waiting is put down to a station, or to one place
CELL = 0.25  # [m] to which places are rounded
LEAST_LOSS = 0.02  # share of the robots' time below which nobody looks for a reason
LEAST_SHARE = 0.25  # of all lost time, for a bottleneck
MOST_NAMED = 3  # stations and places, where none stands out
LEAST_LEAD = 1.5  # times the next one's seconds


@dataclass(frozen=True, slots=True)
class Bottleneck:
    """The station or place to which most of the lost time is put down."""

    station: str  # its name; empty for a place
    x: float  # [m] of the station or place in map
    y: float  # [m] likewise
    seconds: float  # lost for it and near it, summed over the robots
    lost: LostTime  # all of it
    utilisation: float | None = None  # of the station; None for a place, or if unknown
    time: float = 0.0  # [s] when the longest part of it began

    @property
    def name(self) -> str:
        """The station, or the place in words."""
        x, y = (round(value, 1) + 0.0 for value in (self.x, self.y))  # no -0.0
        return self.station or f"({x:.1f}, {y:.1f})"

    @property
    def words(self) -> str:
        """The finding in words."""
        where = f"{self.station} at " if self.station else "The floor around "
        total = self.lost.seconds
        x, y = (round(value, 1) + 0.0 for value in (self.x, self.y))  # no -0.0
        line = (
            f"{where}({x:.1f}, {y:.1f}) is the bottleneck: "
            f"{100.0 * self.seconds / total:.0f} % of all lost time"
            f" ({self.seconds:.0f} of {total:.0f} robot-seconds) was"
            f" {'for it or ' if self.station else ''}within {NEAR:g} m of it"
        )
        if self.utilisation is not None:
            line += f"; a robot was there {100.0 * self.utilisation:.0f} % of the time"
        return f"{line}. {_share(self.lost)}"

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
    found = worst_places(run)
    if not found or found[0].seconds < LEAST_SHARE * found[0].lost.seconds:
        return None
    if len(found) > 1 and found[0].seconds < LEAST_LEAD * found[1].seconds:
        return None
    return found[0]


def lost_words(run: RunData) -> str:
    """Return where most time was lost; empty if little was, or if waits were not recorded."""
    one, found = find_bottleneck(run), worst_places(run)
    if one is not None or not found:
        return "" if one is None else one.words
    total = found[0].lost.seconds
    most = ", ".join(
        f"{place.station or f'the floor around ({place.x:.1f}, {place.y:.1f})'}"
        f" {100.0 * place.seconds / total:.0f} %"
        for place in found[:MOST_NAMED]
    )
    return (
        f"{_share(found[0].lost)} No single station or"
        f" place is the bottleneck; most of it was at {most}."
    )


def _share(lost: LostTime) -> str:
    words = f"{LOST_WORDS[0].upper()}{LOST_WORDS[1:]}"
    return f"{words} took {percent(lost.share)} of the robots' time."


def worst_places(run: RunData) -> list[Bottleneck]:
    """Return stations and places by the time lost to them, most first; none if little was lost."""
    lost = lost_time(run)
    if lost is None or lost.share < LEAST_LOSS:
        return []
    by_station, stray = _lost_seconds(run)
    found: list[Bottleneck] = []
    uses = station_use(run)
    for name, parts in by_station.items():
        pose = run.sites.stations.get(name)
        if pose is not None:
            use = uses[name].utilisation if name in uses else None
            longest = max(parts, key=lambda span: span.length)
            seconds = sum(span.length for span in parts)
            found.append(Bottleneck(name, pose.x, pose.y, seconds, lost, use, longest.start))
    found += [
        Bottleneck("", float(x), float(y), float(seconds), lost) for x, y, seconds in _places(stray)
    ]
    return sorted(found, key=lambda one: -one.seconds)


def _lost_seconds(run: RunData) -> tuple[dict[str, list[Span]], FloatArray]:
    """Return the lost spans by station, and the others as rows of x, y [m], seconds."""
    by_station: dict[str, list[Span]] = defaultdict(list)
    places, series = run.sites.stations, run.series
    names = list(places)
    spots = np.array([[places[name].x, places[name].y] for name in names]).reshape(-1, 2)
    stray = []
    for span in lost_spans(run):
        if span.state == HOLDING:
            by_station[span.station].append(span)
        elif series is not None:
            sample = min(int(np.searchsorted(series.times, span.start)), len(series.times) - 1)
            here = series.poses[sample, span.robot, :2]
            if not np.isfinite(here).all():
                continue
            apart = np.hypot(*(spots - here).T)
            if apart.size and apart.min() <= NEAR:
                by_station[names[int(apart.argmin())]].append(span)
            else:
                stray.append((*here, span.length))
    return by_station, np.array(stray, float).reshape(-1, 3)


def _places(stray: FloatArray) -> list[tuple[float, float, float]]:
    """Return the two circles of radius `NEAR` with most waiting: x, y [m], seconds of each.

    A circle's centre is a cell in which somebody waited; the second takes what the first has left.
    """
    if not len(stray):
        return []
    from scipy.spatial import cKDTree  # slow to import

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
