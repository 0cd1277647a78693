"""The fields of report.json that are worked out from a run's time series."""

from __future__ import annotations

from dataclasses import asdict
from typing import Any

from swarm_report import headline
from swarm_report.bottleneck import find_bottleneck
from swarm_report.measures import state_shares, station_use, throughput
from swarm_report.run import RunData

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
        **headline.as_json(run),
    }


def _rounded(value: float | None) -> float | None:
    return round(value, DIGITS) if isinstance(value, float) else value
