"""From lines to tables: what each method reached in each cell, and how methods differ."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import groupby

from swarm_bench.study import statistics
from swarm_bench.study.lines import StudyLine

REFERENCE = "ours"
Table = list[list[str]]


@dataclass(frozen=True, slots=True)
class CellRuns:
    """All seeds of one method in one cell."""

    cell: str
    method: str
    lines: Sequence[StudyLine]

    @property
    def ended(self) -> int:
        """Runs that reached every goal."""
        return sum(line.has_ended for line in self.lines)

    @property
    def contacts(self) -> int:
        """Contact episodes of all runs."""
        return sum(line.contacts for line in self.lines)

    def median(self) -> float:
        """Return the median makespan [s]; inf if fewer than half of the runs ended."""
        return statistics.kaplan_meier(
            [line.time for line in self.lines], [line.has_ended for line in self.lines]
        ).median


def groups(lines: Sequence[StudyLine]) -> list[CellRuns]:
    """Return the lines by cell and method, in the order in which they first occur."""
    order: dict[tuple[str, str], list[StudyLine]] = {}
    cells = {line.cell: rank for rank, line in reversed(list(enumerate(lines)))}
    methods = {line.method: rank for rank, line in reversed(list(enumerate(lines)))}
    for line in sorted(lines, key=lambda line: (cells[line.cell], methods[line.method], line.seed)):
        order.setdefault((line.cell, line.method), []).append(line)
    return [CellRuns(cell, method, found) for (cell, method), found in order.items()]


def medians(found: Sequence[CellRuns]) -> Table:
    """Return median makespans, runs that ended, and contacts: a row per cell."""
    methods = list(dict.fromkeys(group.method for group in found))
    table = [["cell", *methods]]
    for cell, members in groupby(found, lambda group: group.cell):
        by_method = {group.method: group for group in members}
        table.append([cell, *(_summary(by_method.get(method)) for method in methods)])
    return table


def _summary(group: CellRuns | None) -> str:
    if group is None:
        return "left out"
    text = f"{_seconds(group.median())} ({group.ended}/{len(group.lines)})"
    return f"{text}, {group.contacts} contacts" if group.contacts else text


def differences(found: Sequence[CellRuns]) -> Table:
    """Return how much longer other methods take than ours on the same seeds.

    Runs that did not end count with the time at which they were stopped. P values are adjusted
    over the table.
    """
    rows: list[tuple[str, str, statistics.Paired]] = []
    for cell, members in groupby(found, lambda group: group.cell):
        by_method = {group.method: _times(group.lines) for group in members}
        ours = by_method.pop(REFERENCE, {})
        for method, times in by_method.items():
            seeds = sorted(ours.keys() & times.keys())
            if seeds:
                rows.append(
                    (cell, method,
                     statistics.paired([times[s] for s in seeds], [ours[s] for s in seeds]))
                )  # fmt: skip
    adjusted = statistics.holm([row.p for _, _, row in rows])
    return [["cell", "method", "pairs", "longer than ours [s]", "p"]] + [
        [cell, method, str(row.pairs), interval(row.mean), f"{p:.3f}"]
        for (cell, method, row), p in zip(rows, adjusted, strict=True)
    ]


def _times(lines: Sequence[StudyLine]) -> Mapping[int, float]:
    return {line.seed: line.time for line in lines}


def details(found: Sequence[CellRuns]) -> Table:
    """Return everything that is known of each cell and method."""
    table = [[
        "cell", "method", "runs", "ended (95 %)", "contacts", "median [s]",
        "interquartile mean [s]", "slowest 5 % [s]", "gap to the bound", "CPU ms per robot-second",
        "longest decision of the centre [ms]", "bytes per robot-second by the centre",
    ]]  # fmt: skip
    for group in found:
        lines = group.lines
        times = [line.time for line in lines]
        share = statistics.wilson(group.ended, len(lines))
        gaps = [line.time / line.bound - 1.0 for line in lines if line.has_ended and line.bound]
        table.append([
            group.cell, group.method, str(len(lines)),
            f"{share.estimate:.0%} ({share.low:.0%} to {share.high:.0%})",
            _contacts(lines), _seconds(group.median()),
            f"{statistics.interquartile_mean(times):.0f}", _tail(times),
            f"{sum(gaps) / len(gaps):.0%}" if gaps else "–",
            _mean([line.cpu_ms_per_robot_second for line in lines]),
            _largest([line.longest_decision_ms for line in lines]),
            _mean([line.bytes_per_robot_second for line in lines]),
        ])  # fmt: skip
    return table


def _contacts(lines: Sequence[StudyLine]) -> str:
    touched = sum(line.contacts > 0 for line in lines)
    if touched:
        return f"{sum(line.contacts for line in lines)} in {touched} runs"
    return f"0 (< {statistics.bound_of_zero(len(lines)):.1%} of runs at 95 %)"


def _tail(times: Sequence[float]) -> str:
    ordered = sorted(times)
    return f"{ordered[min(len(ordered) - 1, math.ceil(0.95 * len(ordered)) - 1)]:.0f}"


def _mean(values: Sequence[float | None]) -> str:
    known = [value for value in values if value is not None]
    return f"{sum(known) / len(known):.2f}" if known else "–"


def _largest(values: Sequence[float | None]) -> str:
    known = [value for value in values if value is not None]
    return f"{max(known):.0f}" if known else "–"


def _seconds(value: float) -> str:
    return f"{value:.0f}" if math.isfinite(value) else "never"


def interval(value: statistics.Interval) -> str:
    """Return an estimate with its interval as text."""
    if math.isnan(value.low):
        return f"{value.estimate:+.0f}"
    return f"{value.estimate:+.0f} [{value.low:+.0f}, {value.high:+.0f}]"
