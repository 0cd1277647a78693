"""The suite's tables as Markdown, from results and nothing else."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence

from swarm_bench.runs.document import table_line
from swarm_bench.runs.result import RunResult
from swarm_bench.runs.ros_run import ENGINE as ROS
from swarm_bench.runs.scenario import Target
from swarm_bench.suite.summary import Row, summarise
from swarm_bench.suite.table import contacts_text, number

OURS = "ours"
SHOWN = 20  # flaws that are listed one by one
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


def traffic_report(results: Sequence[RunResult], machine: str, command: str) -> str:
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
        text = BENCH.format(runs=_run_count(bench), engines=engines)
        parts.append(text + "\n" + _suite_table(bench))
    if graph:
        parts.append(GRAPH.format(runs=_run_count(graph)) + "\n" + _suite_table(graph))
    if others:
        parts.append(COMPARISON + "\n" + _comparison(bench + others))
    flaws = _flaws(bench + graph)
    if flaws:
        parts.append(FLAWS + "\n" + flaws)
    return "".join(parts)


def _run_count(rows: Iterable[Row]) -> int:
    return sum(len(row.runs) for row in rows)


COLUMNS: dict[str, Callable[[Row], str]] = {
    "scenario": lambda row: row.label,
    "robots": lambda row: str(row.first.robots),
    "seeds": lambda row: str(len(row.runs)),
    "collisions (robots + environment)": lambda row: row.collisions_text,
    "goals": lambda row: f"{row.goals_reached}/{row.goals_sent}",
    "makespan [s]": lambda row: row.makespan_text,
    "mean, 95 % [s]": lambda row: row.mean_text,
    "target [s]": lambda row: _target_text(row),
    "goals/min": lambda row: number(row.median("throughput_per_minute"), 1),
    "deadlocks": lambda row: row.deadlocks_text,
    "deadlocks resolved": lambda row: str(row.total("deadlocks_resolved")),
    "pushes": lambda row: str(row.total("pushes")),
    "retreats": lambda row: str(row.total("retreats")),
    "worst wait [s]": lambda row: number(row.most("wait_worst"), 0),
    "worst over median wait": lambda row: number(row.wait_ratio, 1),
    "clearance [m]": lambda row: number(row.least("min_clearance")),
    "near misses": lambda row: str(row.total("near_misses")),
    "held gap [m]": lambda row: number(row.least("min_held_slack")),
    "µs per tick": lambda row: number(row.median("tick_us_median"), 0),
}


def _suite_table(rows: Sequence[Row]) -> str:
    lines = [table_line(COLUMNS), table_line(["---", *["---:"] * (len(COLUMNS) - 1)])]
    lines += [table_line(cell(row) for cell in COLUMNS.values()) for row in rows]
    return "".join(lines)


def _target_text(row: Row) -> str:
    target = _target(row)
    if target.release is None:
        return "-"
    median = row.makespan_median
    text = f"≤ {target.release:.0f}"
    if target.stretch is not None:
        text += f", stretch {target.stretch:.0f}"
    if median is None or median > target.release:
        return f"{text}: missed"
    is_stretched = target.stretch is not None and median <= target.stretch
    return f"{text}: {'stretch met' if is_stretched else 'met'}"


def _target(row: Row) -> Target:
    if row.scenario is None:
        return Target()
    return row.scenario.targets.get(row.first.robots, Target())


def _comparison(rows: Sequence[Row]) -> str:
    """Return a table of methods, over the seeds that all methods of a line have in common."""
    methods = sorted({row.first.method for row in rows}, key=lambda name: (name == OURS, name))
    lines: dict[tuple[str, int], dict[str, Row]] = {}
    for row in rows:
        lines.setdefault((row.label, row.first.robots), {})[row.first.method] = row
    head = ["scenario", "robots", "seeds", *methods]
    text = table_line(head) + table_line(["---", *["---:"] * (len(head) - 1)])
    for (label, robots), by_method in lines.items():
        if len(by_method) < 2:
            continue
        seeds = set.intersection(*({run.seed for run in row.runs} for row in by_method.values()))
        cells = [
            _comparison_cell(by_method[method], seeds) if method in by_method else "-"
            for method in methods
        ]
        text += table_line([label, str(robots), str(len(seeds)), *cells])
    return text


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
    if len(lines) > SHOWN:
        lines[SHOWN:] = [f"- and {len(lines) - SHOWN} more\n"]
    return "".join(lines)
