"""docs/study.md and study.html: written from the lines and the experiments, by nothing else."""

from __future__ import annotations

import html
from collections.abc import Iterator, Mapping, Sequence

from swarm_bench.runs.methods import TEAMS
from swarm_bench.study.experiments import Experiment, runs_of
from swarm_bench.study.lines import StudyLine
from swarm_bench.study.tables import (
    REFERENCE,
    CellRuns,
    Table,
    details,
    differences,
    groups,
    medians,
)

LEVEL = 0.05  # of p
TITLE = "Decentralised or central"
METHOD = (
    "Methods share starts, orders and noise per seed. Cells: median makespan [s] (Kaplan-Meier; "
    "runs that are stopped stay in), runs that reached every goal."
)
STYLE = "body{font:15px sans-serif;margin:2em}td,th{padding:2px 10px;border-bottom:1px solid #ccc}"


def markdown(
    experiments: Mapping[str, Experiment], lines: Sequence[StudyLine], *, quick: bool, command: str
) -> str:
    """Return docs/study.md.

    Args:
        lines: Results, of which those of other experiments are left out.
        quick: Whether it is the short edition.
    """
    parts = [f"# {TITLE}", METHOD]
    for name, experiment, found in _sections(experiments, lines):
        parts += [
            f"## {name.replace('_', ' ').capitalize()}",
            experiment.question,
            f"Expected: {experiment.hypothesis}",
            _markdown(medians(found)),
        ]
        parts += [text for text in (_winners(found), _certain(found)) if text]
    left = _left_out(experiments, lines, quick=quick)
    if left:
        parts.append(left)
    parts.append(f"Written by `{command}`; study/study.html has all columns and differences.")
    return "\n\n".join(parts) + "\n"


def page(experiments: Mapping[str, Experiment], lines: Sequence[StudyLine]) -> str:
    """Return study.html: the tables with all columns."""
    parts = [
        f"<!doctype html><meta charset=utf-8><title>{TITLE}</title><style>{STYLE}</style>",
        f"<h1>{TITLE}</h1><p>{html.escape(METHOD)}</p>",
    ]
    for name, experiment, found in _sections(experiments, lines):
        parts += [
            f"<h2>{html.escape(name)}</h2><p>{html.escape(experiment.question)}</p>",
            f"<p>Expected: {html.escape(experiment.hypothesis)}</p>",
            _html(details(found)),
            _html(differences(found)),
        ]
    return "\n".join(parts) + "\n"


def _sections(
    experiments: Mapping[str, Experiment], lines: Sequence[StudyLine]
) -> Iterator[tuple[str, Experiment, list[CellRuns]]]:
    for name, experiment in experiments.items():
        cells = {cell.name: rank for rank, cell in enumerate(experiment.cells)}
        methods = {method: rank for rank, method in enumerate(experiment.methods)}
        chosen = [line for line in lines if line.experiment == name and line.cell in cells]
        chosen.sort(key=lambda line: (cells[line.cell], methods.get(line.method, 99), line.seed))
        if chosen:
            yield name, experiment, groups(chosen)


def _winners(found: Sequence[CellRuns]) -> str:
    """Return in which cells a centre has the smaller median, and in which our rules have."""
    ours = {group.cell: group.median() for group in found if group.method == REFERENCE}
    texts = []
    for method in dict.fromkeys(group.method for group in found):
        medians_of = {group.cell: group.median() for group in found if group.method == method}
        both = [cell for cell in medians_of if cell in ours]
        if method in TEAMS and both:
            better = [cell for cell in both if medians_of[cell] < ours[cell]]
            texts.append(
                f"{method} has the smaller median in {len(better)} of {len(both)} cells"
                f"{': ' if better else ''}{'; '.join(better)}."
            )
    return " ".join(texts)


def _certain(found: Sequence[CellRuns]) -> str:
    """Return which differences to ours are certain after Holm's correction."""
    rows = differences(found)[1:]
    if not rows:
        return ""
    certain = [
        f"{cell}: {method} {value}" for cell, method, _, value, p in rows if float(p) < LEVEL
    ]
    return "Differences to ours [s] with p < 0.05 (Holm): " + ("; ".join(certain) or "none") + "."


def _left_out(
    experiments: Mapping[str, Experiment], lines: Sequence[StudyLine], *, quick: bool
) -> str:
    """Return which cells of the edition have no run, and how many of all are in it."""
    known = {line.key for line in lines}
    wanted = list(runs_of(dict(experiments), quick=quick))
    every = {run.key[:3] for run in runs_of(dict(experiments), quick=False)}
    missing = {run.key[:3] for run in wanted} - {key[:3] for key in known}
    short = sum(run.key not in known for run in wanted)
    text = ""
    if quick:
        cells = {run.key[:3] for run in wanted}
        text = f"Quick edition: {len(cells)} of {len(every)} cells. "
    if short:
        names = sorted({f"{cell} ({method})" for _, cell, method in missing})
        text += f"Not run: {short} of {len(wanted)} runs"
        text += f"; no run at all of {', '.join(names)}." if names else "."
    return text.strip()


def _markdown(table: Table) -> str:
    head, *rows = table
    lines = [head, ["---"] * len(head), *rows]
    return "\n".join(f"|{'|'.join(row)}|" for row in lines)


def _html(table: Table) -> str:
    head, *rows = table
    cells = "".join(f"<th>{html.escape(cell)}" for cell in head)
    body = "\n".join("<tr>" + "".join(f"<td>{html.escape(cell)}" for cell in row) for row in rows)
    return f"<table><tr>{cells}\n{body}</table>"
