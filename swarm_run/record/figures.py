"""Derived figures of a run, each by one function."""

from __future__ import annotations

import math
import statistics
from collections.abc import Mapping, Sequence
from typing import Any

import msgspec
import numpy as np

BATCHES = 10  # of equal length, after a warm-up
MINUTE, HOUR = 60.0, 3600.0  # [s]
DIGITS = 4  # of the figures in files


class Fairness(msgspec.Struct, frozen=True):
    """Durations of the goals reached in a run; None where there was none.

    A goal's duration is the simulated time from the tick at which its robot was free to set off
    for it (the end of the goal before and the pause there) to the tick in which it was reached,
    with all tries, holding and waiting.
    """

    median: float | None  # [s] over all goals of all robots
    worst: float | None  # [s] the longest
    ratio: float | None  # worst / median: 1 if all goals took equally long


class Waiting(msgspec.Struct, frozen=True):
    """Time [s] that robots held and waited; `median` and `worst` are over robots."""

    median: float | None
    worst: float


class Steady(msgspec.Struct, frozen=True, kw_only=True):
    """Work finished in the time after the warm-up of a run of fixed duration."""

    warm_up: float  # [s] that do not count
    seconds: float  # [s] that count
    finished: tuple[int, ...]  # goals or orders, in batches of equal length
    lead_times: tuple[float, ...]  # [s] mean lead time of those of each batch; 0 for none
    per_hour: float  # finished goals or orders
    lead_time: float | None  # [s] mean, of all; None if none was finished
    lead_p95: float | None  # [s] that 95 % took at most
    unit: str = "goals"  # what is counted


def fairness(durations: Sequence[float]) -> Fairness:
    """Return how evenly goals with these durations [s] were served."""
    if not durations:
        return Fairness(None, None, None)
    median, worst = statistics.median(durations), max(durations)
    return Fairness(median, worst, worst / median if median > 0.0 else None)


def waiting(times: Sequence[float]) -> Waiting:
    """Return the figures of the times [s] that each robot held and waited."""
    return Waiting(statistics.median(times) if times else None, max(times, default=0.0))


def per_minute(count: int, seconds: float | None) -> float:
    """Return a rate [1/min]; 0 without any time."""
    return MINUTE * count / seconds if seconds else 0.0


def per_robot_second(value: float, robots: int, seconds: float) -> float | None:
    """Return the share of a cost that falls to a robot in a second; None without any time."""
    return value / (robots * seconds) if robots * seconds > 0.0 else None


def percentiles(values: Sequence[float], **wanted: float) -> dict[str, float]:
    """Return percentiles of one or more values by the names that `wanted` gives them."""
    found = np.percentile(np.asarray(values, np.float64), list(wanted.values()))
    return dict(zip(wanted, found.tolist(), strict=True))


def steady_of(
    finished: Sequence[tuple[float, float]], warm_up: float, duration: float, unit: str = "goals"
) -> Steady:
    """Return the figures of a run of fixed duration.

    Args:
        finished: (time of the end [s], lead time [s]) of each goal or order, in any order.
        warm_up: [s] that do not count.
        duration: [s] of the run; one that ended earlier finished nothing in the rest.
    """
    seconds = duration - warm_up
    late = sorted(item for item in finished if warm_up < item[0] <= duration)
    batches: list[list[float]] = [[] for _ in range(BATCHES)]
    for end, lead in late:
        batches[min(BATCHES - 1, int(BATCHES * (end - warm_up) / seconds))].append(lead)
    leads = [lead for _, lead in late]
    return Steady(
        warm_up=warm_up,
        seconds=seconds,
        finished=tuple(len(batch) for batch in batches),
        lead_times=tuple(float(np.mean(batch)) if batch else 0.0 for batch in batches),
        per_hour=HOUR * len(late) / seconds,
        lead_time=float(np.mean(leads)) if leads else None,
        lead_p95=percentiles(leads, p95=95)["p95"] if leads else None,
        unit=unit,
    )


def finite(value: float | None) -> float | None:
    """Return a number, or None for one that is unknown, NaN or infinite."""
    return value if value is not None and math.isfinite(value) else None


def rounded(value: Any, digits: int = DIGITS) -> Any:
    """Return data as builtins fit for JSON: rounded, None for what is not finite.

    Args:
        value: A number, a text, None, or mappings, sequences and structs of them.
    """
    if isinstance(value, float):
        return round(float(value), digits) if math.isfinite(value) else None
    if isinstance(value, msgspec.Struct):
        value = msgspec.structs.asdict(value)
    if isinstance(value, Mapping):
        return {key: rounded(item, digits) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [rounded(item, digits) for item in value]
    return value
