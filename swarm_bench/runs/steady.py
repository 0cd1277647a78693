"""Finished goals and their times after the warm-up of a run of fixed duration."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from swarm_bench.runs.result import Steady

BATCHES = 10  # of equal length, after the warm-up
HOUR = 3600.0  # [s]


def steady_of(
    finished: Sequence[tuple[float, float]], warm_up: float, duration: float, unit: str = "goals"
) -> Steady:
    """Return the figures of a run.

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
        lead_p95=float(np.percentile(leads, 95)) if leads else None,
        unit=unit,
    )
