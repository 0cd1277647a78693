"""Where the CPU time of the harness goes: a deterministic profile, summed up by module."""

from __future__ import annotations

import cProfile
import pstats
from pathlib import PurePath
from typing import Any

from swarm_bench.runs.episode import RunOptions
from swarm_bench.runs.harness import Harness
from swarm_bench.runs.scenario import Scenario

WARM_TICKS = 20
TICKS = 300
SHOWN = 14  # modules
BUILT_IN = "built-in functions, numpy"


def profile_harness(robots: int, engine: str) -> list[tuple[str, float, int]]:
    """Return modules with their share of the CPU time, 0 to 1, and calls, the dearest first.

    Compiled kernels count for the module that calls them. Profiling makes Python code look dearer
    than it is, since each call is observed.

    Args:
        robots: Swarm size, in the factory hall with LiDARs.
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
    return _by_module(pstats.Stats(profile))


def _by_module(stats: Any) -> list[tuple[str, float, int]]:
    seconds: dict[str, float] = {}
    calls: dict[str, int] = {}
    for (file, _, name), (_, count, own, _, _) in stats.stats.items():
        module = _module(file, name)
        seconds[module] = seconds.get(module, 0.0) + own
        calls[module] = calls.get(module, 0) + count
    total = sum(seconds.values())
    ranked = sorted(seconds, key=lambda module: -seconds[module])
    return [(module, seconds[module] / total, calls[module]) for module in ranked]


def _module(file: str, name: str) -> str:
    parts = PurePath(file).with_suffix("").parts
    for place, part in enumerate(parts):
        if part.startswith("swarm_"):
            return ".".join(parts[place:])
    return "pybullet" if "pybullet" in name else BUILT_IN


def profile_markdown(parts: list[tuple[str, float, int]], robots: int) -> str:
    """Return the table as Markdown."""
    robot_ticks = robots * TICKS
    lines = ["| module | share | calls per robot-tick |", "| --- | ---: | ---: |"]
    lines += [
        f"| {module} | {100 * share:.0f} % | {calls / robot_ticks:.1f} |"
        for module, share, calls in parts[:SHOWN]
    ]
    rest = sum(share for _, share, _ in parts[SHOWN:])
    return "\n".join([*lines, f"| all others | {100 * rest:.0f} % | |"]) + "\n"
