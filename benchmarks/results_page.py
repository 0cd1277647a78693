"""docs/results.md: what was measured, in tables that are made from `benchmarks/results` alone."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from pathlib import Path
from typing import Annotated

import typer

from benchmarks.app import benchmarks_app
from benchmarks.measured_runs import (
    BASELINE_LIMIT,
    PARTS,
    SCALE,
    measure,
    results_of,
    scale_results,
)
from benchmarks.scale.result import ScaleResult, rows_of, scale_table
from swarm_bench.halls.report import halls_table
from swarm_bench.runs.document import replace_part
from swarm_bench.suite.command import Cluster, Jobs, new_console
from swarm_bench.suite.summary import Row, summarise
from swarm_bench.suite.table import COLUMNS
from swarm_bench.tables import BenchTable, contacts_text
from swarm_common.model.errors import UnknownNameError
from swarm_run.record.run_record import RunRecord

ROOT = Path(__file__).resolve().parents[1]
PAGE = ROOT / "docs" / "results.md"
BENCH = """\
In the bench, without the ROS graph: kinematic drives with 2 % noise, and LiDARs where people walk
or robots are dead."""
GRAPH = "`swarm-up` with a process per robot, rigid bodies on wheels, and LiDARs."
SHOWN = (
    "scenario",
    "robots",
    "seeds",
    "contacts",
    "goals",
    "makespan [s]",
    "goals/min",
    "worst wait [s]",
    "clearance [m]",
)
HEAD = """\
# Results

Every table on this page is made by `python -m benchmarks results` from `benchmarks/results/`.
Times are simulated seconds unless a column says otherwise. The terms:

- **contacts**: episodes in which a robot touches a robot, a wall, an obstacle or a person;
- **makespan**: time of the last goal, median [smallest..largest] of the runs that reached every
  goal; a run ends without success when nobody reaches a goal for 600 s;
- **worst wait**: time that one robot stood because of others, or held, at most in any run;
- **clearance**: smallest true distance of any robot from anything.
"""


def page() -> str:
    """Return the page; a table without results is left out."""
    parts = [
        HEAD,
        comparison_part(results_of("rows"), results_of("baselines")),
        rows_part("Scenarios", BENCH, "rows"),
        halls_part(results_of("halls")),
        rows_part("On the ROS graph", GRAPH, "graph"),
        scale_part(scale_results()),
    ]
    return "\n".join(part for part in parts if part)


def comparison_part(ours: Sequence[RunRecord], others: Sequence[RunRecord]) -> str:
    """Return our method beside DWA and ORCA, a row per scenario and size."""
    if not others:
        return ""
    cells: dict[tuple[str, int], dict[str, str]] = {}
    for row in summarise((*ours, *others)):
        place = row.label, row.first.robots
        cells.setdefault(place, {}).setdefault(row.first.method, comparison_cell(row))
    rows = [
        [label, str(robots), *(found.get(method, "-") for method in ("ours", "dwa", "orca"))]
        for (label, robots), found in sorted(cells.items())
        if "ours" in found and len(found) > 1
    ]
    table = BenchTable(["scenario", "robots", "this project", "DWA alone", "ORCA"], rows)
    minutes = BASELINE_LIMIT / 60.0
    return f"""\
## Compared with local avoidance

All three methods run in the same simulator, with the same starts, goals and seeds. A cell has the
goals reached, the median makespan of the complete runs, contacts if any, and the number of runs
where it is not 10. Baselines take long where they lock up: after {minutes:.0f} minutes of one cell
they may begin no further seed, and rows without a baseline are left out. DWA sees the true circles
of the robots in sight; ORCA hears the same beacons as our robots ([the methods](comparison.md)).

{table.markdown()}
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


def rows_part(title: str, introduction: str, part: str) -> str:
    """Return our method in every scenario, in the bench or on the ROS graph."""
    runs = results_of(part)
    if not runs:
        return ""
    reached, sent = sum(run.goals_reached for run in runs), sum(run.goals_sent for run in runs)
    contacts = sum(run.robot_robot + run.robot_world for run in runs)
    clearance = min(run.min_clearance for run in runs if run.min_clearance is not None)
    rows = sorted(summarise(runs), key=lambda row: (row.label, row.first.robots))
    return f"""\
## {title}

{introduction} {len(runs)} runs reached {reached:,} of {sent:,} goals with \
{contacts_text(contacts)}; the smallest clearance was {clearance:.3f} m.

{BenchTable.of({name: COLUMNS[name] for name in SHOWN}, rows).markdown()}
{origin_line(runs, part)}"""


def halls_part(runs: Sequence[RunRecord]) -> str:
    """Return random halls by size and by trouble."""
    if not runs:
        return ""
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

{halls_table(runs).markdown()}
{origin_line(runs, "halls")}"""


def scale_part(results: Sequence[ScaleResult]) -> str:
    """Return what a swarm costs by its size, with and without the ROS graph."""
    if not results:
        return ""
    repeats = max(Counter((result.system, result.robots) for result in results).values())
    runs = "one run" if repeats == 1 else f"the median of {repeats} runs"
    names = ("start-up [s]", "real-time factor", "CPU [ms]", "world", "navigators")
    text = ""
    for title, system, last in (
        ("A process per robot on the ROS graph:", "graph", "USS per process [MB]"),
        ("The bench, one process:", "harness", "RSS [MB]"),
    ):
        rows = rows_of(result for result in results if result.system == system)
        text += f"{title}\n\n{scale_table(rows, (*names, last), ('robots',)).markdown()}\n"
    return f"""\
## Scale

The factory hall at work for 120 s, as fast as the machine allows. *Start-up* is wall time until
every navigator is active, *CPU* milliseconds of processor time per robot and simulated second, of
{runs}.

{text}{origin_line(results, SCALE)}"""


def origin_line(kept: Sequence[RunRecord | ScaleResult], *parts: str) -> str:
    """Return the line under a table: commit, machine, command."""
    origins = [
        (one.code, one.machine) if isinstance(one, ScaleResult) else _origin_of(one) for one in kept
    ]
    commits, machines = (sorted(set(texts)) for texts in zip(*origins, strict=True))
    measure = " ".join(f"--measure {part}" for part in parts)
    return (
        f"Commit {', '.join(commits)}; {'; '.join(machines)}; "
        f"`python -m benchmarks results {measure}`.\n"
    )


def _origin_of(result: RunRecord) -> tuple[str, str]:
    assert result.origin is not None
    return result.origin.commit, result.origin.processor


def readme_table() -> str:
    """Return the six rows of the README's table."""
    found = summarise([*results_of("rows"), *results_of("baselines")])
    rows = []
    for place in (
        ("circle", 20),
        ("corridor", 20),
        ("crossing", 24),
        ("station", 20),
        ("slim_blockage", 20),
        ("walkers", 20),
    ):
        cells = {
            row.first.method: comparison_cell(row)
            for row in found
            if (row.first.scenario, row.first.robots) == place
        }
        methods = (cells.get(method, "-") for method in ("dwa", "orca", "ours"))
        rows.append([f"{place[0]}, {place[1]}", *methods])
    return BenchTable(["scenario, robots", "DWA alone", "ORCA", "this project"], rows).markdown()


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
