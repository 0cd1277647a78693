"""The suite's tables as Markdown, from results and nothing else."""

from __future__ import annotations

from collections.abc import Sequence

from swarm_bench.runs.ros_run import ENGINE as ROS
from swarm_bench.suite.summary import Row, summarise
from swarm_bench.suite.table import COLUMNS
from swarm_bench.tables import BenchTable, contacts_text
from swarm_run.record.run_record import RunRecord

OURS = "ours"
MOST_TOLD = 20  # flaws that are listed one by one
HEAD = """\
The tables were written by a command, none by hand:

```
{command}
```

Machine: {machine}.

- **Collisions**: contact episodes between robots + with the environment (walls, obstacles, people);
  also called contacts.
- **Makespan**: simulated seconds until the last goal was reached, median [smallest..largest] of
  the complete runs. A run in which nobody reaches a goal for 600 s counts as deadlocked and ends.
- **Mean**: of the makespans, with the 95 % interval of a bootstrap over seeds.
- **Deadlocks**: circles of robots that stood in each other's way for 30 s or more, and times of
  60 s in which nobody came nearer to a goal, as the simulator sees it.
- **Worst wait**: time for which the robot that waited most in any run stood because of others or
  held; over the wait of the median robot of its run, in the median of the runs.
- **Clearance**: smallest true distance of any robot from anything.
- **Near misses**: episodes in which a robot came nearer than 0.03 m to something without contact.
- **Held gap**: smallest distance between two robots with the space that they held, less the sum of
  their safety radii (`min_held_slack`); robots may be beside it, so down to -0.094 m is sound.
- **µs per tick**: of one navigator, all that it does in a tick, median.
"""
BENCH = """
## In the bench

World core and navigators in one process, {engines}; 2 % actuation noise and no LiDAR where the
scenario says nothing else; {runs} runs.
"""
GRAPH = """
## On the ROS graph

`swarm-up` with one process per robot, rigid-body physics and LiDARs; {runs} runs.
"""
COMPARISON = """
## Compared with local avoidance alone

Same bench, same starts, same goals, same seeds. `dwa`: a dynamic-window controller with global
replanning around the robots in sight, whose true circles it is given (LiDAR as well where the
scenario has it). `orca`: optimal reciprocal collision avoidance with the neighbours' true radii
from their beacons. Each cell: goals reached, contacts, makespan.
"""
ENGINES = {"planar": "planar engine", "bullet": "rigid-body engine"}
FLAWS = """
## Runs with a contact or a missed goal
"""


def traffic_report(results: Sequence[RunRecord], machine: str, command: str) -> str:
    """Return the document.

    Args:
        machine: Machine on which the runs were made, in one line.
    """
    rows = summarise(results)
    rows.sort(key=lambda row: (row.label, row.first.robots, row.first.method))
    bench = [row for row in rows if row.first.method == OURS and row.first.engine != ROS]
    graph = [row for row in rows if row.first.method == OURS and row.first.engine == ROS]
    others = [row for row in rows if row.first.method != OURS]
    parts = [HEAD.format(machine=machine, command=command)]
    if bench:
        engines = " and ".join(sorted({ENGINES[row.first.engine] for row in bench}))
        text = BENCH.format(runs=sum(len(row.runs) for row in bench), engines=engines)
        parts.append(text + "\n" + BenchTable.of(SHOWN, bench).markdown())
    if graph:
        parts.append(
            GRAPH.format(runs=sum(len(row.runs) for row in graph))
            + "\n"
            + BenchTable.of(SHOWN, graph).markdown()
        )
    if others:
        parts.append(COMPARISON + "\n" + _comparison(bench + others))
    flaws = _flaws(bench + graph)
    if flaws:
        parts.append(FLAWS + "\n" + flaws)
    return "".join(parts)


SHOWN = {name: COLUMNS[name] for name in COLUMNS if name not in ("method", "runs", "contacts")}


def _comparison(rows: Sequence[Row]) -> str:
    """Return a table of methods, over the seeds that all methods of a line have in common."""
    methods = sorted({row.first.method for row in rows}, key=lambda name: (name == OURS, name))
    lines: dict[tuple[str, int], dict[str, Row]] = {}
    for row in rows:
        lines.setdefault((row.label, row.first.robots), {})[row.first.method] = row
    cells = []
    for (label, robots), by_method in lines.items():
        if len(by_method) < 2:
            continue
        seeds = set.intersection(*({run.seed for run in row.runs} for row in by_method.values()))
        found = [
            _comparison_cell(by_method[method], seeds) if method in by_method else "-"
            for method in methods
        ]
        cells.append([label, str(robots), str(len(seeds)), *found])
    return BenchTable(["scenario", "robots", "seeds", *methods], cells).markdown()


def _comparison_cell(row: Row, seeds: set[int]) -> str:
    part = Row(tuple(run for run in row.runs if run.seed in seeds), row.scenario)
    if not part.runs:
        return "-"
    share = 100.0 * part.goals_reached / max(1, part.goals_sent)
    return f"{share:.0f} %, {contacts_text(part.collisions)}, {part.makespan_text}"


def _flaws(rows: Sequence[Row]) -> str:
    """Return a list of the flaws, empty without any."""
    lines = [
        f"- {row.label}, {run.robots} robots, seed {run.seed} ({run.engine}): "
        f"{contacts_text(run.robot_robot + run.robot_world)}, "
        f"goals {run.goals_reached}/{run.goals_sent}"
        + "".join(f"; {note}" for note in (run.breach, run.first_collision, run.first_miss) if note)
        + "\n"
        for row in rows
        for run in row.runs
        if not run.is_flawless
    ]
    if len(lines) > MOST_TOLD:
        lines[MOST_TOLD:] = [f"- and {len(lines) - MOST_TOLD} more\n"]
    return "".join(lines)
