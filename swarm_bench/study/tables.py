"""From lines to tables: what each method reached in each cell, and how methods differ."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import groupby
from pathlib import Path
from typing import NamedTuple

from swarm_bench.runs.methods import TEAMS
from swarm_bench.study import statistics
from swarm_bench.study.experiments import Cell
from swarm_bench.study.lines import STEP, StudyLine

REFERENCE = "ours"
LEAST_PAIRS = 5  # of a difference that counts as sure
FACTORS = (1.05, 1.1, 1.25, 1.5, 2.0)  # of performance profiles
Table = list[list[str]]


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


def results(found: Sequence[CellRuns]) -> Table:
    """Return median makespans or throughputs, successful runs and contacts: a row per cell."""
    methods = list(dict.fromkeys(group.method for group in found))
    table = [["cell", *methods]]
    for cell, members in groupby(found, lambda group: group.cell):
        by_method = {group.method: group for group in members}
        table.append([cell, *(_summary(by_method.get(method)) for method in methods)])
    return table


def _summary(group: CellRuns | None) -> str:
    if group is None:
        return "–"
    if group.is_lifelong:
        text = f"{group.throughput():.0f}/h ({group.succeeded}/{len(group.lines)})"
    else:
        gap = _gap(group.lines)
        text = f"{_seconds(group.median())} ({group.ended}/{len(group.lines)})"
        text += f", +{gap:.0%}" if gap is not None else ""
    return f"{text}, {group.contacts} contacts" if group.contacts else text


def _gap(lines: Sequence[StudyLine]) -> float | None:
    """Return by which share the runs that ended took longer than the least possible, on average."""
    gaps = [line.time / line.bound - 1.0 for line in lines if line.has_ended and line.bound]
    return sum(gaps) / len(gaps) if gaps else None


def contacts_of(lines: Sequence[StudyLine]) -> str:
    """Return the contact episodes of each method, and in how many of its runs, in words."""
    texts = []
    for method in dict.fromkeys(line.method for line in lines):
        members = [line for line in lines if line.method == method]
        texts.append(f"{method} {_contacts(members)} of {len(members)} runs")
    return "; ".join(texts)


def _percentages(lines: Sequence[StudyLine], ours: Sequence[StudyLine]) -> list[float]:
    """Return by how much [%] a method is better than ours, for each seed that both have."""
    known = {line.seed: line.gain for line in ours}
    pairs = [(line.gain, known[line.seed]) for line in lines if line.seed in known]
    scale = sum(abs(other) for _, other in pairs) / max(1, len(pairs)) or 1.0
    return [100.0 * (gain - other) / scale for gain, other in pairs]


class CellDifference(NamedTuple):
    """How much better a method is than ours in a cell, on the same seeds."""

    cell: str
    method: str
    values: list[float]  # [%]
    paired: statistics.Paired
    p: float  # adjusted over the table

    @property
    def side(self) -> int:
        """1 if the method is better for sure, -1 if ours is, else 0."""
        if self.paired.pairs < LEAST_PAIRS:
            return 0
        low, high = self.paired.mean[1:]
        return 1 if low > 0.0 else -1 if high < 0.0 else 0


def compared(found: Sequence[CellRuns]) -> list[CellDifference]:
    """Return the differences of all methods to ours, cell by cell.

    Runs that did not end count with the time at which they were stopped.
    """
    rows = []
    for cell, members in groupby(found, lambda group: group.cell):
        by_method = {group.method: group.lines for group in members}
        ours = by_method.pop(REFERENCE, ())
        for method, lines in by_method.items():
            if values := _percentages(lines, ours):
                paired = statistics.paired(values, [0.0] * len(values))
                rows.append((cell, method, values, paired))
    adjusted = statistics.holm([paired.p for *_, paired in rows])
    return [CellDifference(*row, p) for row, p in zip(rows, adjusted, strict=True)]


def differences(found: Sequence[CellRuns]) -> Table:
    """Return by how much other methods are better than ours."""
    return [["cell", "method", "pairs", "better than ours [%]", "p (Holm)"]] + [
        [row.cell, row.method, str(row.paired.pairs), interval(row.paired.mean), f"{row.p:.3f}"]
        for row in compared(found)
    ]


def _level(cell: Cell, axis: str) -> float:
    if axis == "outage":
        return (cell.until or math.inf) - cell.at if cell.outage else 0.0
    return float(getattr(cell, axis))


def _level_text(axis: str, level: float) -> str:
    if axis == "dead":
        return f"{level:.0%}"
    return f"{level:g}" if math.isfinite(level) else "for ever"


AXES = ("robots", "loss", "delay", "dead", "outage")


def axes_of(cells: Sequence[Cell]) -> Iterator[tuple[str, str, dict[float, str]]]:
    """Yield world, what varies, and the name of the cell at each level, for two levels or more."""
    for scenario in dict.fromkeys(cell.scenario for cell in cells):
        members = [cell for cell in cells if cell.scenario == scenario]
        for axis in AXES:
            levels: dict[float, str] = {}
            for cell in members:
                varied = cell.name == cell.twin or _level(cell, axis) > 0.0
                others = any(_level(cell, other) for other in AXES[1:] if other != axis)
                rest = (
                    cell.lidar, cell.mission, cell.fleet, cell.actors, cell.split, cell.joins,
                    cell.leaves, cell.blocked, cell.label,
                )  # fmt: skip
                if varied and not others and not any(rest):
                    levels.setdefault(_level(cell, axis), cell.name)
            if len(levels) > 1:
                yield Path(scenario).stem, axis, levels


def sides(cells: Sequence[Cell], found: Sequence[CellRuns]) -> Table:
    """Return at which levels a centre is ahead of ours for sure, and ours of it."""
    table = [["world", "varied", "centre", "it is ahead at", "ours ahead at", "from, ahead"]]
    rows = compared(found)
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
            sure = {lv: row.values for lv, row in known.items() if len(row.values) >= LEAST_PAIRS}
            change = statistics.change_of_sides(sure)
            text = "–"
            if change is not None:
                last = known[max(sure)].paired.mean.estimate
                who = "the centre" if last > 0.0 else "ours"
                at, low, high = (_level_text(axis, level) for level in change)
                text = f"{who} from {at} [{low}, {high}]"
            table.append([world, axis, method, won, lost, text])
    return table


def critical_sizes(cells: Sequence[Cell], found: Sequence[CellRuns]) -> Table:
    """Return from which size on more robots bring no more, and the throughput there."""
    methods = list(dict.fromkeys(group.method for group in found))
    table = [["world", *methods]]
    by_name = {(group.cell, group.method): group for group in found}
    for world, axis, levels in axes_of(cells):
        if axis == "robots":
            texts = [
                _critical({n: by_name[name, method] for n, name in levels.items()
                           if (name, method) in by_name})
                for method in methods
            ]  # fmt: skip
            table.append([world, *texts])
    return table


def _critical(members: Mapping[float, CellRuns]) -> str:
    if len(members) < 2 or not all(group.is_lifelong for group in members.values()):
        return "–"
    size = statistics.critical_size(
        {int(n): {line.seed: line.gain for line in g.lines} for n, g in members.items()},
        {int(n): {line.seed: line.is_success for line in g.lines} for n, g in members.items()},
    )
    if size.estimate == 0.0:
        return f"below {min(members):g}"
    largest = "≥ " if size.estimate == max(members) else ""
    span = f" [{size.low:g}, {size.high:g}]"
    return f"{largest}{size.estimate:g}{span}: {members[size.estimate].throughput():.0f}/h"


def dips(cells: Sequence[Cell], found: Sequence[CellRuns]) -> Table:
    """Return how far runs fall behind their undisturbed twins of the same seed."""
    table = [[
        "change", "method", "pairs", "worst minute lacks", "most orders behind", "order minutes",
        "recovered after (median)", "contacts",
    ]]  # fmt: skip
    by_name = {(group.cell, group.method): group for group in found}
    for cell in cells:
        for method in dict.fromkeys(group.method for group in found):
            group, twin = by_name.get((cell.name, method)), by_name.get((cell.twin, method))
            if cell.name != cell.twin and group is not None and twin is not None:
                row = _dip(cell, group, twin)
                if row:
                    table.append([cell.name.partition(", ")[2], method, *row])
    return table


def short_dips(table: Table) -> Table:
    """Return the most orders behind and the time to recover, a row per change."""
    methods = list(dict.fromkeys(row[1] for row in table[1:]))
    texts = {(row[0], row[1]): f"{row[4]}, {row[6]}" for row in table[1:]}
    changes = dict.fromkeys(row[0] for row in table[1:])
    return [["orders behind at worst, and time to recover", *methods]] + [
        [change, *(texts.get((change, method), "–") for method in methods)] for change in changes
    ]


def _dip(cell: Cell, group: CellRuns, twin: CellRuns) -> list[str]:
    known = {line.seed: line for line in twin.lines}
    found = [
        statistics.dip_of(
            (line.created, line.done), (other.created, other.done), int(cell.at / STEP), STEP
        )
        for line in group.lines
        if (other := known.get(line.seed)) is not None
        and line.created and line.done and other.created and other.done
    ]  # fmt: skip
    if not found:
        return []
    depth, behind, area = (
        statistics.bootstrap_mean([dip[field] for dip in found]) for field in range(3)
    )
    curve = statistics.kaplan_meier(
        [dip.recovery for dip in found], [dip.has_recovered for dip in found]
    )
    return [
        str(len(found)), f"{depth.estimate:.0%}", interval(behind, "{:.1f}"),
        interval(area, "{:.0f}"),
        f"{curve.median:.0f} s" if math.isfinite(curve.median) else "not in time",
        str(group.contacts),
    ]  # fmt: skip


def profiles(found: Sequence[CellRuns]) -> Table:
    """Return the share of instances that each method does within a factor of the best one."""
    best: dict[tuple[str, int], float] = {}
    for group in found:
        for line in group.lines:
            if line.is_success:
                key = group.cell, line.seed
                best[key] = max(best.get(key, -math.inf), line.gain)
    table = [["method", "instances", *(f"within {factor:g}" for factor in FACTORS)]]
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
            table.append([method, str(len(ratios)), *(f"{share:.0%}" for share in shares)])
    return table


def _ratio(line: StudyLine, best: float) -> float:
    """Return how many times worse than the best a run is; inf if it failed."""
    if not line.is_success:
        return math.inf
    if line.per_hour is None:
        return line.gain / best
    return best / line.gain if line.gain else math.inf


def details(found: Sequence[CellRuns]) -> Table:
    """Return everything that is known of each cell and method."""
    table = [[
        "cell", "method", "runs", "successful (95 %)", "contacts", "makespan, median [s]",
        "interquartile mean", "worst 5 %", "gap to the bound", "per hour (95 %)", "lead time [s]",
        "CPU ms per robot-second", "longest decision of the centre [ms]",
        "radio bytes per robot-second",
    ]]  # fmt: skip
    for group in found:
        lines = group.lines
        values = [line.time if line.per_hour is None else line.per_hour for line in lines]
        share = statistics.wilson(group.succeeded, len(lines))
        gap = _gap(lines)
        rate = statistics.bootstrap_mean(values)
        table.append([
            group.cell, group.method, str(len(lines)),
            f"{share.estimate:.0%} ({share.low:.0%} to {share.high:.0%})",
            _contacts(lines), "–" if group.is_lifelong else _seconds(group.median()),
            f"{statistics.interquartile_mean(values):.0f}",
            _tail([-value for value in values] if group.is_lifelong else values),
            "–" if gap is None else f"{gap:.0%}",
            interval(rate, "{:.0f}") if group.is_lifelong else "–",
            _mean([line.lead_time for line in lines], 0),
            _mean([line.cpu_ms_per_robot_second for line in lines]),
            _largest([line.longest_decision_ms for line in lines]),
            _mean([line.bytes_per_robot_second for line in lines], 0),
        ])  # fmt: skip
    return table


def _contacts(lines: Sequence[StudyLine]) -> str:
    touched = sum(line.contacts > 0 for line in lines)
    if touched:
        return f"{sum(line.contacts for line in lines)} in {touched}"
    return f"0 (< {statistics.bound_of_zero(len(lines)):.1%} at 95 %)"


def _tail(values: Sequence[float]) -> str:
    ordered = sorted(values)
    return f"{abs(ordered[min(len(ordered) - 1, math.ceil(0.95 * len(ordered)) - 1)]):.0f}"


def _mean(values: Sequence[float | None], digits: int = 2) -> str:
    known = [value for value in values if value is not None]
    return f"{sum(known) / len(known):.{digits}f}" if known else "–"


def _largest(values: Sequence[float | None]) -> str:
    known = [value for value in values if value is not None]
    return f"{max(known):.0f}" if known else "–"


def _seconds(value: float) -> str:
    return f"{value:.0f}" if math.isfinite(value) else "never"


def interval(value: statistics.Interval, form: str = "{:+.0f}") -> str:
    """Return an estimate with its interval as text."""
    estimate, low, high = (form.format(number) for number in value)
    return estimate if math.isnan(value.low) else f"{estimate} [{low}, {high}]"
