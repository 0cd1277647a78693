"""Runs in random halls as Markdown: what was reached by size and trouble, and what was missed."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from swarm_bench.halls.halls import NONE, TROUBLES
from swarm_bench.runs.document import table_line
from swarm_bench.runs.result import RunResult
from swarm_bench.suite.summary import Row
from swarm_bench.suite.table import contacts_text, number

TOLD_LENGTH = 90  # characters of a condition in the list of what was missed


def halls_markdown(results: Sequence[RunResult]) -> str:
    """Return a table with a row per swarm size and trouble, and a list of the runs with flaws.

    Args:
        results: Results of runs in random halls, in any order.
    """
    runs = sorted(results, key=lambda run: run.seed)
    sizes = sorted({run.robots for run in runs})
    groups = {f"{size} robots": [r for r in runs if r.robots == size] for size in sizes}
    for trouble in TROUBLES:
        label = "no trouble" if trouble == NONE else trouble
        groups[label] = [run for run in runs if _trouble_of(run) == trouble]
    groups["all"] = runs
    text = table_line(["halls with", *COLUMNS])
    text += table_line(["---", *["---:"] * len(COLUMNS)])
    for label, chosen in groups.items():
        if chosen:
            row = Row(tuple(chosen), None)
            text += table_line([label, *(cell(row) for cell in COLUMNS.values())])
    flaws = [_flaw(run) for run in runs if not run.is_flawless]
    return "\n".join([text, *flaws])


def _trouble_of(run: RunResult) -> str:
    return run.scenario.partition(", ")[2] or NONE


COLUMNS: dict[str, Callable[[Row], str]] = {
    "runs": lambda row: str(len(row.runs)),
    "contacts": lambda row: str(row.collisions),
    "goals": lambda row: f"{row.goals_reached}/{row.goals_sent}",
    "complete": lambda row: str(_complete(row.runs)),
    "all conditions held": lambda row: str(len(_promised(row.runs))),
    "of these complete": lambda row: str(_complete(_promised(row.runs))),
    "makespan [s]": lambda row: row.makespan_text.partition(",")[0],
    "worst wait [s]": lambda row: number(row.most("wait_worst"), 0),
}


def _complete(runs: Sequence[RunResult]) -> int:
    return sum(run.goals_reached == run.goals_sent for run in runs)


def _promised(runs: Sequence[RunResult]) -> list[RunResult]:
    """Return the runs of which it was not said before they began that a condition fails."""
    return [run for run in runs if not run.no_guarantee]


def _flaw(run: RunResult) -> str:
    told = run.no_guarantee
    if len(told) > TOLD_LENGTH:
        told = told[:TOLD_LENGTH].rpartition(" ")[0] + " …"
    contacts = run.robot_robot + run.robot_world
    return (
        f"- {run.seed} ({run.robots} robots): {run.goals_reached} of {run.goals_sent} goals"
        + (f", **{contacts_text(contacts)}** ({run.first_collision})" if contacts else "")
        + (f"; told before: {told}" if told else "; **all conditions held**")
    )
