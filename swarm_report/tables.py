"""The tables behind the plots: the same figures as numbers."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from swarm_common.model.records import FloatArray
from swarm_report import maps
from swarm_report.measures import (
    shares_over_time,
    state_shares,
    state_times,
    station_use,
    throughput,
)
from swarm_report.run import RunData
from swarm_report.style import LABELS, STATES

LONGEST = 25  # rows of places
CLEARANCE_STEP = 0.05  # [m]


@dataclass(frozen=True, slots=True)
class Table:
    """A table of texts; `note` says what its rows are where that is not plain."""

    head: Sequence[str]
    rows: Sequence[Sequence[str]]
    note: str = ""


def percent(part: float | None) -> str:
    """Return a share as a percentage; a dash for an unknown one."""
    return "–" if part is None or not np.isfinite(part) else f"{100.0 * part:.1f} %"


def trajectories(run: RunData) -> Table | None:
    """Return where each robot began and ended, and how far it drove."""
    series = run.series
    if series is None or len(series.times) < 2:
        return None
    head = ["robot", "start x, y [m]", "end x, y [m]", "distance [m]", "moving", "mean speed [m/s]"]
    rows = []
    for robot, name in enumerate(run.robots):
        there = np.isfinite(series.poses[:, robot, 0])
        path, times = series.poses[there, robot, :2], series.times[there]
        if len(path) < 2:
            continue
        steps, gaps = np.hypot(*np.diff(path, axis=0).T), np.diff(times)
        moving = float(gaps[steps > 0.02 * gaps].sum() / max(gaps.sum(), 1e-9))
        rows.append(
            [
                name,
                *(f"{x:.2f}, {y:.2f}" for x, y in (path[0], path[-1])),
                f"{steps.sum():.1f}",
                percent(moving),
                f"{steps.sum() / max(gaps.sum(), 1e-9):.3f}",
            ]
        )
    return Table(head, rows, "From one position a second; moving: faster than 0.02 m/s.")


def density(run: RunData) -> Table | None:
    """Return the cells in which robots spent most time."""
    return _places(maps.presence_heat(run))


def waiting(run: RunData) -> Table | None:
    """Return the cells in which robots held or waited most."""
    return _places(maps.waiting_heat(run))


def _places(heat: maps.Heat | None) -> Table | None:
    if heat is None:
        return None
    area = heat.steps[0] * heat.steps[1]
    total = float(heat.values.sum())
    left, _, bottom, _ = heat.extent
    order = np.argsort(heat.values, axis=None)[::-1][:LONGEST]
    cells = [divmod(int(flat), heat.values.shape[1]) for flat in order]
    rows = [
        [
            f"{left + (column + 0.5) * heat.steps[0]:.2f}",
            f"{bottom + (row + 0.5) * heat.steps[1]:.2f}",
            f"{heat.values[column, row] * area:.1f}",
            percent(heat.values[column, row] / total),
        ]
        for column, row in cells
        if heat.values[column, row] > 0.0
    ]
    note = f"The {len(rows)} cells of {maps.CELL:g} m with most of it; all: {total * area:.0f} s."
    return Table(["x [m]", "y [m]", "robot-seconds", "of all"], rows, note)


def timeline(run: RunData) -> Table | None:
    """Return the share of its time that each robot spent in each state."""
    times, shares = state_times(run), state_shares(run)
    if not shares:
        return None
    known = [state for state in STATES if state in shares]
    states = [*known, *(state for state in shares if state not in STATES)]
    rows = [["all robots", *(percent(shares[state]) for state in states)]]
    for name, one in zip(run.robots, times, strict=True):
        total = sum(one.values())
        if total:
            rows.append([name, *(percent(one.get(state, 0.0) / total) for state in states)])
    return Table(["robot", *(LABELS.get(state, state) for state in states)], rows)


def states(run: RunData) -> Table | None:
    """Return the share of the robots in each state, in windows of time."""
    shares = shares_over_time(run)
    if shares is None:
        return None
    rows = [
        [f"{at:.1f}", *(percent(float(line[place])) for line in shares.by_state.values())]
        for place, at in enumerate(shares.times)
    ]
    head = ["t [s]", *(LABELS.get(state, state) for state in shares.by_state)]
    return Table(head, rows, "Each row is the middle of a window.")


def goals(run: RunData) -> Table | None:
    """Return every goal of the mission in order of time."""
    rows = [
        [
            f"{event.time:.1f}",
            run.robots[event.robot],
            event.goal,
            "missed" if event.outcome == "failed" else event.outcome,
            f"{event.duration:.1f}",
        ]
        for event in run.goals
        if event.outcome != "sent"
    ]
    return Table(["t [s]", "robot", "goal", "outcome", "took [s]"], rows) if rows else None


def flow(run: RunData) -> Table | None:
    """Return goals reached in each window of time."""
    rates = throughput(run)
    if rates is None:
        return None
    total = max(float(rates.goals.sum()), 1.0)
    columns = zip(rates.starts, rates.ends, rates.goals, rates.per_minute, strict=True)
    rows = [
        [f"{start:g}", f"{end:g}", f"{count:.0f}", f"{rate:.1f}", percent(count / total)]
        for start, end, count, rate in columns
    ]
    return Table(["from [s]", "to [s]", "goals", "per minute", "of all"], rows)


def stations(run: RunData) -> Table | None:
    """Return use and queue of each station."""
    uses = station_use(run)
    head = ["station", "in use", "goals", "queue, mean", "queue, longest", "queueing [s]", "of all"]
    total = max(sum(use.queue_time for use in uses.values()), 1e-9)
    rows = [
        [
            name,
            percent(use.utilisation),
            str(use.goals),
            f"{use.queue:.2f}",
            str(use.longest_queue),
            f"{use.queue_time:.1f}",
            percent(use.queue_time / total),
        ]
        for name, use in uses.items()
    ]
    return Table(head, rows) if rows else None


def clearance(run: RunData) -> Table | None:
    """Return the share of robot-seconds nearer than a distance."""
    series = run.series
    if series is None:
        return None
    edges = np.arange(CLEARANCE_STEP, series.near + 1e-9, CLEARANCE_STEP)
    sides = series.to_robot, series.to_world
    rows = [[f"{edge:.2f}", *(percent(_below(side, edge)) for side in sides)] for edge in edges]
    return Table(["nearer than [m]", "to a robot", "to an obstacle"], rows, "Of all robot-seconds.")


def _below(values: FloatArray, edge: float) -> float:
    known = values[np.isfinite(values)]
    return float((known < edge).mean()) if known.size else np.nan


def usage(run: RunData) -> Table | None:
    """Return smallest, median and largest of speed, CPU and memory."""
    data = run.usage
    if data is None:
        return None
    lines = {"real-time factor": data.factor}
    lines |= {f"CPU of {group} [cores]": cores for group, cores in data.cores.items()}
    lines |= {f"memory of {group} [GB]": mb / 1000.0 for group, mb in data.memory_mb.items()}
    rows = [
        [name, *(f"{value:.2f}" for value in (line.min(), float(np.median(line)), line.max()))]
        for name, line in lines.items()
    ]
    return Table(["", "smallest", "median", "largest"], rows)
