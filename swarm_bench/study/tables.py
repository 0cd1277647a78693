"""From lines and findings to tables."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

from swarm_bench import statistics
from swarm_bench.statistics import Interval
from swarm_bench.study.experiments import (
    OURS,
    Experiment,
    Experiments,
    Hypothesis,
    Verdict,
    measure_of,
)
from swarm_bench.study.recovery import recovery_of
from swarm_bench.study.trials.cell import Cell
from swarm_bench.study.trials.line import STEP, StudyLine
from swarm_bench.study.verdicts import MEASURES, ComparisonResult, Lines
from swarm_bench.tables import BenchTable

CENTRE = "central-mapf"
NONE = "–"


@dataclass(frozen=True, slots=True)
class CellRuns:
    """All seeds of one method in one cell."""

    cell: Cell
    method: str
    lines: Sequence[StudyLine]

    @property
    def different(self) -> int:
        """Number of different trajectories."""
        return len({line.trajectory_sha256 for line in self.lines})

    @property
    def value(self) -> Interval:
        """Mean throughput [1/h], or restricted mean time [s], with Student's interval."""
        values = [line.time if self.cell.has_end else line.per_hour or 0.0 for line in self.lines]
        return statistics.student_mean(values)

    def mean(self, name: str) -> float | None:
        """Return the mean of a field over the lines that have it; None if none has."""
        values = [value for line in self.lines if (value := getattr(line, name)) is not None]
        return sum(values) / len(values) if values else None

    def most(self, name: str) -> float | None:
        """Return the largest value of a field; None if no line has it."""
        values = [value for line in self.lines if (value := getattr(line, name)) is not None]
        return max(values, default=None)

    @property
    def median(self) -> float:
        """Median makespan [s], in which stopped runs stay (Kaplan-Meier); inf if most were."""
        return statistics.kaplan_meier(
            [line.time for line in self.lines], [line.has_ended for line in self.lines]
        ).median

    @property
    def gap(self) -> Interval | None:
        """Restricted mean time by the least possible, less 1; None where that is not known."""
        gaps = [line.time / line.bound - 1.0 for line in self.lines if line.bound]
        return statistics.student_mean(gaps) if gaps else None


def runs_in(experiment: Experiment, lines: Lines) -> list[CellRuns]:
    """Return the lines of an experiment by cell and method, in its order; none without lines."""
    return [
        CellRuns(cell, method, [found[seed] for seed in sorted(found)])
        for cell in experiment.cells
        for method in experiment.methods_of(cell)
        if (found := lines.get((cell.name, method), {}))
    ]


def percent(effect: Interval) -> str:
    """Return an effect with its interval in percent; a dash without one."""
    scaled = Interval(100.0 * effect.estimate, 100.0 * effect.low, 100.0 * effect.high)
    return scaled.text("{:+.1f}") if effect.is_known else NONE


def p_text(p: float) -> str:
    """Return a p value."""
    return "<0.001" if p < 0.001 else f"{p:.3f}"


VERDICTS: dict[str, Callable[[ComparisonResult], str]] = {
    "cell": lambda row: row.comparison.cell,
    "against": lambda row: other_of(row),
    "means": lambda row: means_text(row),
    "better by, %": lambda row: percent(row.effect),
    "pairs": lambda row: str(row.pairs),
    "p": lambda row: p_text(row.adjusted) if row.pairs else NONE,
    "expected": lambda row: row.comparison.expected,
    "verdict": lambda row: row.verdict,
}
MORE: dict[str, Callable[[ComparisonResult], str]] = {
    "open, since": lambda row: row.reason,
    "measure": lambda row: row.comparison.measure,
    "pairs that came before": lambda row: str(row.repeated),
    "successful runs": lambda row: "{}, {}".format(*row.ended),
}


def means_text(finding: ComparisonResult) -> str:
    """Return the mean of both sides."""
    form = MEASURES[finding.comparison.measure].form
    return ", ".join(form.format(mean) for mean in finding.means) if finding.pairs else NONE


def other_of(finding: ComparisonResult) -> str:
    """Return what the first side of a comparison is compared with."""
    comparison = finding.comparison
    other = (
        comparison.base_method
        if comparison.cell == comparison.base_cell
        else f"its {comparison.base_cell}"
    )
    measure = comparison.measure
    return f"{other}, {measure}" if measure in ("kept", "success", "cost") else other


def by_hypothesis(
    experiments: Experiments, found: Mapping[str, Sequence[ComparisonResult]]
) -> list[tuple[Hypothesis, list[ComparisonResult]]]:
    """Return each hypothesis with its findings."""
    rows = []
    for name, experiment in experiments.items():
        left = list(found[name])
        for said in experiment.hypotheses:
            count = len(experiment.comparisons(name, said))
            rows.append((said, left[:count]))
            left = left[count:]
    return rows


def sentence(said: Hypothesis) -> str:
    """Return what a hypothesis says, marked if runs of development had been seen."""
    return f"{said.says}†" if said.since else said.says


def verdicts(
    hypotheses: Iterable[tuple[Hypothesis, Sequence[ComparisonResult]]],
    more: Mapping[str, Callable[[ComparisonResult], str]] | None = None,
) -> BenchTable:
    """Return all comparisons, each with the number of its hypothesis."""
    columns = VERDICTS | dict(more or {})
    head = ["", *columns]
    rows = [
        [f"H{number}", *(cell(finding) for cell in columns.values())]
        for number, (_, findings) in enumerate(hypotheses, 1)
        for finding in findings
    ]
    return BenchTable(head, rows, texts=("", "cell", "against", "means", "expected", "verdict"))


DETAILS: dict[str, Callable[[CellRuns], str]] = {
    "cell": lambda group: group.cell.name,
    "method": lambda group: group.method,
    "runs": lambda group: str(len(group.lines)),
    "different": lambda group: str(group.different),
    "successful (95 %)": lambda group: success_text(group.lines),
    "contacts": lambda group: contacts_text(group.lines),
    "failed": lambda group: str(sum(bool(line.failure) for line in group.lines)),
    "per hour (95 %)": lambda group: NONE if group.cell.has_end else group.value.text("{:.0f}"),
    "restricted mean [s] (95 %)": lambda group: (
        group.value.text("{:.0f}") if group.cell.has_end else NONE
    ),
    "median makespan [s]": lambda group: _seconds(group.median) if group.cell.has_end else NONE,
    "above the bound": lambda group: NONE if group.gap is None else percent(group.gap),
    "lead time [s]": lambda group: form(group.mean("lead_time"), "{:.0f}"),
    "stands": lambda group: form(group.mean("stood_share"), "{:.0%}"),
    "worst robot by median": lambda group: form(group.mean("worst_by_median"), "{:.2f}"),
    "CPU ms per robot-second": lambda group: form(group.mean("cpu_ms_per_robot_second"), "{:.2f}"),
    "decision µs": lambda group: form(group.mean("tick_us_median"), "{:.0f}"),
    "decision µs, 99 %": lambda group: form(group.mean("tick_us_p99"), "{:.0f}"),
    "centre ms per robot-second": lambda group: form(
        group.mean("centre_ms_per_robot_second"), "{:.3f}"
    ),
    "longest decision of the centre [ms]": lambda group: form(
        group.most("longest_decision_ms"), "{:.0f}"
    ),
    "decision of the centre [ms], 99 %": lambda group: form(
        group.mean("p99_decision_ms"), "{:.1f}"
    ),
    "bytes per robot-second": lambda group: form(group.mean("bytes_per_robot_second"), "{:.0f}"),
}
COSTS = (
    "method", "per hour (95 %)", "stands", "worst robot by median", "decision µs",
    "centre ms per robot-second", "decision of the centre [ms], 99 %", "bytes per robot-second",
)  # fmt: skip


def details(found: Sequence[CellRuns]) -> BenchTable:
    """Return everything that is known of each cell and method."""
    return BenchTable.of(DETAILS, found, texts=("cell", "method"))


def costs(found: Sequence[CellRuns]) -> BenchTable:
    """Return what a reader wants to know first of some cells."""
    columns = {"robots": lambda group: str(group.cell.robots)} | {
        name: DETAILS[name] for name in COSTS
    }
    return BenchTable.of(columns, found, texts=("method",))


def success_text(lines: Sequence[StudyLine]) -> str:
    """Return the share of successful runs with its interval."""
    share = statistics.wilson(sum(line.is_success for line in lines), len(lines))
    return f"{share.estimate:.0%} ({share.low:.0%} to {share.high:.0%})"


def contacts_text(lines: Sequence[StudyLine]) -> str:
    """Return contact episodes and runs with them; without any, what share may have them."""
    touched = sum(line.contacts > 0 for line in lines)
    if touched:
        return f"{sum(line.contacts for line in lines)} in {touched}"
    return f"0 (< {statistics.bound_of_zero(len(lines)):.1%} at 95 %)"


class KeptShare(NamedTuple):
    """Throughput that the runs of a method keep in a disturbed cell, by their twins' of a seed."""

    cell: Cell
    method: str
    share: Interval
    lost: float | None  # orders, mean
    recovered: float  # median time [s] after the end of the disturbance; nan without an end


def kept(experiments: Experiments, lines: Lines) -> list[KeptShare]:
    """Return what is kept in all disturbed cells with lines."""
    rows = []
    for experiment in experiments.values():
        for group in runs_in(experiment, lines):
            if measure_of(group.cell) != "kept":
                continue
            twins = lines.get((group.cell.twin, group.method), {})
            pairs = [(line, twins[line.seed]) for line in group.lines if line.seed in twins]
            throughput = [(line.per_hour or 0.0, twin.per_hour or 0.0) for line, twin in pairs]
            if pairs:
                shares = statistics.jackknifed_ratio(*zip(*throughput, strict=True))
                rows.append(_kept(group, pairs, statistics.student_mean(shares)))
    return rows


def _kept(
    group: CellRuns, pairs: Sequence[tuple[StudyLine, StudyLine]], share: Interval
) -> KeptShare:
    counted = [(line.done, twin.done) for line, twin in pairs if line.done and twin.done]
    lost = [sum(twin) - sum(done) for done, twin in counted]
    times = []
    if group.cell.until is not None:
        first = int(group.cell.until / STEP)
        times = [recovery_of(done, twin, first) for done, twin in counted]
    median = statistics.kaplan_meier(*zip(*times, strict=True)).median if times else math.nan
    mean = sum(lost) / len(lost) if lost else None
    return KeptShare(group.cell, group.method, share, mean, STEP * median)


def losses(found: Sequence[KeptShare]) -> BenchTable:
    """Return how much of the throughput is lost in each disturbed cell."""
    columns: dict[str, Callable[[KeptShare], str]] = {
        "cell": lambda row: row.cell.name,
        "method": lambda row: row.method,
        "throughput, %": lambda row: percent(loss_of(row.share)),
        "orders lost": lambda row: form(row.lost, "{:.0f}"),
        "recovered after": lambda row: time_text(row.recovered),
    }
    return BenchTable.of(columns, found, texts=("cell", "method"))


def time_text(time: float) -> str:
    """Return a time to recover [s]; a dash for nan."""
    if math.isnan(time):
        return NONE
    return f"{time:.0f} s" if math.isfinite(time) else "not in time"


def loss_of(share: Interval) -> Interval:
    """Return what a share of throughput is less than all of it, as a negative number."""
    return Interval(share.estimate - 1.0, share.low - 1.0, share.high - 1.0)


def form(value: float | None, text: str) -> str:
    """Return a value in a form; a dash for None."""
    return NONE if value is None else text.format(value)


def _seconds(value: float) -> str:
    return f"{value:.0f}" if math.isfinite(value) else "never"


class SizeVerdicts(NamedTuple):
    """Verdicts on throughput in a world, by the number of robots."""

    world: str
    by_size: Mapping[int, Verdict]  # ascending

    def sizes(self, verdict: Verdict) -> list[int]:
        """Return the numbers of robots with a verdict."""
        return [size for size, each in self.by_size.items() if each == verdict]

    @property
    def change(self) -> tuple[int, int] | None:
        """Decided numbers of robots between which the sides change, once; None without that."""
        decided = {size: each for size, each in self.by_size.items() if each in ("ahead", "behind")}
        pairs = itertools.pairwise(decided.items())
        changes = [(small, large) for (small, a), (large, b) in pairs if a != b]
        return changes[0] if len(changes) == 1 else None


def by_size(
    experiments: Experiments, findings: Iterable[ComparisonResult], other: str = CENTRE
) -> list[SizeVerdicts]:
    """Return where ours are ahead of a centre in worlds without anything else."""
    cells = {
        cell.name: cell
        for experiment in experiments.values()
        for cell in experiment.cells
        if measure_of(cell) == "throughput" and not (cell.lidar or cell.lanes)
    }
    worlds: dict[str, dict[int, Verdict]] = {}
    for finding in findings:
        each = finding.comparison
        is_one = each.measure == "throughput" and each.samples[0][1] == OURS
        if is_one and each.base_method == other and each.cell in cells:
            cell = cells[each.cell]
            worlds.setdefault(Path(cell.scenario).stem, {})[cell.robots] = finding.verdict
    return [SizeVerdicts(world, dict(sorted(found.items()))) for world, found in worlds.items()]


def sizes(found: Iterable[CellRuns]) -> dict[str, dict[str, dict[int, CellRuns]]]:
    """Return undisturbed cells without end by world, method and size, for worlds with any."""
    worlds: dict[str, dict[str, dict[int, CellRuns]]] = {}
    for group in found:
        if measure_of(group.cell) == "throughput" and not (group.cell.lidar or group.cell.lanes):
            world = worlds.setdefault(Path(group.cell.scenario).stem, {})
            world.setdefault(group.method, {})[group.cell.robots] = group
    return worlds
