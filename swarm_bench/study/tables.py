"""From lines to tables: what each method reached in each cell, and how methods differ."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import groupby
from pathlib import Path
from typing import NamedTuple

from swarm_bench import statistics
from swarm_bench.runs.methods import TEAMS
from swarm_bench.study.experiments import Cell
from swarm_bench.study.levels import Dip, change_of_sides, critical_size, dip_of
from swarm_bench.study.lines import STEP, StudyLine
from swarm_bench.tables import BenchTable

REFERENCE = "ours"
LEAST_PAIRS = 5  # of a difference that counts as sure
FACTORS = (1.05, 1.1, 1.25, 1.5, 2.0)  # of performance profiles


@dataclass(frozen=True, slots=True)
class CellRuns:
    """All seeds of one method in one cell."""

    cell: str
    method: str
    lines: Sequence[StudyLine]

    @property
    def succeeded(self) -> int:
        """Runs that were successful."""
        return sum(line.is_success for line in self.lines)

    @property
    def ended(self) -> int:
        """Runs that reached every goal."""
        return sum(line.has_ended for line in self.lines)

    @property
    def contacts(self) -> int:
        """Contact episodes of all runs."""
        return sum(line.contacts for line in self.lines)

    @property
    def is_lifelong(self) -> bool:
        """Whether the runs have no end."""
        return self.lines[0].per_hour is not None

    @property
    def values(self) -> list[float]:
        """Throughputs [1/h], or times [s]."""
        return [line.time if line.per_hour is None else line.per_hour for line in self.lines]

    def known(self, name: str) -> list[float]:
        """Return the values of a field of the lines that have it."""
        values = (getattr(line, name) for line in self.lines)
        return [value for value in values if value is not None]

    def median(self) -> float:
        """Return the median makespan [s]; inf if fewer than half of the runs ended."""
        return statistics.kaplan_meier(
            [line.time for line in self.lines], [line.has_ended for line in self.lines]
        ).median

    def throughput(self) -> float:
        """Return the mean throughput [1/h]."""
        return sum(line.gain for line in self.lines) / len(self.lines)


def groups(lines: Sequence[StudyLine]) -> list[CellRuns]:
    """Return the lines by cell and method, in the order in which they first occur."""
    order: dict[tuple[str, str], list[StudyLine]] = {}
    cells = {line.cell: rank for rank, line in reversed(list(enumerate(lines)))}
    methods = {line.method: rank for rank, line in reversed(list(enumerate(lines)))}
    for line in sorted(lines, key=lambda line: (cells[line.cell], methods[line.method], line.seed)):
        order.setdefault((line.cell, line.method), []).append(line)
    return [CellRuns(cell, method, found) for (cell, method), found in order.items()]


def results(found: Sequence[CellRuns]) -> BenchTable:
    """Return median makespans or throughputs, successful runs and contacts: a row per cell."""
    return _by_method("cell", {(group.cell, group.method): _summary(group) for group in found})


def _by_method(title: str, texts: Mapping[tuple[str, str], str]) -> BenchTable:
    """Return a table with a column per method.

    Args:
        texts: Cells by name of the row and method.
    """
    methods = list(dict.fromkeys(method for _, method in texts))
    rows = [
        [name, *(texts.get((name, method), "–") for method in methods)]
        for name in dict.fromkeys(name for name, _ in texts)
    ]
    return BenchTable([title, *methods], rows)


def _summary(group: CellRuns) -> str:
    if group.is_lifelong:
        text = f"{group.throughput():.0f}/h ({group.succeeded}/{len(group.lines)})"
    else:
        gap = _gap(group.lines)
        text = f"{_seconds(group.median())} ({group.ended}/{len(group.lines)})"
        text += f", +{gap:.0%}" if gap is not None else ""
    return f"{text}, {group.contacts} contacts" if group.contacts else text


def _gap(lines: Sequence[StudyLine]) -> float | None:
    gaps = [line.time / line.bound - 1.0 for line in lines if line.has_ended and line.bound]
    return sum(gaps) / len(gaps) if gaps else None


def contacts_of(lines: Sequence[StudyLine]) -> str:
    """Return the contact episodes of each method, and in how many of its runs, in words."""
    texts = []
    for method in dict.fromkeys(line.method for line in lines):
        members = [line for line in lines if line.method == method]
        texts.append(f"{method} {_contacts(members)} of {len(members)} runs")
    return "; ".join(texts)


def _compared(lines: Sequence[StudyLine], ours: Sequence[StudyLine]) -> statistics.Paired | None:
    """Return by how much [%] a method is better than ours on the seeds that both have."""
    known = {line.seed: line.gain for line in ours}
    gains = {line.seed: line.gain for line in lines if line.seed in known}
    if not gains:
        return None
    scale = sum(abs(known[seed]) for seed in gains) / len(gains) or 1.0
    return statistics.paired(
        {seed: 100.0 * gain / scale for seed, gain in gains.items()},
        {seed: 100.0 * gain / scale for seed, gain in known.items()},
    )


class CellDifference(NamedTuple):
    """How much better a method is than ours in a cell, on the same seeds."""

    cell: str
    method: str
    paired: statistics.Paired  # [%]
    p: float  # adjusted over the table

    @property
    def side(self) -> int:
        """1 if the method is better for sure, -1 if ours is, else 0."""
        if len(self.paired.differences) < LEAST_PAIRS:
            return 0
        return 1 if self.paired.mean.low > 0.0 else -1 if self.paired.mean.high < 0.0 else 0


def compared(found: Sequence[CellRuns]) -> list[CellDifference]:
    """Return the differences of all methods to ours, cell by cell.

    Runs that did not end count with the time at which they were stopped.
    """
    rows = []
    for cell, members in groupby(found, lambda group: group.cell):
        by_method = {group.method: group.lines for group in members}
        ours = by_method.pop(REFERENCE, ())
        for method, lines in by_method.items():
            if paired := _compared(lines, ours):
                rows.append((cell, method, paired))
    adjusted = statistics.holm([paired.p for *_, paired in rows])
    return [CellDifference(*row, p) for row, p in zip(rows, adjusted, strict=True)]


DIFFERENCES: dict[str, Callable[[CellDifference], str]] = {
    "cell": lambda row: row.cell,
    "method": lambda row: row.method,
    "pairs": lambda row: str(len(row.paired.differences)),
    "better than ours [%]": lambda row: row.paired.mean.text(),
    "p (Holm)": lambda row: f"{row.p:.3f}",
}


def differences(found: Sequence[CellRuns]) -> BenchTable:
    """Return by how much other methods are better than ours."""
    return BenchTable.of(DIFFERENCES, compared(found), texts=("cell", "method"))


def _level(cell: Cell, axis: str) -> float:
    if axis == "outage":
        return (cell.until or math.inf) - cell.at if cell.outage else 0.0
    return float(getattr(cell, axis))


def _level_text(axis: str, level: float) -> str:
    if axis == "dead":
        return f"{level:.0%}"
    return f"{level:g}" if math.isfinite(level) else "for ever"


AXES = ("robots", "loss", "delay", "dead", "outage")
NOT_VARIED = {"seconds", "seeds", "methods", "quick", "at", "until"}  # fields of cells


def axes_of(cells: Sequence[Cell]) -> Iterator[tuple[str, str, dict[float, str]]]:
    """Yield world, what varies, and the name of the cell at each level, for two levels or more."""
    for scenario in dict.fromkeys(cell.scenario for cell in cells):
        members = [cell for cell in cells if cell.scenario == scenario]
        for axis in AXES:
            levels: dict[float, str] = {}
            for cell in members:
                plain = Cell(scenario=scenario, robots=cell.robots)
                changed = {
                    name
                    for name in Cell.__struct_fields__
                    if getattr(cell, name) != getattr(plain, name)
                }
                if changed - NOT_VARIED <= {axis}:
                    levels.setdefault(_level(cell, axis), cell.name)
            if len(levels) > 1:
                yield Path(scenario).stem, axis, levels


def sides(cells: Sequence[Cell], found: Sequence[CellRuns]) -> BenchTable:
    """Return at which levels a centre is ahead of ours for sure, and ours of it."""
    head = ["world", "varied", "centre", "it is ahead at", "ours ahead at", "from, ahead"]
    table, rows = [], compared(found)
    for world, axis, levels in axes_of(cells):
        for method in dict.fromkeys(row.method for row in rows):
            if method not in TEAMS:
                continue
            by_cell = {row.cell: row for row in rows if row.method == method}
            known = {level: by_cell[name] for level, name in levels.items() if name in by_cell}
            if not known:
                continue
            won, lost = (
                ", ".join(_level_text(axis, lv) for lv, row in known.items() if row.side == side)
                or "–"
                for side in (1, -1)
            )
            sure = {
                level: row.paired.differences
                for level, row in known.items()
                if len(row.paired.differences) >= LEAST_PAIRS
            }
            change = change_of_sides(sure)
            text = "–"
            if change is not None:
                last = known[max(sure)].paired.mean.estimate
                who = "the centre" if last > 0.0 else "ours"
                at = _level_text(axis, change.estimate)
                low, high = _level_text(axis, change.low), _level_text(axis, change.high)
                text = f"{who} from {at} [{low}, {high}]"
            table.append([world, axis, method, won, lost, text])
    return BenchTable(head, table, texts=head)


def critical_sizes(cells: Sequence[Cell], found: Sequence[CellRuns]) -> BenchTable:
    """Return from which size on more robots bring no more, and the throughput there."""
    by_name = {(group.cell, group.method): group for group in found}
    texts = {}
    for world, axis, levels in axes_of(cells):
        for method in dict.fromkeys(group.method for group in found):
            if axis == "robots":
                known = {n: by_name.get((name, method)) for n, name in levels.items()}
                texts[world, method] = _critical({n: g for n, g in known.items() if g})
    return _by_method("world", texts)


def _critical(members: Mapping[float, CellRuns]) -> str:
    if len(members) < 2 or not all(group.is_lifelong for group in members.values()):
        return "–"
    size = critical_size(
        {int(n): {line.seed: line.gain for line in g.lines} for n, g in members.items()},
        {int(n): {line.seed: line.is_success for line in g.lines} for n, g in members.items()},
    )
    if size.estimate == 0.0:
        return f"below {min(members):g}"
    largest = "≥ " if size.estimate == max(members) else ""
    return f"{largest}{size.text('{:g}')}: {members[size.estimate].throughput():.0f}/h"


class TwinDips(NamedTuple):
    """How far the runs of a method fall behind their undisturbed twins of the same seed."""

    change: str  # what disturbs them
    group: CellRuns
    dips: list[Dip]

    def mean(self, field: int) -> statistics.Interval:
        """Return the mean of a field of the dips."""
        return statistics.bootstrap_mean([dip[field] for dip in self.dips])

    @property
    def recovered_after(self) -> str:
        """Median time to recover."""
        median = statistics.kaplan_meier(
            [dip.recovery for dip in self.dips], [dip.has_recovered for dip in self.dips]
        ).median
        return f"{median:.0f} s" if math.isfinite(median) else "not in time"


DIPS: dict[str, Callable[[TwinDips], str]] = {
    "change": lambda row: row.change,
    "method": lambda row: row.group.method,
    "pairs": lambda row: str(len(row.dips)),
    "worst minute lacks": lambda row: f"{row.mean(0).estimate:.0%}",
    "most orders behind": lambda row: row.mean(1).text("{:.1f}"),
    "order minutes": lambda row: row.mean(2).text("{:.0f}"),
    "recovered after (median)": lambda row: row.recovered_after,
    "contacts": lambda row: str(row.group.contacts),
}


def dips(cells: Sequence[Cell], found: Sequence[CellRuns]) -> BenchTable:
    """Return how far runs fall behind their undisturbed twins of the same seed."""
    by_name = {(group.cell, group.method): group for group in found}
    rows = []
    for cell in cells:
        for method in dict.fromkeys(group.method for group in found):
            group, twin = by_name.get((cell.name, method)), by_name.get((cell.twin, method))
            if cell.name == cell.twin or group is None or twin is None:
                continue
            known = {line.seed: line.orders for line in twin.lines}
            behind = [
                dip_of(line.orders, orders, cell.at, STEP)
                for line in group.lines
                if line.orders and (orders := known.get(line.seed))
            ]
            if behind:
                rows.append(TwinDips(cell.name.partition(", ")[2], group, behind))
    return BenchTable.of(DIPS, rows, texts=("change", "method"))


def short_dips(table: BenchTable) -> BenchTable:
    """Return the most orders behind and the time to recover, a row per change."""
    texts = {(row[0], row[1]): f"{row[4]}, {row[6]}" for row in table.rows}
    return _by_method("orders behind at worst, and time to recover", texts)


def profiles(found: Sequence[CellRuns]) -> BenchTable:
    """Return the share of instances that each method does within a factor of the best one."""
    best: dict[tuple[str, int], float] = {}
    for group in found:
        for line in group.lines:
            if line.is_success:
                key = group.cell, line.seed
                best[key] = max(best.get(key, -math.inf), line.gain)
    rows = []
    for method in dict.fromkeys(group.method for group in found):
        ratios = [
            _ratio(line, best[group.cell, line.seed])
            for group in found
            if group.method == method
            for line in group.lines
            if (group.cell, line.seed) in best
        ]
        if ratios:
            shares = statistics.profile(ratios, FACTORS)
            rows.append([method, str(len(ratios)), *(f"{share:.0%}" for share in shares)])
    return BenchTable(["method", "instances", *(f"within {factor:g}" for factor in FACTORS)], rows)


def _ratio(line: StudyLine, best: float) -> float:
    if not line.is_success:
        return math.inf
    if line.per_hour is None:
        return line.gain / best
    return best / line.gain if line.gain else math.inf


DETAILS: dict[str, Callable[[CellRuns], str]] = {
    "cell": lambda group: group.cell,
    "method": lambda group: group.method,
    "runs": lambda group: str(len(group.lines)),
    "successful (95 %)": lambda group: "{0.estimate:.0%} ({0.low:.0%} to {0.high:.0%})".format(
        statistics.wilson(group.succeeded, len(group.lines))
    ),
    "contacts": lambda group: _contacts(group.lines),
    "makespan, median [s]": lambda group: "–" if group.is_lifelong else _seconds(group.median()),
    "interquartile mean": lambda group: f"{statistics.interquartile_mean(group.values):.0f}",
    "worst 5 %": lambda group: _tail(group),
    "gap to the bound": lambda group: _form(_gap(group.lines), "{:.0%}"),
    "per hour (95 %)": lambda group: (
        statistics.bootstrap_mean(group.values).text("{:.0f}") if group.is_lifelong else "–"
    ),
    "lead time [s]": lambda group: _form(_mean(group, "lead_time"), "{:.0f}"),
    "CPU ms per robot-second": lambda group: _form(
        _mean(group, "cpu_ms_per_robot_second"), "{:.2f}"
    ),
    "longest decision of the centre [ms]": lambda group: _form(
        max(group.known("longest_decision_ms"), default=None), "{:.0f}"
    ),
    "radio bytes per robot-second": lambda group: _form(
        _mean(group, "bytes_per_robot_second"), "{:.0f}"
    ),
}


def details(found: Sequence[CellRuns]) -> BenchTable:
    """Return everything that is known of each cell and method."""
    return BenchTable.of(DETAILS, found, texts=("cell", "method"))


def _form(value: float | None, form: str) -> str:
    return "–" if value is None else form.format(value)


def _contacts(lines: Sequence[StudyLine]) -> str:
    touched = sum(line.contacts > 0 for line in lines)
    if touched:
        return f"{sum(line.contacts for line in lines)} in {touched}"
    return f"0 (< {statistics.bound_of_zero(len(lines)):.1%} at 95 %)"


def _tail(group: CellRuns) -> str:
    sign = -1.0 if group.is_lifelong else 1.0
    ordered = sorted(sign * value for value in group.values)
    return f"{abs(ordered[min(len(ordered) - 1, math.ceil(0.95 * len(ordered)) - 1)]):.0f}"


def _mean(group: CellRuns, name: str) -> float | None:
    known = group.known(name)
    return sum(known) / len(known) if known else None


def _seconds(value: float) -> str:
    return f"{value:.0f}" if math.isfinite(value) else "never"
