"""The physical floor: what a robot-second must cost at least, from unit costs measured here.

Messages, physics and rays; deciding is not in it, nor is anything that could be left out.
"""

from __future__ import annotations

import contextlib
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any

import typer
from rich.table import Table

from benchmarks.app import Robots, benchmarks_app
from benchmarks.scale.plan import GRAPH
from benchmarks.scale.result import read_scale_results
from benchmarks.scale.row import rows_of
from swarm_bench.runs.episode import RunOptions
from swarm_bench.runs.harness import Harness
from swarm_bench.runs.scenario import Scenario, check_size
from swarm_bench.suite.command import new_console
from swarm_common.model.engines import BULLET, check_engine
from swarm_sim.sensing.lidar import Lidars

TICKS_PER_SECOND = 10
STEPS_PER_SECOND = 100  # of physics
SCANS_PER_SECOND = 5
WARM_TICKS = 20
TICKS = 300
MESSAGES_PER_TICK = 4.5  # odom, neighbors, half a scan, beacon, cmd_vel


@dataclass(frozen=True, slots=True)
class Unit:
    """A unit cost."""

    name: str  # what is measured
    cost: float  # [µs] CPU time of one operation
    count: float  # operations per robot-second

    @property
    def total(self) -> float:
        """CPU time [ms] per robot-second."""
        return 1e-3 * self.cost * self.count


@contextlib.contextmanager
def cpu_time_of(owner: Any, name: str) -> Iterator[list[float]]:
    """Collect the CPU time [s] of each call of a function of an object."""
    original: Callable[..., Any] = getattr(owner, name)
    seconds: list[float] = []

    def timed(*arguments: Any, **keywords: Any) -> Any:
        started = time.process_time()
        try:
            return original(*arguments, **keywords)
        finally:
            seconds.append(time.process_time() - started)

    setattr(owner, name, timed)
    try:
        yield seconds
    finally:
        setattr(owner, name, original)


def measure_floor(robots: int) -> list[Unit]:
    """Return the unit costs, measured with this many robots at work in the factory hall."""
    check_engine(BULLET, "the floor")
    from benchmarks.floor_messages import measure_messages  # needs the interface packages

    message = 1000.0 * measure_messages(robots) / MESSAGES_PER_TICK
    step, scan = _physics_and_rays(robots)
    return [
        Unit(
            f"message from process to process, of {robots} (publish, wake up, take)", message,
            MESSAGES_PER_TICK * TICKS_PER_SECOND,
        ),
        Unit("step of 10 ms of one robot's rigid bodies (Bullet alone)", step, STEPS_PER_SECOND),
        Unit("scan of 360 rays, with noise", scan, SCANS_PER_SECOND),
    ]  # fmt: skip


def _physics_and_rays(robots: int) -> tuple[float, float]:
    """Return the CPU time [µs] of a robot's physics step and of a scan, in a run at work."""
    import pybullet  # not there for all Pythons

    scenario = Scenario(name="hall", with_lidar=True, noise=0.0)
    harness = Harness(RunOptions(scenario=scenario, robots=robots, engine=BULLET))
    try:
        for _ in range(WARM_TICKS):
            harness.advance()
        with cpu_time_of(pybullet, "stepSimulation") as steps, cpu_time_of(Lidars, "due") as scans:
            for _ in range(TICKS):
                harness.advance()
    finally:
        harness.stage.world.close()
    seconds = robots * TICKS / TICKS_PER_SECOND
    step = 1e6 * sum(steps) / (seconds * STEPS_PER_SECOND)
    return step, 1e6 * sum(scans) / (seconds * SCANS_PER_SECOND)


@benchmarks_app.command()
def floor(
    robots: Robots = 20,
    measured: Annotated[
        Path | None, typer.Option(help="File of `scale --json`, to compare with.")
    ] = None,
) -> None:
    """Measure what messages, physics and rays cost, and what a robot-second costs at least."""
    check_size(robots, "--robots")
    units = measure_floor(robots)
    table = Table("unit", "µs each", "per robot-second", "ms per robot-second", box=None)
    for unit in units:
        table.add_row(unit.name, f"{unit.cost:.1f}", f"{unit.count:g}", f"{unit.total:.2f}")
    total = sum(unit.total for unit in units)
    table.add_row("floor", "", "", f"{total:.2f}")
    console = new_console()
    console.print(table)
    results = read_scale_results(measured) if measured is not None else []
    for row in rows_of(result for result in results if result.system == GRAPH):
        times = row.cpu_total / total
        console.print(f"{row.first.robots} robots: {row.cpu_total:.2f} ms, {times:.1f} floors")
