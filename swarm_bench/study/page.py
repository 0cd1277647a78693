"""docs/study.md and study.html: written from the lines and the experiments, by nothing else."""

from __future__ import annotations

import html
from collections.abc import Iterator, Mapping, Sequence

from swarm_bench.runs.methods import METHODS
from swarm_bench.study.experiments import Experiment, Settings, runs_of, settings_text
from swarm_bench.study.lines import StudyLine
from swarm_bench.study.tables import (
    CellRuns,
    contacts_of,
    critical_sizes,
    details,
    differences,
    dips,
    groups,
    profiles,
    results,
    short_dips,
    sides,
)
from swarm_bench.tables import BenchTable

TITLE = "Decentralised or central"
QUESTION = (
    "Is a swarm better off when each robot decides for itself, or when one centre decides for all? "
    "All methods share robots, starts, orders and noise."
)
TERMS = """\
A job with an end has a **makespan**. Tables give its median [s] (Kaplan-Meier: stopped runs stay
in), how many runs reached every goal, and the mean gap to a lower bound. In work without end, more
orders come than anybody can serve; 600 s are measured after 120 s. **Throughput** is orders, or
goals, per hour. A run **succeeds** if nothing touches and the work never jams. **Critical size**:
no larger swarm has 2 % more throughput, and 90 % of the runs succeed. **Ahead**: the 95 % interval
of the differences on equal seeds, 5 or more, excludes zero."""
THREATS = """\
All is simulated, in few worlds. The authors wrote both sides. The radio of orders is never split.
Robots of central-mapf sense nothing off the map."""
STYLE = (
    "body{font:15px/1.45 sans-serif;margin:2em auto;max-width:1200px;padding:0 1em}"
    "table{border-collapse:collapse}td,th{padding:2px 10px;border-bottom:1px solid #ccc;"
    "text-align:left}th{position:sticky;top:0;background:#f4f5f7}summary{cursor:pointer;"
    "font-weight:bold;margin:1em 0 .4em}"
)
FOLDED = ("Against the undisturbed twin", "Details", "Differences to ours", "Performance profile")
Section = tuple[str, Experiment, list[CellRuns]]


def markdown(
    experiments: Mapping[str, Experiment],
    lines: Sequence[StudyLine],
    *,
    quick: bool,
    command: str,
    settings: Mapping[str, Settings] | None = None,
) -> str:
    """Return docs/study.md.

    Args:
        lines: Results, of which those of other experiments are left out.
        quick: Whether it is the short edition.
        settings: Settings of the methods, as they were tuned.
    """
    sections = list(_sections(experiments, lines, settings))
    runs = [line for _, _, found in sections for group in found for line in group.lines]
    touched = f"Runs with contacts: {contacts_of(runs)}."
    parts = [f"# {TITLE}", QUESTION, *_ahead(sections), touched, "## Terms", TERMS]
    for name, experiment, found in sections:
        parts += [f"## {_title(name)}", experiment.question]
        parts += ["Expected before the first run:"]
        parts += ["\n".join(f"- {text}" for text in experiment.expected)]
        parts += [table.markdown().rstrip() for table in _short(experiment, found)]
    parts += ["## Limits", f"{THREATS} {_missing(experiments, lines, quick, settings)[0]}"]
    written = f"Written by `{command}`; study/study.html has every column."
    parts.append(f"{_tuned(settings)} {written}")
    return "\n\n".join(parts) + "\n"


def page(
    experiments: Mapping[str, Experiment],
    lines: Sequence[StudyLine],
    *,
    quick: bool,
    settings: Mapping[str, Settings] | None = None,
) -> str:
    """Return study.html: the tables with all columns, and what was not run."""
    parts = [
        f"<!doctype html><meta charset=utf-8><title>{TITLE}</title><style>{STYLE}</style>",
        f"<h1>{TITLE}</h1><p>{QUESTION}</p><p>{html.escape(TERMS.replace('**', ''))}</p>",
    ]
    sections = list(_sections(experiments, lines, settings))
    links = (f"<a href='#{name}'>{_title(name)}</a>" for name, _, _ in sections)
    parts.append(f"<p>{' · '.join(links)}</p>")
    for name, experiment, found in sections:
        parts += [f"<h2 id='{name}'>{_title(name)}</h2><p>{html.escape(experiment.question)}</p>"]
        tables = {
            "Results": results(found),
            "Who is ahead": sides(experiment.cells, found),
            "Critical sizes": critical_sizes(experiment.cells, found),
            "Against the undisturbed twin": dips(experiment.cells, found),
            "Details": details(found),
            "Differences to ours": differences(found),
            "Performance profile": profiles(found),
        }
        for title, table in tables.items():
            if table.rows:
                is_open = "" if title in FOLDED else " open"
                parts.append(
                    f"<details{is_open}><summary>{title}</summary>{table.html()}</details>"
                )
    text, missing = _missing(experiments, lines, quick, settings)
    parts += [f"<h2>Left out</h2><p>{text}", *(f"<br>{html.escape(name)}" for name in missing)]
    return "\n".join(parts) + "\n"


def _sections(
    experiments: Mapping[str, Experiment],
    lines: Sequence[StudyLine],
    settings: Mapping[str, Settings] | None,
) -> Iterator[Section]:
    """Yield each experiment with its lines, without those of other settings of a method."""
    texts = {method: settings_text(chosen) for method, chosen in (settings or {}).items()}
    for name, experiment in experiments.items():
        cells = {cell.name: rank for rank, cell in enumerate(experiment.cells)}
        methods = {method: rank for rank, method in enumerate(experiment.methods)}
        chosen = [
            line
            for line in lines
            if line.experiment == name
            and line.cell in cells
            and line.settings == texts.get(line.method, "")
        ]
        chosen.sort(key=lambda line: (cells[line.cell], methods.get(line.method, 99), line.seed))
        if chosen:
            yield name, experiment, groups(chosen)


def _ahead(sections: Sequence[Section]) -> Iterator[str]:
    """Yield who is ahead where, the centre first."""
    tables = [sides(experiment.cells, found) for _, experiment, found in sections]
    rows = [row for table in tables for row in table.rows if row[3:] != ["–", "–", "–"]]
    if rows:
        rows.sort(key=lambda row: row[3] == "–")
        yield "## Where the centre is better, and where it is not"
        yield BenchTable(tables[0].head, rows, tables[0].texts).markdown().rstrip()
    else:
        yield "No side is ahead for sure anywhere: too few runs."


def _short(experiment: Experiment, found: Sequence[CellRuns]) -> Iterator[BenchTable]:
    """Yield the tables of the document: of every experiment what says most."""
    critical = critical_sizes(experiment.cells, found)
    behind = dips(experiment.cells, found)
    if any(set(row[1:]) != {"–"} for row in critical.rows):
        yield critical
    elif behind.rows and all(group.is_lifelong for group in found):
        yield short_dips(behind)
    else:
        shown = {
            cell.name for cell in experiment.cells if not (cell.loss or cell.delay or cell.dead)
        }
        yield results([group for group in found if group.cell in shown])


def _missing(
    experiments: Mapping[str, Experiment],
    lines: Sequence[StudyLine],
    quick: bool,
    settings: Mapping[str, Settings] | None,
) -> tuple[str, list[str]]:
    """Return what of the edition has not been run: a sentence, and the cells without any run."""
    known = {line.key for line in lines}
    wanted = runs_of(experiments, quick=quick, settings=settings)
    cells = {run.key[:3] for run in wanted}
    missing = sorted(cells - {key[:3] for key in known})
    short = sum(run.key not in known for run in wanted)
    texts = []
    if quick:
        every = {run.key[:3] for run in runs_of(experiments, quick=False)}
        texts.append(f"Quick edition: {len(cells)} of {len(every)} cells.")
    if short:
        texts.append(
            f"Not run: {short} of {len(wanted)} runs; {len(missing)} cells have none (study.html)."
        )
    return " ".join(texts), [", ".join(key) for key in missing]


def _tuned(settings: Mapping[str, Settings] | None) -> str:
    if not settings:
        return "No method was tuned (`--tune`)."
    texts = [
        f"{method}: {settings_text(settings[method]) or 'its defaults'}"
        for method in METHODS
        if method in settings
    ]
    return f"Parameters, chosen with equal effort: {'; '.join(texts)}."


def _title(name: str) -> str:
    return html.escape(name.replace("_", " ").capitalize())
