"""docs/study.md, study.html and the protocol's tables: from the lines, and by nothing else."""

from __future__ import annotations

import html
import itertools
import math
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field

from swarm_bench.runs.methods import METHODS
from swarm_bench.statistics import bound_of_zero, wilson
from swarm_bench.study import figures, tables
from swarm_bench.study.experiments import Experiments, Hypothesis
from swarm_bench.study.tables import CENTRE, CellRuns, KeptShare
from swarm_bench.study.trials.cell import Settings, settings_text
from swarm_bench.study.trials.line import StudyLine
from swarm_bench.study.verdicts import (
    ComparisonResult,
    Lines,
    all_findings,
    by_sample,
    fitting_lines,
    judged,
)
from swarm_bench.tables import BenchTable

TITLE = "Decentralised or central"
QUESTION = (
    "Is a swarm better off when each robot decides for itself, or when one centre decides for all?"
)
HOW = """\
Both sides share robots, starts, orders and noise, seed by seed. Hypotheses, cells and rules are
[written down](../study/protocol.md) before the runs, those with † after runs of development.
*Better* is ours against the other side: of throughput and restricted mean time a share of the
larger mean; of what is kept of an undisturbed twin's throughput and of successful runs, percentage
points. Intervals and p values stand for all looks, p values for all comparisons of an experiment,
too. *Equal* is less than 3 % (success: 1 %, cost: 20 %). An expectation is *right* if all of its
comparisons end as expected, *wrong* if one ends otherwise by as much as that, else *open*."""
THREATS = """\
All is simulated, in six worlds on flat floors. The same authors wrote both sides, and have worked
on our rules for longer, in these halls. Ways of this centre lie on a lattice of four directions:
the cells with four robots show what that alone costs it. The hall's lanes were learned with our
robots, from its own orders on other seeds. Robots of central-mapf brake for what they see ahead;
driving slowly near people is a rule of ours. The centre's computing takes no simulated time. The
radio of orders is never split. A restricted mean ends where runs are stopped. The scale of a
relative effect counts as known. Times of decisions are those of one machine with other work on it;
[performance](performance.md) has memory."""
STYLE = (
    ":root{color-scheme:light dark}"
    "body{font:15px/1.45 sans-serif;margin:2em auto;max-width:1200px;padding:0 1em}"
    "table{border-collapse:collapse}td,th{padding:2px 10px;border-bottom:1px solid #8886;"
    "text-align:left}th{position:sticky;top:0;background:light-dark(#f4f5f7,#1f2429)}"
    "@media(max-width:900px){table{display:block;overflow-x:auto}}"
)
HEAD = (
    '<!doctype html><html lang=en><meta charset=utf-8><meta name=viewport content="width='
    f'device-width"><title>{TITLE}</title><style>{STYLE}</style>'
)


@dataclass(slots=True)
class StudyState:
    """Everything that the pages are written from.

    Attributes:
        experiments: Cells and hypotheses.
        settings: Settings of the methods, as they were tuned.
        left_out: Number of lines that do not count, by reason.
        edition: Edition of the lines that count.
    """

    experiments: Experiments
    settings: Mapping[str, Settings]
    left_out: Counter[str] = field(default_factory=Counter)
    edition: str = ""
    lines: Lines = field(default_factory=dict)
    findings: dict[str, list[ComparisonResult]] = field(default_factory=dict)

    @property
    def runs(self) -> list[StudyLine]:
        """The lines that count."""
        return [line for seeds in self.lines.values() for line in seeds.values()]

    @property
    def groups(self) -> list[CellRuns]:
        """Cells and methods with lines."""
        return [
            group
            for experiment in self.experiments.values()
            for group in tables.runs_in(experiment, self.lines)
        ]

    @property
    def kept(self) -> list[KeptShare]:
        """Throughput that is kept in disturbed cells."""
        return tables.kept(self.experiments, self.lines)

    @property
    def hypotheses(self) -> list[tuple[Hypothesis, list[ComparisonResult]]]:
        """Each hypothesis with its findings."""
        return tables.by_hypothesis(self.experiments, self.findings)


def study_of(
    experiments: Experiments, lines: Sequence[StudyLine], settings: Mapping[str, Settings]
) -> StudyState:
    """Return the study that lines make: those of one edition, of the cells as they are now."""
    fitting = fitting_lines(experiments, lines, settings)
    editions = Counter(line.edition for line in fitting)
    edition = max(editions, key=lambda name: (editions[name], name), default="")
    chosen = [line for line in fitting if line.edition == edition]
    study = StudyState(experiments, settings, edition=edition, lines=by_sample(chosen))
    if others := len(lines) - len(fitting):
        study.left_out["of other cells or settings"] = others
    if others := len(fitting) - len(chosen):
        study.left_out["of other editions of the code"] = others
    study.findings = all_findings(experiments, study.lines)
    return study


def pictures(study: StudyState) -> dict[str, str]:
    """Return the figures as SVG, by name."""
    return figures.drawn(study.groups, study.kept)


def markdown(study: StudyState, stem: str, command: str) -> str:
    """Return docs/study.md.

    Args:
        stem: Begins the names of the figures' files.
        command: Named as the one that writes it.
    """
    hypotheses = study.hypotheses
    shown = [
        f"![{text[0].upper()}{text[1:]}]({stem}_{name}.svg)" for name, text in figures.ALT.items()
    ]
    hall = [
        group for group in study.groups
        if group.cell.name in ("hall_stream 20", "hall_stream 50", "hall_stream 100")
    ]  # fmt: skip
    judged_ones = [
        f"- H{number} **{judged(found)}**: {tables.sentence(said)}"
        for number, (said, found) in enumerate(hypotheses, 1)
    ]
    parts = [
        f"# {TITLE}", QUESTION, " ".join(_answer(study)), _touches(study), _recoveries(study), HOW,
        *shown,
        "## Expected", "\n".join(judged_ones),
        "## Comparisons", tables.verdicts(hypotheses).markdown().rstrip(),
        *(["## In the hall", tables.costs(hall).markdown().rstrip()] if hall else []),
        "## Limits", f"{THREATS} {' '.join(_limits(study))}",
        f"{tuned_text(study.settings)} Written by `{command}` from {len(study.runs)} lines; "
        "study/study.html has every column, and their edition.",
    ]  # fmt: skip
    return "\n\n".join(filter(None, parts)) + "\n"


def summary(study: StudyState) -> str:
    """Return README's sentences on the study: the first two of its answer."""
    return " ".join(itertools.islice(_answer(study), 2))


def page(study: StudyState) -> str:
    """Return study.html: the tables with all columns."""
    parts = [
        HEAD,
        f"<h1>{TITLE}</h1><p>{QUESTION}</p><p><b>{html.escape(' '.join(_answer(study)))}</b></p>",
        f"<p>{html.escape(_touches(study))}</p>",
        "<h2>Comparisons</h2>",
        tables.verdicts(study.hypotheses, tables.MORE).html(),
    ]
    for name, experiment in study.experiments.items():
        title = html.escape(name.replace("_", " ").capitalize())
        parts.append(f"<h2>{title}</h2><p>{html.escape(experiment.question)}</p>")
        if found := tables.runs_in(experiment, study.lines):
            parts.append(tables.details(found).html())
    if kept := study.kept:
        parts += ["<h2>Against the undisturbed twin</h2>", tables.losses(kept).html()]
    parts.append(f"<h2>Limits</h2><p>{html.escape(' '.join(_limits(study)))}</p>")
    parts.append(f"<p>Edition {html.escape(study.edition or 'none')}.</p>")
    return "\n".join(parts) + "\n"


def protocol_part(experiments: Experiments) -> str:
    """Return the tables of cells and hypotheses for the protocol."""
    parts, number = [], 0
    for name, experiment in experiments.items():
        parts += [f"### {name.replace('_', ' ').capitalize()}", experiment.question]
        cells = [
            [cell.name, ", ".join(experiment.methods_of(cell)),
             f"{cell.seconds:g} s" if cell.has_end else ""]
            for cell in experiment.cells
        ]  # fmt: skip
        head = ["cell", "methods", "stopped at"]
        parts.append(BenchTable(head, cells, texts=head).markdown().rstrip())
        rows = []
        for said in experiment.hypotheses:
            number += 1
            for each in experiment.comparisons(name, said):
                other = each.base_method if each.cell == each.base_cell else each.base_cell
                row = [
                    f"H{number}",
                    tables.sentence(said),
                    each.cell,
                    other,
                    each.measure,
                    each.expected,
                ]
                rows.append(row)
        head = ["", "hypothesis", "cell", "against", "measure", "expected"]
        parts.append(BenchTable(head, rows, texts=head).markdown().rstrip())
    return "\n\n".join(parts)


def _answer(study: StudyState) -> Iterator[str]:
    """Yield the sentences that answer the question, as far as the lines do."""
    findings = [each for found in study.findings.values() for each in found]
    against = [each for each in findings if each.comparison.base_method == CENTRE]
    counts = Counter(each.verdict for each in against)
    if counts["open"] == len(against):
        yield f"No comparison with the centre ({CENTRE}) is decided yet."
    else:
        is_mixed = counts["ahead"] and counts["behind"]
        yield (
            f"{'Neither is better everywhere: of' if is_mixed else 'Of'} {len(against)} comparisons"
            f" with the centre that plans for all robots ({CENTRE}), our rules are ahead in "
            f"{counts['ahead']}, behind in {counts['behind']}, equal in {counts['equal']}; "
            f"{counts['open']} undecided."
        )
    yield from _by_world(tables.by_size(study.experiments, findings))
    differing = [each for each in against if each.verdict in ("ahead", "behind")]
    ranges = [
        f"in {words} {_range(found, unit)}"
        for measure, words, unit in (
            ("throughput", "throughput", "%"),
            ("makespan", "time", "%"),
            ("kept", "what is kept of it under faults and changes", "points"),
        )
        if (found := [each for each in differing if each.comparison.measure == measure])
    ]
    if ranges:
        yield f"Where they are ahead or behind, the difference is {', '.join(ranges)}."
    results = Counter(judged(found) for _, found in study.hypotheses)
    yield (
        f"Of {sum(results.values())} expectations, right: {results['right']}, "
        f"wrong: {results['wrong']}, open: {results['open']}."
    )


def _range(findings: Sequence[ComparisonResult], unit: str) -> str:
    """Return the smallest and the largest effect, each with its cell."""
    ordered = sorted(findings, key=lambda each: each.effect.estimate)
    ends = ordered if len(ordered) == 1 else (ordered[0], ordered[-1])
    return " to ".join(
        f"{100.0 * each.effect.estimate:+.0f} {unit} ({each.comparison.cell})" for each in ends
    )


def _touches(study: StudyState) -> str:
    """Return the sentence on contacts; empty without lines."""
    by_method: dict[str, list[StudyLine]] = {}
    for line in study.runs:
        by_method.setdefault(line.method, []).append(line)
    texts = [_contacts(method, by_method[method]) for method in METHODS if method in by_method]
    return f"Contacts: {'; '.join(texts)}." if texts else ""


def _recoveries(study: StudyState) -> str:
    """Return the sentence on times to recover; empty without any."""
    times: dict[str, set[float]] = {}
    for kept in study.kept:
        if not math.isnan(kept.recovered):
            times.setdefault(kept.method, set()).add(kept.recovered)
    texts = [
        f"{method} {' to '.join(map(tables.time_text, sorted({min(found), max(found)})))}"
        for method, found in times.items()
    ]
    said = "When what disturbed is over, nine tenths of the twin's throughput are back after"
    return f"{said} (median, by cell): {'; '.join(texts)}." if texts else ""


def _contacts(method: str, lines: Sequence[StudyLine]) -> str:
    """Return in which cells a method touched, and how often it may in the others."""
    cells: dict[str, dict[str, StudyLine]] = {}
    for line in lines:
        cells.setdefault(line.cell, {})[line.trajectory_sha256] = line
    texts, others = [], set[str]()
    for name, found in sorted(cells.items()):
        touched = [line for line in found.values() if line.contacts]
        if not touched:
            others |= found.keys()
            continue
        share = wilson(len(touched), len(found))
        count = sum(line.contacts for line in touched)
        texts.append(
            f"{count} in {len(touched)} of {len(found)} runs of {name} "
            f"({share.low:.0%} to {share.high:.0%})"
        )
    if others:
        other = "other " if texts else ""
        bound = f"0 in {len(others)} {other}different runs (< {bound_of_zero(len(others)):.1%})"
        texts.append(bound)
    return f"{method} {', '.join(texts)}"


def _by_world(found: Sequence[tables.SizeVerdicts]) -> Iterator[str]:
    """Yield in which worlds and with how many robots a side has more throughput."""
    parts = []
    for side in ("ahead", "equal", "behind"):
        worlds = [
            f"{each.world} with {', '.join(map(str, sizes))}"
            for each in found
            if (sizes := each.sizes(side))
        ]
        if worlds:
            parts.append(f"{side} in {', in '.join(worlds)} robots")
    if parts:
        yield f"Undisturbed and without end they are {'; '.join(parts)}."
    for each in found:
        if each.change:
            small, large = each.change
            yield f"In {each.world} the sides change between {small} and {large} robots."


def _limits(study: StudyState) -> Iterator[str]:
    """Yield what is open, repeated or left out."""
    findings = [each for found in study.findings.values() for each in found]
    reasons = Counter(each.reason for each in findings if each.reason)
    if reasons:
        texts = "; ".join(f"{count} {reason}" for reason, count in sorted(reasons.items()))
        yield f"Open comparisons: {sum(reasons.values())} of {len(findings)} ({texts})."
    groups = study.groups
    different = sum(group.different for group in groups)
    total = sum(len(group.lines) for group in groups)
    if different < total:
        yield f"The {total} runs have {different} different trajectories within their cells."
    for reason, count in study.left_out.items():
        yield f"{count} lines {reason} are left out."


def tuned_text(settings: Mapping[str, Settings]) -> str:
    """Return what was chosen for each method."""
    if not settings:
        return "No method was tuned: all have their defaults."
    texts = [
        f"{method}: {settings_text(settings[method]) or 'its defaults'}"
        for method in METHODS
        if method in settings
    ]
    return f"Parameters, chosen with equal effort: {'; '.join(texts)}."
