"""Findings from the curves, in sentences that hold over the seeds, or none."""

from __future__ import annotations

import statistics
from collections.abc import Callable, Sequence

from swarm_bench.capacity.curve import Curve, Point
from swarm_bench.statistics import LEAST_SEEDS, Interval, paired, student_mean
from swarm_run.record.run_record import RunRecord

FULL = 0.8  # share of time from which a station is the reason
STANDING = 0.2  # share of the robots' time from which standing is


def knee_sentence(curve: Curve) -> str:
    """Return how many robots a hall is good for."""
    knee, most = curve.knee, curve.sizes[-1]
    if knee is None:
        return f"No knee is certain between {curve.sizes[0]} and {most} robots."
    return (
        f"Up to {knee.robots} robots [{knee.low}, {knee.high}] each one brings more; there "
        f"{knee.plateau:.0f} {curve.unit} per hour are finished, and beyond it more robots bring "
        "less than half as much each."
    )


def demand_sentence(curve: Curve) -> str:
    """Return where orders come faster than they are done; empty if nowhere."""
    unmet = {p.robots: p.demand for p in curve.points if p.demand and not p.demand.is_met}
    if not unmet:
        return ""
    told = ", ".join(f"{n} ({one.before:.0f} to {one.after:.0f})" for n, one in unmet.items())
    return f"Demand not met: open orders, and lead times with them, grow with {told} robots."


def reason_sentence(curve: Curve) -> str:
    """Return why more robots bring little, or nothing where the seeds disagree."""
    knee = curve.knee
    if knee is None:
        return ""
    points = [point for point in curve.points if point.robots >= knee.robots]
    if not points or min(len(point.runs) for point in points) < LEAST_SEEDS:
        return ""
    first = points[0].robots
    return _station_reason(points, first) or _floor_reason(points, first)


def _station_reason(points: Sequence[Point], first: int) -> str:
    """Return the station that is in use all the time, the same one in every run."""
    busiest = {_busiest(run)[0] for point in points for run in point.runs}
    if len(busiest) != 1 or "" in busiest:
        return ""
    (name,) = busiest
    uses = [point.station_use()[name] for point in points]
    if min(use.low for use in uses) < FULL:
        return ""
    share = student_mean(_over_seeds(points, lambda run: _busiest(run)[1]))
    return f"From {first} robots on {name} is occupied or approached {_percent(share)} of the time."


def _floor_reason(points: Sequence[Point], first: int) -> str:
    """Return that robots stand in each other's way, if they do in every run."""
    runs = [run for point in points for run in point.runs]
    if any(run.ground_truth is None or run.ground_truth.stood_share < STANDING for run in runs):
        return ""
    if max((_busiest(run)[1] for run in runs), default=0.0) >= FULL:
        return ""
    share = student_mean(
        _over_seeds(points, lambda run: run.ground_truth.stood_share if run.ground_truth else 0.0)
    )
    return (
        f"From {first} robots on they stand {_percent(share)} of their time, and no station is "
        f"occupied or approached {100 * FULL:.0f} % of the time: the floor is full."
    )


def _busiest(run: RunRecord) -> tuple[str, float]:
    stations = run.ground_truth.stations if run.ground_truth else {}
    if not stations:
        return "", 0.0
    name = max(stations, key=lambda one: stations[one].approached)
    return name, stations[name].approached


def comparison_sentences(first: Curve, second: Curve) -> list[str]:
    """Return the difference of two variants at each size, on the seeds that both have."""
    sentences = []
    for robots in first.sizes:
        before, after = (
            {
                run.seed: run.steady.per_hour
                for point in curve.points
                if point.robots == robots
                for run in point.runs
                if run.steady
            }
            for curve in (first, second)
        )
        seeds = before.keys() & after.keys()
        if len(seeds) < 2:
            continue
        difference = paired(after, before, student_mean).mean
        if difference.low <= 0.0 <= difference.high and difference.half_width > 0.0:
            told = "no difference is certain"
        else:
            told = f"{second.label} finishes {'more' if difference.estimate > 0 else 'less'}"
            if difference.estimate == 0.0:
                told = "both finish the same"
        base = statistics.fmean(before[seed] for seed in seeds)
        share = f", {100.0 * difference.estimate / base:+.1f} %" if base else ""
        sentences.append(
            f"With {robots} robots {told}: {difference.estimate:+.1f} {first.unit} per hour "
            f"{difference.ends('{:+.1f}')}{share} ({len(seeds)} seeds)."
        )
    return sentences


def _over_seeds(points: Sequence[Point], of: Callable[[RunRecord], float]) -> list[float]:
    by_size = [{run.seed: of(run) for run in point.runs} for point in points]
    seeds = sorted(set.intersection(*(set(one) for one in by_size)))
    return [statistics.fmean(one[seed] for one in by_size) for seed in seeds]


def _percent(share: Interval) -> str:
    low, high = max(0.0, share.low), min(1.0, share.high)
    return f"{100 * share.estimate:.0f} % [{100 * low:.0f}, {100 * high:.0f}]"
