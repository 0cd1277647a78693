"""Verdicts of comparisons, and which runs they still need: the sequential rule of the protocol.

A comparison is looked at with 20, 30, ... 60 paired seeds. Each look has its own share of the error
of 5 %, so its interval is one of 99 %, and its p value counts five times before it is adjusted for
all comparisons of the experiment (Holm). It ends where the interval lies within the smallest effect
that matters (*equal*), or where it excludes zero and the adjusted p value is below 5 % (*ahead*,
*behind*), whatever later seeds say; with 60 seeds and neither it is *open*.
"""

from __future__ import annotations

import dataclasses
import itertools
import math
from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Literal, NamedTuple

from swarm_bench.statistics import (
    CONFIDENCE,
    Interval,
    holm,
    jackknifed_ratio,
    paired_mean,
    paired_shares,
)
from swarm_bench.study.experiments import (
    BUDGET,
    FIRST_SEED,
    LOOKS,
    Experiment,
    Experiments,
    PairedComparison,
    Verdict,
)
from swarm_bench.study.trials.cell import Cell, Settings, StudyRun, settings_text
from swarm_bench.study.trials.line import StudyLine

ERROR = 1.0 - CONFIDENCE
LOOK_CONFIDENCE = 1.0 - ERROR / len(LOOKS)
Sample = tuple[str, str]  # cell and method
Lines = Mapping[Sample, Mapping[int, StudyLine]]  # by seed


class StudyMeasure(NamedTuple):
    """A figure of a run by which methods are compared."""

    value: Callable[[StudyLine], float | None]
    sign: int  # 1 if more is better, else -1
    smallest: float  # effect that matters, as a share
    form: str  # of the figure
    # relative: differences by the larger mean; kept: of shares of the twins; event: of shares
    kind: Literal["relative", "kept", "event"] = "relative"

    def figures(
        self, side: Sequence[StudyLine], lines: Lines, twins: Mapping[str, str]
    ) -> list[float | None]:
        """Return the figure of each run; of what is kept, what each adds to it."""
        if self.kind != "kept":
            return [self.value(line) for line in side]
        whole = [lines[twins[line.cell], line.method][line.seed].per_hour or 0.0 for line in side]
        return [*jackknifed_ratio([self.value(line) or 0.0 for line in side], whole)]


MEASURES = {
    "throughput": StudyMeasure(lambda line: line.per_hour, 1, 0.03, "{:.0f}/h"),
    "makespan": StudyMeasure(lambda line: line.time, -1, 0.03, "{:.0f} s"),
    "kept": StudyMeasure(lambda line: line.per_hour, 1, 0.03, "{:.0%}", "kept"),
    "success": StudyMeasure(lambda line: float(line.is_success), 1, 0.01, "{:.0%}", "event"),
    "cost": StudyMeasure(lambda line: line.tick_us_median, -1, 0.2, "{:.0f} µs"),
}


@dataclass(frozen=True, slots=True)
class ComparisonResult:
    """What is known of a comparison.

    Attributes:
        look: Seeds at the look that decided it, else at the last one; 0 before the first.
        pairs: Different pairs of runs at that look.
        repeated: Pairs left out, since both their trajectories came before.
        means: Mean figure of each side.
        effect: How much better the first side is, as a share; positive is better.
        p: p value, adjusted for the number of looks; 1 before the first look.
        ended: Runs of each side that succeeded.
        adjusted: p value, adjusted for the other comparisons of the experiment, too.
    """

    comparison: PairedComparison
    look: int
    pairs: int
    repeated: int
    means: tuple[float, float]
    effect: Interval
    p: float
    ended: tuple[int, int]
    adjusted: float = 1.0

    @property
    def verdict(self) -> Verdict:
        """Verdict at that look."""
        smallest = MEASURES[self.comparison.measure].smallest
        if self.pairs < LOOKS[0] or not self.effect.is_known:
            return "open"
        if -smallest <= self.effect.low and self.effect.high <= smallest:
            return "equal"
        if self.adjusted < ERROR and self.effect.low > 0.0:
            return "ahead"
        return "behind" if self.adjusted < ERROR and self.effect.high < 0.0 else "open"

    @property
    def is_expected(self) -> bool:
        """Whether the verdict is what the hypothesis says."""
        expected = self.comparison.expected
        return self.verdict in (("ahead", "equal") if expected == "not behind" else (expected,))

    @property
    def matters(self) -> bool:
        """Whether the effect is one that matters."""
        return abs(self.effect.estimate) >= MEASURES[self.comparison.measure].smallest

    @property
    def target(self) -> int:
        """Seeds that it needs next, or has."""
        if not self.look:
            return LOOKS[0]
        larger = [look for look in LOOKS if look > self.look]
        return larger[0] if self.verdict == "open" and larger else self.look

    @property
    def reason(self) -> str:
        """Why it is open; empty where it is not."""
        if self.verdict != "open":
            return ""
        if not self.look:
            return "not run"
        if self.pairs < LOOKS[0]:
            return f"{self.pairs} different pairs"
        more = " yet" if self.look < LOOKS[-1] else ""
        return f"{self.look} seeds do not decide{more}"


def by_sample(lines: Iterable[StudyLine]) -> dict[Sample, dict[int, StudyLine]]:
    """Return lines by cell, method and seed."""
    found: dict[Sample, dict[int, StudyLine]] = {}
    for line in lines:
        found.setdefault((line.cell, line.method), {})[line.seed] = line
    return found


def findings(
    name: str, experiment: Experiment, lines: Lines, twins: Mapping[str, str]
) -> list[ComparisonResult]:
    """Return what is known of all comparisons of an experiment, in their order.

    Args:
        name: Identifies the experiment in lines.
        twins: Name of the undisturbed cell by cell.
    """
    comparisons = experiment.all_comparisons(name)
    counts = [_paired_seeds(each, lines, twins) for each in comparisons]
    found = [_at(each, 0, lines, twins) for each in comparisons]
    for look in LOOKS:
        due = [
            index
            for index, count in enumerate(counts)
            if count >= look and found[index].verdict == "open"
        ]
        for index in due:
            found[index] = _at(comparisons[index], look, lines, twins)
        adjusted = holm([finding.p for finding in found])
        for index in due:
            found[index] = dataclasses.replace(found[index], adjusted=adjusted[index])
    return found


def needed(comparison: PairedComparison, twins: Mapping[str, str]) -> list[Sample]:
    """Return the samples whose lines a comparison needs."""
    samples = list(comparison.samples)
    if comparison.measure == "kept":
        samples += [(twins[cell], method) for cell, method in samples]
    return samples


def _paired_seeds(comparison: PairedComparison, lines: Lines, twins: Mapping[str, str]) -> int:
    """Return how many seeds from the first one on have all lines that a comparison needs."""
    samples = [lines.get(sample, {}) for sample in needed(comparison, twins)]
    seeds = itertools.count(FIRST_SEED)
    return sum(1 for _ in itertools.takewhile(lambda s: all(s in own for own in samples), seeds))


def _at(
    comparison: PairedComparison, look: int, lines: Lines, twins: Mapping[str, str]
) -> ComparisonResult:
    """Return what is known of a comparison at a look, not yet adjusted for the others."""
    seen, seeds = set[tuple[str, str]](), list[int]()
    samples = [lines.get(sample, {}) for sample in comparison.samples]
    for seed in range(FIRST_SEED, FIRST_SEED + look):
        run = (samples[0][seed].trajectory_sha256, samples[1][seed].trajectory_sha256)
        if run not in seen:
            seeds.append(seed)
        seen.add(run)
    sides = [[sample[seed] for seed in seeds] for sample in samples]
    measure = MEASURES[comparison.measure]
    figures = [measure.figures(side, lines, twins) for side in sides]
    pairs = [(a, b) for a, b in zip(*figures, strict=True) if a is not None and b is not None]
    effect, p = effect_of(pairs, measure)
    means = [math.fsum(side) / len(side) for side in zip(*pairs, strict=True)]
    ended = [sum(line.is_success for line in side) for side in sides]
    return ComparisonResult(
        comparison=comparison,
        look=look,
        pairs=len(pairs),
        repeated=look - len(seeds),
        means=(means[0], means[1]) if means else (math.nan, math.nan),
        effect=effect,
        p=min(1.0, len(LOOKS) * p),
        ended=(ended[0], ended[1]),
    )


def effect_of(
    pairs: Sequence[tuple[float, float]], measure: StudyMeasure
) -> tuple[Interval, float]:
    """Return by how much the first of each pair is better, as a share, and the p value of a look.

    A relative effect is a share of the larger of both means, so it lies between -1 and 1 however
    bad one side is.
    """
    if len(pairs) < 2:
        return Interval(math.nan), 1.0
    first, second = zip(*pairs, strict=True)
    if measure.kind == "event":
        return paired_shares(first, second, LOOK_CONFIDENCE)
    scale = max(sum(first), sum(second)) / len(pairs) if measure.kind == "relative" else 1.0
    differences = [measure.sign * (a - b) / (scale or 1.0) + 0.0 for a, b in pairs]  # no -0
    return paired_mean(differences, LOOK_CONFIDENCE)


def all_findings(experiments: Experiments, lines: Lines) -> dict[str, list[ComparisonResult]]:
    """Return what is known of all comparisons, by experiment."""
    twins = twins_of(experiments)
    return {name: findings(name, each, lines, twins) for name, each in experiments.items()}


def twins_of(experiments: Experiments) -> dict[str, str]:
    """Return the name of the undisturbed cell by cell."""
    return {cell.name: cell.twin for each in experiments.values() for cell in each.cells}


def judged(hypothesis_findings: Sequence[ComparisonResult]) -> str:
    """Return whether a hypothesis was right: as expected in all comparisons.

    It was wrong if one is decided otherwise by as much as matters.
    """
    others = [f for f in hypothesis_findings if not f.is_expected]
    if not others:
        return "right"
    return "wrong" if any(f.verdict != "open" and f.matters for f in others) else "open"


def due_runs(
    experiments: Experiments,
    lines: Collection[StudyLine],
    settings: Mapping[str, Settings],
    *,
    most_looks: int = len(LOOKS),
) -> list[StudyRun]:
    """Return the runs that the study needs next, in an order in which a part of them tells most.

    All runs of an experiment in one world with one seed follow each other: they compare times of
    the machine, whose speed changes from hour to hour. The n-th seed of a world waits in proportion
    to its cost and the square of n: what it adds to the knowledge of a mean falls like that.

    Args:
        lines: Lines of the study, of one edition.
        most_looks: Looks that a comparison gets; 1 for the dearest question: what at least.
    """
    known, twins = by_sample(lines), twins_of(experiments)
    spent = sum(line.cpu for line in lines) / 3600.0
    targets: dict[Sample, int] = {}
    for found in all_findings(experiments, known).values():
        for finding in found:
            most = LOOKS[min(most_looks, 1 if spent >= BUDGET else len(LOOKS)) - 1]
            for sample in needed(finding.comparison, twins):
                targets[sample] = max(targets.get(sample, 0), min(finding.target, most))
    groups: dict[tuple[str, str, int], list[StudyRun]] = {}
    for name, experiment in experiments.items():
        for cell in experiment.cells:
            methods = experiment.methods_of(cell)
            wanted = {m: targets.get((cell.name, m), LOOKS[0]) for m in methods}
            for number in range(max(wanted.values())):
                group = groups.setdefault((name, cell.scenario, number), [])
                group += _missing(name, cell, number, wanted, known, settings)

    def wait(group: tuple[str, str, int]) -> float:
        return sum(run.cost() for run in groups[group]) * (group[2] + 1) ** 2

    return [run for group in sorted(groups, key=wait) for run in groups[group]]


def _missing(
    name: str,
    cell: Cell,
    number: int,
    wanted: Mapping[str, int],
    known: Lines,
    settings: Mapping[str, Settings],
) -> list[StudyRun]:
    """Return the runs of a cell's n-th seed that are wanted and not known."""
    seed = FIRST_SEED + number
    return [
        StudyRun(name, cell, method, seed, settings.get(method, ()))
        for method, count in wanted.items()
        if number < count and seed not in known.get((cell.name, method), {})
    ]


def fitting_lines(
    experiments: Experiments, lines: Iterable[StudyLine], settings: Mapping[str, Settings]
) -> list[StudyLine]:
    """Return the lines of the study's cells as they are now, by methods as they were tuned."""
    cells = {
        (name, cell.name): (cell.condition, each.methods_of(cell))
        for name, each in experiments.items()
        for cell in each.cells
    }
    texts = {method: settings_text(chosen) for method, chosen in settings.items()}
    nothing: tuple[str, list[str]] = ("", [])
    found = []
    for line in lines:
        condition, methods = cells.get((line.experiment, line.cell), nothing)
        is_tuned = line.settings == texts.get(line.method, "")
        if line.condition == condition and line.method in methods and is_tuned:
            found.append(line)
    return found
