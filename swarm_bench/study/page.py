"""docs/study.md, study.html and the protocol's tables: from the lines, and by nothing else."""

from __future__ import annotations

import html
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field

from swarm_bench.runs.methods import METHODS
from swarm_bench.study import figures, tables
from swarm_bench.study.experiments import Experiments
from swarm_bench.study.tables import CENTRE, CellRuns, KeptShare, percent
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
Both sides share robots, starts, orders and noise, seed by seed. Hypotheses, cells and rules were
[written down](../study/protocol.md) before the first run. *Better* is a share of the larger mean,
of ours against the other side: of throughput, of the restricted mean time of jobs with an end, or
of what is kept of the throughput of an undisturbed twin. Intervals and p values stand for all
looks, p values for all comparisons of an experiment, too. *Equal* is less than 3 %."""
THREATS = """\
All is simulated, in six worlds on flat floors. The same authors wrote both sides, and have worked
on our rules for longer, in these halls. The radio of orders is never split. No rule of ours is made
for robots that neither hear nor see each other. A restricted mean ends where runs are stopped. The
scale of a relative effect counts as known. Times of decisions are those of one machine with other
work on it; [performance](performance.md) has memory."""
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
MOST_NAMED = 3  # cells in a sentence


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
    def hypotheses(self) -> list[tuple[str, str, list[ComparisonResult]]]:
        """Experiment, sentence and findings of each hypothesis."""
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
        f"- H{number} **{verdict}**: {says}"
        for number, (says, verdict) in enumerate(tables.judgements(hypotheses), 1)
    ]
    parts = [
        f"# {TITLE}", QUESTION, " ".join(_answer(study)), HOW, *shown,
        "## Expected before the first run", "\n".join(judged_ones),
        "## Comparisons", tables.verdicts(hypotheses).markdown().rstrip(),
        *(["## In the hall", tables.costs(hall).markdown().rstrip()] if hall else []),
        "## Limits", f"{THREATS} {' '.join(_limits(study))}",
        f"{tuned_text(study.settings)} Written by `{command}` from {len(study.runs)} lines; "
        "study/study.html has every column.",
    ]  # fmt: skip
    return "\n\n".join(parts) + "\n"


def page(study: StudyState) -> str:
    """Return study.html: the tables with all columns."""
    parts = [
        HEAD,
        f"<h1>{TITLE}</h1><p>{QUESTION}</p><p><b>{html.escape(' '.join(_answer(study)))}</b></p>",
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
    edition = f" Edition {study.edition}." if study.edition else ""
    parts.append(f"<h2>Limits</h2><p>{html.escape(' '.join(_limits(study)) + edition)}</p>")
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
                says = f"{said.says} (after development)" if said.since else said.says
                row = [f"H{number}", says, each.cell, other, each.measure, each.expected]
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
        yield (
            f"Of {len(against)} comparisons with the centre that plans for all robots ({CENTRE}), "
            f"our rules are ahead in {counts['ahead']}, behind in {counts['behind']}, equal in "
            f"{counts['equal']}; {counts['open']} are open."
        )
    for side, sign in (("behind", 1.0), ("ahead", -1.0)):
        found = sorted(
            (each for each in against if each.verdict == side),
            key=lambda each: sign * each.effect.estimate,
        )
        if found:
            names = "; ".join(
                f"{each.comparison.cell} {percent(each.effect)} %" for each in found[:MOST_NAMED]
            )
            yield f"They are furthest {side} in {names}."
    yield from _who_has_more(study)
    results = Counter(judged(found) for _, _, found in study.hypotheses)
    yield (
        f"Of {sum(results.values())} expectations {results['right']} were right, "
        f"{results['wrong']} wrong, {results['open']} are open."
    )
    by_method: dict[str, list[StudyLine]] = {}
    for line in study.runs:
        by_method.setdefault(line.method, []).append(line)
    if by_method:
        texts = [
            f"{method} {tables.contacts_text(by_method[method])} of {len(by_method[method])} runs"
            f"{_where_touched(by_method[method])}"
            for method in METHODS
            if method in by_method
        ]
        yield f"Contacts: {'; '.join(texts)}."


def _where_touched(lines: Sequence[StudyLine]) -> str:
    cells = dict.fromkeys(line.cell for line in lines if line.contacts)
    return f" ({'; '.join(sorted(cells))})" if cells else ""


def _who_has_more(study: StudyState) -> Iterator[str]:
    """Yield where which side has the larger mean throughput, and from which size on."""
    always: dict[str, list[str]] = {}
    for found in tables.crossovers(study.experiments, study.lines):
        who = "our robots" if found.is_ours else "robots of the centre"
        if found.at is None:
            always.setdefault(who, []).append(found.world)
        else:
            yield f"In {found.world} {who} carry more from {found.at.text('{:g}')} robots on."
    for who, worlds in always.items():
        yield f"At every size {who} carry more in {', '.join(worlds)}."


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
