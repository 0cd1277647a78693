"""The headline: how long the run took, would have taken, and who stopped longest for whom.

Also all fields of report.json that are worked out from a run's time series.

Lost is the time in which robots held, waited, made way or recovered: `LOST`, here and everywhere.
"""

from __future__ import annotations

from collections import defaultdict
from dataclasses import asdict, dataclass
from typing import Any

from swarm_common.model.run_words import makespan
from swarm_report.bottleneck import find_bottleneck, worst_places
from swarm_report.ideal import ideal_times
from swarm_report.measures import lost_spans, lost_time, state_shares, station_use, throughput
from swarm_report.run import RunData

JOIN = 0.5  # [s] of driving between two stops that are one
LEAST = 1.0  # [s] of a stop that is told


@dataclass(frozen=True, slots=True)
class LongStop:
    """A robot that did not get on."""

    robot: int
    start: float  # [s]
    end: float  # [s]
    blocker: str  # robot that it waited or made way for most of that time; empty for none

    @property
    def length(self) -> float:
        """Duration [s]."""
        return self.end - self.start


@dataclass(frozen=True, slots=True)
class HeadlinePart:
    """A part of the headline; `time` [s] is the moment that it is about, None for none."""

    text: str
    time: float | None = None
    robot: str = ""


def longest_stop(run: RunData) -> LongStop | None:
    """Return the longest stop of any robot; None if no robot stopped."""
    return max(stops(run), key=lambda stop: stop.length, default=None)


def stops(run: RunData) -> list[LongStop]:
    """Return all stops; the parts of one may be in several states."""
    found: list[LongStop] = []
    seconds: dict[str, float] = defaultdict(float)
    for span in lost_spans(run):
        joins = found and found[-1].robot == span.robot and span.start <= found[-1].end + JOIN
        if not joins:
            seconds = defaultdict(float)
        seconds[span.blocker] += span.length
        named = {name: time for name, time in seconds.items() if name}
        blocker = max(named, key=named.__getitem__, default="")
        start = found.pop().start if joins else span.start
        found.append(LongStop(span.robot, start, span.end, blocker))
    return found


def headline(run: RunData) -> list[HeadlinePart]:
    """Return the sentence in parts; none if the states of the robots are not known."""
    lost, stop = lost_time(run), longest_stop(run)
    if lost is None:
        return []
    took = makespan(run.report) or run.end
    parts = [HeadlinePart(f"{took:.0f} s", took)]
    ideal = ideal_times(run)
    if ideal:
        slowest = max(ideal, key=ideal.__getitem__)
        parts.append(
            HeadlinePart(f"; {slowest} alone would need {ideal[slowest]:.0f} s", None, slowest)
        )
    parts.append(HeadlinePart(f"; {100.0 * lost.share:.0f} % lost"))
    if places := worst_places(run):
        parts += [HeadlinePart(", most of it near "), HeadlinePart(places[0].name, places[0].time)]
    if stop is not None and stop.length >= LEAST:
        name = run.robots[stop.robot]
        whom = f", for {stop.blocker}" if stop.blocker else ""
        text = f"{name} stopped longest, {stop.length:.0f} s{whom}"
        parts += [HeadlinePart("; "), HeadlinePart(text, stop.start, name)]
    return [*parts, HeadlinePart(".")]


def headline_text(run: RunData) -> str:
    """Return the headline as a sentence."""
    return "".join(part.text for part in headline(run))


def waits_between(run: RunData) -> dict[tuple[str, str], float]:
    """Return the seconds [s] that each robot (first) lost to each other one (second)."""
    sums: dict[tuple[str, str], float] = defaultdict(float)
    for span in lost_spans(run):
        if span.blocker:
            sums[run.robots[span.robot], span.blocker] += span.length
    return dict(sorted(sums.items(), key=lambda item: -item[1]))


def as_json(run: RunData) -> dict[str, Any]:
    """Return what report.json says."""
    lost, stop = lost_time(run), longest_stop(run)
    return {
        "headline": headline_text(run) or None,
        "lost": None if lost is None else {"seconds": lost.seconds, "share": lost.share},
        "ideal_times": {name: round(time, 1) for name, time in ideal_times(run).items()},
        "longest_stop": None
        if stop is None
        else {
            "robot": run.robots[stop.robot],
            "since": stop.start,
            "duration": round(stop.length, 3),
            "for": stop.blocker or None,
        },
        "waited_for": [
            {"robot": robot, "for": blocker, "seconds": round(seconds, 1)}
            for (robot, blocker), seconds in waits_between(run).items()
        ],
    }


DIGITS = 4


def report_fields(run: RunData) -> dict[str, Any]:
    """Return use of the stations, goals over time, shares of states, and where time was lost."""
    flow, worst = throughput(run), find_bottleneck(run)
    per_minute = [] if flow is None else [_rounded(float(rate)) for rate in flow.per_minute]
    return {
        "stations": {
            name: {key: _rounded(value) for key, value in asdict(use).items()}
            for name, use in station_use(run).items()
        },
        "throughput": None if flow is None else {"window": flow.window, "per_minute": per_minute},
        "state_shares": {state: _rounded(share) for state, share in state_shares(run).items()},
        "bottleneck": None if worst is None else worst.as_json(),
        **as_json(run),
    }


def _rounded(value: float | None) -> float | None:
    return round(value, DIGITS) if isinstance(value, float) else value
