"""docs/results.md: what was measured, in tables that are made from `benchmarks/results` alone."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path
from typing import Annotated

import msgspec
import typer

from benchmarks.app import benchmarks_app
from benchmarks.measured_runs import BASELINE_LIMIT, PARTS, SCALE, Kept, measure, read_part
from benchmarks.scale.result import ScaleResult
from benchmarks.scale.row import GRAPH_COLUMNS, HARNESS_COLUMNS, rows_of
from swarm_bench.halls.halls import NONE, TROUBLES
from swarm_bench.runs.document import replace_part, table_line
from swarm_bench.runs.result import RunResult
from swarm_bench.suite.command import Cluster, Jobs, new_console
from swarm_bench.suite.summary import Row, summarise
from swarm_bench.suite.table import contacts_text, number
from swarm_common.model.errors import UnknownNameError

ROOT = Path(__file__).resolve().parents[1]
PAGE = ROOT / "docs" / "results.md"
Columns = Mapping[str, Callable[[Row], str]]
HEAD = """\
# Results

Every table on this page is made by `python -m benchmarks results` from `benchmarks/results/`.
Times are simulated seconds unless a column says otherwise. The terms:

- **contacts**: episodes in which a robot touches a robot, a wall, an obstacle or a person;
- **makespan**: time of the last goal, median [smallest..largest] of the runs that reached every
  goal; a run ends without success when nobody reaches a goal for 600 s;
- **longest wait**: time that one robot stood because of others, or held, at most in any run;
- **clearance**: smallest true distance of any robot from anything.
"""


def page() -> str:
    """Return the page; a table without results is left out."""
    parts = [
        HEAD,
        comparison_part(read_part("rows"), read_part("baselines")),
        rows_part(read_part("rows")),
        halls_part(read_part("halls")),
        graph_part(read_part("graph")),
        scale_part(read_part(SCALE)),
    ]
    return "\n".join(part for part in parts if part)


def comparison_part(ours: Sequence[Kept], others: Sequence[Kept]) -> str:
    """Return our method beside DWA and ORCA, a row per scenario and size."""
    if not others:
        return ""
    cells: dict[tuple[str, int], dict[str, str]] = {}
    for row in summarise(line.result for line in (*ours, *others)):
        place = row.label, row.first.robots
        cells.setdefault(place, {}).setdefault(row.first.method, comparison_cell(row))
    text = table(("scenario", "robots", "this project", "DWA alone", "ORCA"), 1)
    for (label, robots), found in sorted(cells.items()):
        if "ours" in found and len(found) > 1:
            texts = (found.get(method, "-") for method in ("ours", "dwa", "orca"))
            text += table_line([label, str(robots), *texts])
    minutes = BASELINE_LIMIT / 60.0
    return f"""\
## Compared with local avoidance

All three methods run in the same simulator, with the same starts, goals and seeds. A cell has the
goals reached, the median makespan of the complete runs, contacts if any, and the number of runs
where it is not 10. Baselines take long where they lock up: they begin no further seed after
{minutes:.0f} minutes of one cell, and rows without a baseline are left out. DWA sees the true
circles of the robots in sight; ORCA hears the same beacons as our robots
([the methods](comparison.md)).

{text}
{origin_line((*ours, *others), "rows", "baselines")}"""


def comparison_cell(row: Row) -> str:
    """Return what one method reached in a scenario."""
    share = 100.0 * row.goals_reached / row.goals_sent
    text = f"{share:.0f} %" if row.goals_reached in (0, row.goals_sent) else f"{share:.1f} %"
    if row.makespan_median is not None:
        text += f", {row.makespan_median:.0f} s"
        if len(row.makespans) < len(row.runs):
            text += f" ({len(row.makespans)} of {len(row.runs)} runs)"
    if row.collisions:
        text += f", {contacts_text(row.collisions)}"
    return text if len(row.runs) == 10 else f"{text}; {len(row.runs)} seeds"


ROW_COLUMNS: Columns = {
    "scenario": lambda row: row.label,
    "robots": lambda row: str(row.first.robots),
    "seeds": lambda row: str(len(row.runs)),
    "contacts": lambda row: str(row.collisions),
    "goals": lambda row: f"{row.goals_reached}/{row.goals_sent}",
    "makespan": lambda row: row.makespan_text,
    "goals per minute": lambda row: number(row.median("throughput_per_minute"), 1),
    "longest wait": lambda row: number(row.most("wait_worst"), 0),
    "clearance [m]": lambda row: number(row.least("min_clearance")),
}


def rows_part(kept: Sequence[Kept]) -> str:
    """Return our method in every scenario, in the bench."""
    if not kept:
        return ""
    return f"""\
## Scenarios

In the bench, without the ROS graph: kinematic drives with 2 % noise, and LiDARs where people walk
or robots are dead. {sentence(kept)}

{rows_table(kept)}
{origin_line(kept, "rows")}"""


HALL_COLUMNS: Columns = {
    "halls": lambda row: str(len(row.runs)),
    "contacts": lambda row: str(row.collisions),
    "goals": lambda row: f"{row.goals_reached}/{row.goals_sent}",
    "complete": lambda row: str(complete(row.runs)),
    "conditions hold": lambda row: str(len(promised(row.runs))),
    "of these complete": lambda row: str(complete(promised(row.runs))),
    "makespan": lambda row: row.makespan_text.partition(",")[0],
    "longest wait": lambda row: number(row.most("wait_worst"), 0),
}


def halls_part(kept: Sequence[Kept]) -> str:
    """Return random halls by size and by trouble."""
    if not kept:
        return ""
    runs = [line.result for line in kept]
    groups: dict[str, list[RunResult]] = {}
    for run in sorted(runs, key=lambda run: run.robots):
        groups.setdefault(f"{run.robots} robots", []).append(run)
    for trouble in TROUBLES:
        label = "no trouble" if trouble == NONE else trouble
        groups[label] = [r for r in runs if (r.scenario.partition(", ")[2] or NONE) == trouble]
    text = table(("halls with", *HALL_COLUMNS), 1)
    for label, chosen in groups.items():
        if chosen:
            row = Row(tuple(chosen), None)
            text += table_line([label, *(column(row) for column in HALL_COLUMNS.values())])
    slow = [run for run in runs if run.goals_reached < run.goals_sent]
    predicted = sum(bool(run.no_guarantee) for run in slow)
    limit = f"{len(slow)} of {len(runs)} halls took longer than an hour"
    if slow:
        limit += f"; {'all' if predicted == len(slow) else predicted} of them had been predicted"
    return f"""\
## Random halls

Each seed is a hall with rooms, doors, aisles and stations, a mission, and in every second one a
trouble: dead robots, a bad radio, people, or two models of robots. *Conditions* are those that are
checked before a run ([conditions](liveness.md#conditions)). {limit}.

{text}
{origin_line(kept, "halls")}"""


def graph_part(kept: Sequence[Kept]) -> str:
    """Return our method on the ROS graph."""
    if not kept:
        return ""
    return f"""\
## On the ROS graph

`swarm-up` with a process per robot, rigid bodies on wheels, and LiDARs. {sentence(kept)}

{rows_table(kept)}
{origin_line(kept, "graph")}"""


def scale_part(kept: Sequence[Kept]) -> str:
    """Return what a swarm costs by its size, with and without the ROS graph."""
    if not kept:
        return ""
    results = [msgspec.convert(line.data, ScaleResult) for line in kept]
    repeats = max(Counter((result.system, result.robots) for result in results).values())
    runs = "one run" if repeats == 1 else f"the median of {repeats} runs"
    names = ("robots", "start-up [s]", "real-time factor", "CPU [ms]", "world", "navigators")
    text = ""
    for title, system, columns, last in (
        ("A process per robot on the ROS graph:", "graph", GRAPH_COLUMNS, "USS per process [MB]"),
        ("The bench, one process:", "harness", HARNESS_COLUMNS, "RSS [MB]"),
    ):
        chosen = rows_of(result for result in results if result.system == system)
        shown = {name: columns[name] for name in (*names, last)}
        text += f"{title}\n\n{table(tuple(shown), 0)}"
        text += "".join(table_line(column(row) for column in shown.values()) for row in chosen)
        text += "\n"
    return f"""\
## Scale

The factory hall at work for 120 s, as fast as the machine allows. *Start-up* is wall time until
every navigator is active, *CPU* milliseconds of processor time per robot and simulated second, of
{runs}.

{text}{origin_line(kept, SCALE)}"""


def sentence(kept: Sequence[Kept]) -> str:
    """Return what all runs of a part have in common."""
    runs = [line.result for line in kept]
    reached, sent = sum(run.goals_reached for run in runs), sum(run.goals_sent for run in runs)
    contacts = sum(run.robot_robot + run.robot_world for run in runs)
    clearance = min(run.min_clearance for run in runs if run.min_clearance is not None)
    return (
        f"{len(runs)} runs reached {reached:,} of {sent:,} goals with {contacts_text(contacts)}; "
        f"the smallest clearance was {clearance:.3f} m."
    )


def complete(runs: Iterable[RunResult]) -> int:
    """Return how many runs reached every goal."""
    return sum(run.goals_reached == run.goals_sent for run in runs)


def promised(runs: Iterable[RunResult]) -> list[RunResult]:
    """Return the runs for which every condition holds."""
    return [run for run in runs if not run.no_guarantee]


def rows_table(kept: Sequence[Kept]) -> str:
    """Return a table with a line per scenario and size."""
    found = summarise(line.result for line in kept)
    text = table(tuple(ROW_COLUMNS), 1)
    for row in sorted(found, key=lambda row: (row.label, row.first.robots)):
        text += table_line(column(row) for column in ROW_COLUMNS.values())
    return text


def table(names: Sequence[str], left: int) -> str:
    """Return the head of a Markdown table; all but the first `left` columns are numbers."""
    ruler = ["---" if number < left else "---:" for number in range(len(names))]
    return table_line(names) + table_line(ruler)


def origin_line(kept: Sequence[Kept], *parts: str) -> str:
    """Return the line under a table: commit, machine, command."""
    commits = ", ".join(sorted({line.origin.commit for line in kept}))
    machines = "; ".join(sorted({line.origin.machine for line in kept}))
    measure = " ".join(f"--measure {part}" for part in parts)
    return f"Commit {commits}; {machines}; `python -m benchmarks results {measure}`.\n"


def readme_table() -> str:
    """Return the six rows of the README's table."""
    found = summarise(line.result for name in ("rows", "baselines") for line in read_part(name))
    chosen = (("circle", 20), ("corridor", 20), ("crossing", 24), ("station", 20),
              ("slim_blockage", 20), ("walkers", 20))  # fmt: skip
    text = table(("scenario, robots", "DWA alone", "ORCA", "this project"), 1)
    for name, robots in chosen:
        cells = {row.first.method: comparison_cell(row) for row in found
                 if (row.first.scenario, row.first.robots) == (name, robots)}  # fmt: skip
        text += table_line(
            [f"{name}, {robots}", *(cells.get(method, "-") for method in ("dwa", "orca", "ours"))]
        )
    return text


@benchmarks_app.command()
def results(
    measured: Annotated[
        list[str] | None,
        typer.Option("--measure", help=f"Part to run first: {', '.join((*PARTS, SCALE))}."),
    ] = None,
    jobs: Jobs = 1,
    cluster: Cluster = None,
) -> None:
    """Write docs/results.md and README's table from benchmarks/results; first run what lacks."""
    for name in measured or ():
        if name not in (*PARTS, SCALE):
            raise UnknownNameError("part", name, (*PARTS, SCALE))
        measure(name, jobs, new_console(), cluster)
    PAGE.write_text(page(), encoding="utf-8")
    replace_part(ROOT / "README.md", "results", readme_table())
