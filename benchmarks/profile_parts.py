"""Where the CPU time of the harness goes: a deterministic profile, summed up by module."""

from __future__ import annotations

import cProfile
import pstats
from collections import Counter
from pathlib import PurePath
from typing import Annotated, Any

import typer
from rich.table import Table

from benchmarks.app import Robots, benchmarks_app
from swarm_bench.runs.episode import RunOptions
from swarm_bench.runs.harness import Harness
from swarm_bench.runs.scenario import Scenario, check_size
from swarm_bench.suite.command import new_console
from swarm_common.model.engines import usual_engine

WARM_TICKS = 20
TICKS = 300
SHOWN = 14  # modules
BUILT_IN = "built-in functions, numpy"


def profile_harness(robots: int, engine: str) -> list[tuple[str, float, int]]:
    """Return modules with their share of the CPU time, 0 to 1, and calls, the most expensive first.

    Compiled kernels count for the module that calls them. Profiling makes Python code look more
    expensive than it is, since each call is observed.
    """
    scenario = Scenario(name="hall", with_lidar=True, noise=0.0)
    harness = Harness(RunOptions(scenario=scenario, robots=robots, engine=engine))
    profile = cProfile.Profile()
    try:
        for _ in range(WARM_TICKS):
            harness.advance()
        profile.enable()
        for _ in range(TICKS):
            harness.advance()
    finally:
        profile.disable()
        harness.stage.world.close()
    seconds: Counter[str] = Counter()
    calls: Counter[str] = Counter()
    stats: Any = pstats.Stats(profile)
    for (file, _, name), (_, count, own, _, _) in stats.stats.items():
        module = _module(file, name)
        seconds[module] += own
        calls[module] += count
    total = sum(seconds.values())
    return [(module, own / total, calls[module]) for module, own in seconds.most_common()]


def _module(file: str, name: str) -> str:
    parts = PurePath(file).with_suffix("").parts
    for place, part in enumerate(parts):
        if part.startswith("swarm_"):
            return ".".join(parts[place:])
    return "pybullet" if "pybullet" in name else BUILT_IN


@benchmarks_app.command()
def profile(
    robots: Robots = 20,
    engine: Annotated[
        str | None,
        typer.Option(
            help="bullet or planar.  [default: bullet; planar without PyBullet]",
            show_default=False,
        ),
    ] = None,
) -> None:
    """Profile world and navigators without the ROS graph, summed up by module."""
    check_size(robots, "--robots")
    table = Table("module", "share", "calls per robot-tick", box=None)
    for module, share, calls in profile_harness(robots, engine or usual_engine())[:SHOWN]:
        table.add_row(module, f"{100 * share:.0f} %", f"{calls / (robots * TICKS):.1f}")
    new_console().print(table)
