"""Figures over a run's time series: use of the stations, goals over time, what robots did."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable
from dataclasses import dataclass, replace

import numpy as np

from swarm_common.model.records import FloatArray, Pose
from swarm_report.run import RunData, Series, Span

AT_STATION = 0.5  # [m] from a station within which a robot counts as there
HOLDING, IDLE = "holding", "idle"
LOST = (HOLDING, "waiting", "yielding", "recovering")  # states of robots that do not get on
LOST_WORDS = "holding, waiting, making way and recovering"
WINDOWS = (10.0, 20.0, 30.0, 60.0, 120.0, 300.0, 600.0, 1200.0, 1800.0, 3600.0)  # [s]
MOST_WINDOWS = 40
SHARE_WINDOWS = 120  # over which the shares of states are taken


@dataclass(frozen=True, slots=True)
class StationUse:
    """How a station was used."""

    utilisation: float | None  # share of the time with a robot there; None without a time series
    goals: int  # goals reached there
    queue: float  # robots that queued or held for it, on average over the run
    longest_queue: int  # most robots that did so at a time
    queue_time: float  # [s] that robots queued or held for it, summed over the robots


@dataclass(frozen=True, slots=True)
class Throughput:
    """Goals reached per minute in windows of equal width; the last one may be shorter."""

    window: float  # [s] width
    starts: FloatArray  # (k,) [s]
    ends: FloatArray  # (k,) [s]
    goals: FloatArray  # (k,) goals reached in each
    per_minute: FloatArray  # (k,) of each window's own width
    mean: float  # until the last goal was settled, as `throughput_per_minute` of report.json

    @property
    def mean_label(self) -> str:
        """The mean in words, for legends."""
        return f"mean until the last goal ({self.mean:.3g})"


def station_use(run: RunData) -> dict[str, StationUse]:
    """Return the use of each station by name; none if stations or states are not known."""
    if run.end <= 0.0 or not (run.spans or run.series):
        return {}
    uses = {}
    for name, pose in run.sites.stations.items():
        queued = [
            span
            for span in run.spans
            if span.station == name and (span.place > 0 or span.state == HOLDING)
        ]
        seconds = sum(span.length for span in queued)
        uses[name] = StationUse(
            utilisation=None if run.series is None else _occupancy(run.series, pose),
            goals=sum(goal.goal == name and goal.outcome == "reached" for goal in run.goals),
            queue=seconds / run.end,
            longest_queue=_most_at_once(queued),
            queue_time=seconds,
        )
    return uses


def _occupancy(series: Series, station: Pose) -> float:
    offsets = series.poses[..., :2] - (station.x, station.y)
    near = np.hypot(offsets[..., 0], offsets[..., 1]) < AT_STATION
    return float(near.any(axis=1).mean())


def _most_at_once(spans: Iterable[Span]) -> int:
    changes = sorted(
        change for span in spans for change in ((span.start, 1), (span.end, -1))
    )  # at equal times ends come first
    return int(max(np.cumsum([step for _, step in changes]), default=0))


def throughput(run: RunData) -> Throughput | None:
    """Return goals reached per minute over the run; None if no goal was settled."""
    times = [event.time for event in run.goals if event.outcome == "reached"]
    settled = times + [event.time for event in run.goals if event.outcome == "failed"]
    if not settled or run.end <= 0.0:
        return None
    window = next((w for w in WINDOWS if run.end <= w * MOST_WINDOWS), WINDOWS[-1])
    count = max(1, int(np.ceil(run.end / window - 1e-9)))
    starts = window * np.arange(count, dtype=np.float64)
    ends = np.minimum(starts + window, run.end)
    edges = np.append(starts, max(run.end, starts[-1] + 1e-3))
    goals = np.histogram(times, bins=edges)[0].astype(np.float64)
    per_minute = 60.0 * goals / np.maximum(ends - starts, 1e-3)
    mean = 60.0 * len(times) / max(*settled, 1e-3)
    return Throughput(window, starts, ends, goals, per_minute, mean)


def state_times(run: RunData) -> list[dict[str, float]]:
    """Return by robot the seconds that it spent in each state."""
    times: list[dict[str, float]] = [defaultdict(float) for _ in run.robots]
    for span in run.spans:
        times[span.robot][span.state] += span.length
    return [dict(one) for one in times]


@dataclass(frozen=True, slots=True)
class SharesOverTime:
    """How many of the robots were in which state."""

    times: FloatArray  # (k,) [s] middles of windows of equal width
    # state to (k,) share of the robots' known time; in the order of first appearance
    by_state: dict[str, FloatArray]


def shares_over_time(run: RunData) -> SharesOverTime | None:
    """Return the share of the robots in each state over time; None if it is not known."""
    if not run.spans or run.end <= 0.0:
        return None
    edges = np.linspace(0.0, run.end, SHARE_WINDOWS + 1)
    sums: dict[str, FloatArray] = {}
    for span in run.spans:
        inside = np.clip(
            np.minimum(span.end, edges[1:]) - np.maximum(span.start, edges[:-1]), 0, None
        )
        sums[span.state] = sums.get(span.state, np.zeros(SHARE_WINDOWS)) + inside
    known = np.maximum(np.sum(list(sums.values()), axis=0), 1e-9)
    middles = 0.5 * (edges[1:] + edges[:-1])
    return SharesOverTime(middles, {state: line / known for state, line in sums.items()})


def state_shares(run: RunData) -> dict[str, float]:
    """Return the share of the robots' time in each state; empty if it is not known."""
    return shares_of(run.spans)


def shares_of(spans: Iterable[Span]) -> dict[str, float]:
    """Return the share of all spans' time in each state; empty without spans."""
    sums: dict[str, float] = defaultdict(float)
    for span in spans:
        sums[span.state] += span.length
    total = sum(sums.values())
    return {state: seconds / total for state, seconds in sums.items()} if total else {}


@dataclass(frozen=True, slots=True)
class LostTime:
    """The time in which robots did not get on: in the states of `LOST`."""

    seconds: float  # of all robots
    share: float  # of the robots' time, without what came after the mission


def lost_time(run: RunData) -> LostTime | None:
    """Return the time that was lost; None if the states are not known."""
    total = sum(span.length for span in mission_spans(run))
    if not total:
        return None
    lost = sum(span.length for span in lost_spans(run))
    return LostTime(lost, lost / total)


def lost_spans(run: RunData) -> list[Span]:
    """Return the spans in which robots did not get on, in order of robots and time."""
    return [span for span in mission_spans(run) if span.state in LOST]


def mission_spans(run: RunData) -> list[Span]:
    """Return the spans without what came after the mission, in order of robots and time."""
    is_done = run.goals and run.report.get("goals", {}).get("pending") == 0
    end = run.goals[-1].time if is_done else run.end
    return [replace(span, end=min(span.end, end)) for span in run.spans if span.start < end]
