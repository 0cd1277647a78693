"""Work that a swarm does, counted instead of timed, so that a busy machine changes nothing.

`python -m tests.counted_work` writes what is counted today into counted_work.json; do it when a
change is meant to cost what it costs. tests/scenario/test_counted_work.py compares.
"""

import json
import os
import struct
import sys
import tempfile
import tracemalloc
from pathlib import Path
from typing import Any

from swarm_bench.runs.episode import RunOptions
from swarm_bench.runs.harness import Harness
from swarm_bench.runs.scenario import Scenario
from swarm_nav.planning.search import SearchSpace
from tests.fakes.counting.sitecustomize import NAMES, SIZE
from tests.fakes.programs import run_program

ROOT = Path(__file__).resolve().parents[1]
BASELINE = Path(__file__).with_suffix(".json")
COUNTING = Path(__file__).parent / "fakes" / "counting"
ROBOTS, TICKS, WARM_TICKS = 10, 150, 30  # of the run without ROS
GRAPH_ROBOTS, GRAPH_SECONDS = 3, 20  # of the run on the graph
TICKS_PER_SECOND = 10


def count_harness() -> dict[str, float]:
    """Return the work of world and navigators without ROS, per robot and tick."""
    searches: list[int] = []
    original = SearchSpace.cheapest

    def cheapest(self: SearchSpace, *args: Any) -> Any:
        path, expansions = original(self, *args)
        searches.append(expansions)
        return path, expansions

    scenario = Scenario(name="hall", with_lidar=True, noise=0.0)
    harness = Harness(RunOptions(scenario=scenario, robots=ROBOTS))
    calls = [0]

    def count_call(_frame: Any, event: str, _argument: Any) -> None:
        if event in ("call", "c_call"):
            calls[0] += 1

    SearchSpace.cheapest = cheapest
    try:
        for _ in range(WARM_TICKS):
            harness.advance()
        sys.setprofile(count_call)
        for _ in range(TICKS // 2):
            harness.advance()
        sys.setprofile(None)
        temporary, kept = _allocated(harness, TICKS // 2)
    finally:
        sys.setprofile(None)
        SearchSpace.cheapest = original
        harness.episode.world.close()
    robot_ticks = ROBOTS * (WARM_TICKS + 2 * (TICKS // 2))
    return {
        "planner searches per robot": len(searches) / ROBOTS,
        "planner expansions per robot-tick": sum(searches) / robot_ticks,
        "Python calls per robot-tick": calls[0] / (ROBOTS * (TICKS // 2)),
        "temporary bytes of a tick per robot": temporary / ROBOTS,
        "bytes kept per robot-tick": kept / (ROBOTS * (TICKS // 2)),
    }


def _allocated(harness: Harness, ticks: int) -> tuple[float, float]:
    """Return the bytes that a tick holds at most beyond those before it, and those kept after."""
    tracemalloc.start()
    try:
        peaks = []
        first, _ = tracemalloc.get_traced_memory()
        for _ in range(ticks):
            before, _ = tracemalloc.get_traced_memory()
            tracemalloc.reset_peak()
            harness.advance()
            peaks.append(tracemalloc.get_traced_memory()[1] - before)
        last, _ = tracemalloc.get_traced_memory()
    finally:
        tracemalloc.stop()
    return float(sorted(peaks)[len(peaks) // 2]), float(max(0, last - first))


def count_graph(folder: Path) -> dict[str, float]:
    """Return what world and navigators do on the ROS graph.

    Args:
        folder: For the run and its counts.
    """
    flags = (
        *("--swarm-size", str(GRAPH_ROBOTS), "--mission", "loading_route", "--headless"),
        *("--duration", str(GRAPH_SECONDS), "--speed", "max", "--no-report"),
        *("--run-dir", str(folder / "run")),
    )
    path = os.pathsep.join([str(COUNTING), str(ROOT)])
    ended = run_program(
        (sys.executable, "-c", "from swarm_commander.cli.main import swarm_up; swarm_up()", *flags),
        {"PYTHONPATH": path, "SWARM_COUNTS": str(folder)},
        cwd=folder,
        timeout=240,
    )
    assert ended.returncode == 0, ended.stdout + ended.stderr
    counts = [_read(file) for file in folder.glob("counts-*")]
    busy = [count for count in counts if count["wake_ups"]]
    world = max(busy, key=lambda count: count["published"])  # to every robot, every tick
    robots = [count for count in busy if count is not world]
    assert len(robots) == GRAPH_ROBOTS, f"{len(robots)} processes look like navigators: {counts}"
    ticks = GRAPH_SECONDS * TICKS_PER_SECOND
    figures = {}
    for name, who, share in (("world", [world], GRAPH_ROBOTS), ("navigators", robots, 1)):
        for what in ("published", "taken", "wake_ups", "executor_waits"):
            total = sum(count[what] for count in who) / (len(who) * share)
            figures[f"{name}: {what.replace('_', ' ')} per robot-tick"] = total / ticks
        endpoints = sum(count["endpoints"] for count in who) / (len(who) * share)
        figures[f"{name}: endpoints per robot"] = endpoints
    return figures


def _read(file: Path) -> dict[str, int]:
    return dict(zip(NAMES, struct.unpack(f"{len(NAMES)}q", file.read_bytes()[:SIZE]), strict=True))


def main() -> None:
    """Count, and write the baseline."""
    with tempfile.TemporaryDirectory() as folder:
        figures = {"harness": count_harness(), "graph": count_graph(Path(folder))}
    rounded = {
        part: {name: round(value, 3) for name, value in values.items()}
        for part, values in figures.items()
    }
    BASELINE.write_text(json.dumps(rounded, indent=2) + "\n", encoding="utf-8")
    sys.stdout.write(BASELINE.read_text(encoding="utf-8"))


if __name__ == "__main__":
    main()
