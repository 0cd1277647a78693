"""Runs in random halls as Markdown: what was reached by size and trouble, and what was missed."""

from __future__ import annotations

import operator
from collections.abc import Callable, Sequence

from swarm_bench.halls.halls import NONE, TROUBLES
from swarm_bench.suite.summary import Row
from swarm_bench.suite.table import COLUMNS
from swarm_bench.tables import BenchTable, contacts_text
from swarm_run.record.run_record import RunRecord

_seed = operator.attrgetter("seed")
TOLD_LENGTH = 90  # characters of a condition in the list of what was missed


def halls_markdown(results: Sequence[RunRecord]) -> str:
    """Return a table with a row per swarm size and trouble, and a list of the runs with flaws.

    Args:
        results: Results of runs in random halls, in any order.
    """
    flaws = [_flaw(run) for run in sorted(results, key=_seed) if not run.is_flawless]
    return "\n".join([halls_table(results).markdown(), *flaws])


def halls_table(results: Sequence[RunRecord]) -> BenchTable:
    """Return a table with a row per swarm size and trouble, and one of all."""
    runs = sorted(results, key=_seed)
    groups = {
        f"{size} robots": [run for run in runs if run.robots == size]
        for size in sorted({run.robots for run in runs})
    }
    for trouble in TROUBLES:
        label = "no trouble" if trouble == NONE else trouble
        groups[label] = [run for run in runs if _trouble_of(run) == trouble]
    groups["all"] = runs
    table = BenchTable.of(SHOWN, (Row(tuple(chosen), None) for chosen in groups.values() if chosen))
    labels = [label for label, chosen in groups.items() if chosen]
    rows = [[label, *row] for label, row in zip(labels, table.rows, strict=True)]
    return BenchTable(["halls with", *table.head], rows)


def _trouble_of(run: RunRecord) -> str:
    return run.scenario.partition(", ")[2] or NONE


SHOWN: dict[str, Callable[[Row], str]] = {
    "runs": COLUMNS["runs"],
    "contacts": COLUMNS["contacts"],
    "goals": COLUMNS["goals"],
    "complete": lambda row: str(_complete(row.runs)),
    "all conditions held": lambda row: str(len(_promised(row.runs))),
    "of these complete": lambda row: str(_complete(_promised(row.runs))),
    "makespan [s]": lambda row: row.makespan_text.partition(",")[0],
    "worst wait [s]": COLUMNS["worst wait [s]"],
}


def _complete(runs: Sequence[RunRecord]) -> int:
    return sum(run.goals_reached == run.goals_sent for run in runs)


def _promised(runs: Sequence[RunRecord]) -> list[RunRecord]:
    return [run for run in runs if not run.no_guarantee]


def _flaw(run: RunRecord) -> str:
    told = run.no_guarantee
    if len(told) > TOLD_LENGTH:
        told = told[:TOLD_LENGTH].rpartition(" ")[0] + " …"
    contacts = run.robot_robot + run.robot_world
    return (
        f"- {run.seed} ({run.robots} robots): {run.goals_reached} of {run.goals_sent} goals"
        + (f", **{contacts_text(contacts)}** ({run.first_collision})" if contacts else "")
        + (f"; told before: {told}" if told else "; **all conditions held**")
    )
