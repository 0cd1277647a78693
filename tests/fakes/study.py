"""Made-up lines of the study."""

import random
import textwrap
from collections.abc import Callable, Iterable, Mapping
from typing import Any

import msgspec

from swarm_bench.study.experiments import Experiment, load_experiments
from swarm_bench.study.trials.cell import Cell, StudyRun, settings_text
from swarm_bench.study.trials.line import StudyLine

SMALL = """
question: Which is faster?
methods: [ours, central-mapf]
cells:
  - {scenario: doorway, robots: 4, seconds: 300, quick: true}
  - {scenario: stream, robots: 4}
  - {scenario: stream, robots: 8}
  - {scenario: stream, robots: 4, leaves: 0.5, at: 20, until: 40}
hypotheses:
  - {says: The centre is faster., against: [central-mapf], expected: behind, cells: [doorway 4]}
  - says: More is carried by us.
    against: [central-mapf]
    expected: ahead
    cells: [stream 4, stream 8]
  - says: Who leaves is missed alike.
    against: [central-mapf]
    expected: equal
    cells: ["stream 4, 50% away 20 s"]
  - {says: More robots carry more., than: stream 4, expected: ahead, cells: [stream 8]}
  - says: Both succeed.
    against: [central-mapf]
    measure: success
    expected: ahead
    cells: [stream 4]
"""
STREAM = """
world: crossing
mission: stream
duration: 90
warm_up: 10
"""
ORDERS = """
spawn: all_rooms
orders:
  - {from: [east, north], to: [west, south], rate: 900}
"""


def write_experiments(folder, text: str = SMALL, **streams: str) -> dict[str, Experiment]:
    """Write an experiment with a scenario and a mission `stream`; return what is loaded."""
    (folder / "speed.yaml").write_text(textwrap.dedent(text), encoding="utf-8")
    for name, content in (("scenarios", STREAM), ("missions", ORDERS)):
        (folder / name).mkdir(exist_ok=True)
        (folder / name / "stream.yaml").write_text(streams.get(name, content), encoding="utf-8")
    return load_experiments(folder)


def made_up(run: StudyRun, value: float = 100.0, **changes: Any) -> StudyLine:
    """Return a line of a run that took or carried a value."""
    cell, ends = run.cell, run.cell.has_end
    values: dict[str, Any] = {
        "experiment": run.experiment, "cell": cell.name, "condition": cell.condition,
        "method": run.method, "seed": run.seed, "settings": settings_text(run.settings),
        "edition": "made up", "goals_sent": 4, "goals_reached": 4, "robot_robot": 0,
        "robot_world": 0, "makespan": value if ends else None,
        "stopped": cell.seconds if ends else 90.0, "bound": 50.0 if ends else None,
        "per_hour": None if ends else value, "batches": None if ends else [3, 3],
        "done": None if ends else [1] * 30, "worst_by_median": None if ends else 0.8,
        "stood_share": 0.25, "cpu": 1.0, "sim_time": 90.0, "cpu_ms_per_robot_second": 1.0,
        "tick_us_median": 40.0, "tick_us_p99": 90.0,
        "longest_decision_ms": 5.0 if "central" in run.method else None,
        "bytes_per_robot_second": 900.0,
        "trajectory_sha256": f"{cell.name} {run.method} {run.seed}", **changes,
    }  # fmt: skip
    return msgspec.convert(values, StudyLine)


def sampled(
    experiments: Mapping[str, Experiment],
    seeds: Iterable[int],
    value: Callable[[Cell, str, random.Random], float],
) -> list[StudyLine]:
    """Return lines of all cells and methods on seeds, of values by cell, method and chance."""
    return [
        made_up(
            StudyRun(name, cell, method, seed),
            value(cell, method, random.Random(f"{cell.name} {method} {seed}")),
        )
        for name, experiment in experiments.items()
        for cell in experiment.cells
        for method in experiment.methods_of(cell)
        for seed in seeds
    ]
