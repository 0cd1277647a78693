"""One run of `python -m benchmarks scale` in one process, without the ROS graph.

Run as a program of its own, so that start-up and memory are those of the run alone; it imports
nothing of `scale`, so that it can measure the code of another commit, too. Its argument is a job
as JSON, what it prints is the result:

    python harness.py '{"scenario": {...}, "robots": 20, "seconds": 120, "engine": "planar"}'
"""

from __future__ import annotations

import json
import sys
import time
from collections.abc import Callable
from typing import Any

import numpy as np
import psutil

WARM_TICKS = 10  # counted as start-up: kernels and buffers are loaded in them
MEGABYTE = 1e6
TIMED = {"on_odom", "on_scan", "on_battery", "on_neighbors", "on_reception", "tick"}


class CpuClock:
    """CPU seconds spent in certain functions of this process."""

    def __init__(self) -> None:
        self.seconds = 0.0

    def timed(self, function: Callable[..., Any]) -> Callable[..., Any]:
        """Return the function wrapped so that its CPU time is counted."""

        def call(*arguments: Any) -> Any:
            """Return what the function returns."""
            started = time.process_time()
            try:
                return function(*arguments)
            finally:
                self.seconds += time.process_time() - started

        return call


class TimedDriver:
    """A robot's decisions, timed; a `swarm_bench.runs.methods.Driver`."""

    def __init__(self, driver: Any, clock: CpuClock) -> None:
        """Time the methods of a driver that decide; `clock` adds up the time of all drivers."""
        self._driver = driver
        for name in TIMED & set(dir(driver)):
            setattr(self, name, clock.timed(getattr(driver, name)))

    def __getattr__(self, name: str) -> Any:
        return getattr(self._driver, name)


def measure(job: dict[str, Any]) -> dict[str, Any]:
    """Run a job; return what it cost.

    Args:
        job: `scenario` (its fields), `robots`, `seconds` [s] of simulated time and `engine`.

    Returns:
        `start_up`, `sim_time`, `wall_time` and `cpu` by part [s], `rss_mb` [MB], `tick_us` [µs],
        counters, and the hash of the trajectories.
    """
    from swarm_bench.runs.episode import RunOptions, build
    from swarm_bench.runs.harness import Harness
    from swarm_bench.runs.scenario import Scenario

    scenario = Scenario(
        **job["scenario"], time_limit={job["robots"]: job["seconds"]}, robots=(job["robots"],)
    )
    options = RunOptions(scenario=scenario, robots=job["robots"], engine=job["engine"])
    episode = build(options)
    world_clock, robot_clock = CpuClock(), CpuClock()
    for name in ("observe", "step"):
        setattr(episode.world, name, world_clock.timed(getattr(episode.world, name)))
    episode.drivers = [TimedDriver(driver, robot_clock) for driver in episode.drivers]
    harness = Harness(options, episode=episode, times_all=True)
    try:
        for _ in range(WARM_TICKS):
            harness.advance()
        start_up = time.time() - psutil.Process().create_time()
        world_clock.seconds = robot_clock.seconds = 0.0
        first, started, cpu = episode.world.sim_time, time.perf_counter(), time.process_time()
        while harness.advance():
            pass
        wall, cpu = time.perf_counter() - started, time.process_time() - cpu
        verdict = episode.world.verdict
    finally:
        episode.world.close()
    ticks = np.asarray(getattr(harness, "durations", ()), np.float64)[WARM_TICKS * job["robots"] :]
    return {
        "start_up": start_up,
        "sim_time": verdict.sim_time - first,
        "wall_time": wall,
        "cpu": {
            "world": world_clock.seconds,
            "navigators": robot_clock.seconds,
            "other": cpu - world_clock.seconds - robot_clock.seconds,
        },
        "rss_mb": psutil.Process().memory_info().rss / MEGABYTE,
        "collisions": verdict.robot_robot + verdict.robot_world,
        "goals_reached": sum(o.reached for i in episode.itineraries for o in i.outcomes),
        "tick_us": _percentiles(ticks * 1e6),
        "trajectory_sha256": verdict.trajectory_sha256,
    }


def _percentiles(values: np.ndarray[Any, Any]) -> dict[str, float]:
    if not len(values):
        return {}
    median, high = np.percentile(values, (50, 99))
    return {"median": float(median), "p99": float(high)}


if __name__ == "__main__":
    sys.stdout.write(json.dumps(measure(json.loads(sys.argv[1]))) + "\n")
