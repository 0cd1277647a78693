"""The physical floor: what a robot-second must cost at least, from unit costs measured here.

Messages, physics and rays; deciding is not in it, nor is anything that could be left out.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

from benchmarks.scale.row import ScaleRow
from swarm_bench.runs.episode import RunOptions
from swarm_bench.runs.harness import Harness
from swarm_bench.runs.scenario import Scenario
from swarm_bench.suite.table import number
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


class FunctionTimer:
    """CPU seconds in one function, while it is replaced by a timed one."""

    def __init__(self, owner: Any, name: str) -> None:
        self.seconds = 0.0
        self._owner, self._name = owner, name
        self._original: Callable[..., Any] = getattr(owner, name)

    def __enter__(self) -> FunctionTimer:
        def timed(*arguments: Any, **keywords: Any) -> Any:
            started = time.process_time()
            try:
                return self._original(*arguments, **keywords)
            finally:
                self.seconds += time.process_time() - started

        setattr(self._owner, self._name, timed)
        return self

    def __exit__(self, *_: object) -> None:
        setattr(self._owner, self._name, self._original)


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
        with (
            FunctionTimer(pybullet, "stepSimulation") as steps,
            FunctionTimer(Lidars, "due") as scans,
        ):
            for _ in range(TICKS):
                harness.advance()
    finally:
        harness.stage.world.close()
    seconds = robots * TICKS / TICKS_PER_SECOND
    return (
        1e6 * steps.seconds / (seconds * STEPS_PER_SECOND),
        1e6 * scans.seconds / (seconds * SCANS_PER_SECOND),
    )


def floor_markdown(units: Sequence[Unit], rows: Sequence[ScaleRow]) -> str:
    """Return unit costs, their sum, and how far measured swarms are from it, as Markdown.

    Args:
        rows: Of `python -m benchmarks scale` on the graph; may be none.
    """
    floor = sum(unit.total for unit in units)
    lines = [
        "| unit | µs each | per robot-second | ms per robot-second |",
        "| --- | ---: | ---: | ---: |",
        *(
            f"| {unit.name} | {unit.cost:.1f} | {unit.count:g} | {unit.total:.2f} |"
            for unit in units
        ),
        f"| **floor** | | | **{floor:.2f}** |",
    ]
    if rows:
        lines += [
            "",
            "| robots | workload | measured [ms] | times the floor | DDS threads | others [%] |",
            "| ---: | --- | ---: | ---: | ---: | ---: |",
            *(_distance(row, floor) for row in rows),
        ]
    return "\n".join(lines) + "\n"


def _distance(row: ScaleRow, floor: float) -> str:
    others = row.median(lambda run: run.others)
    return (
        f"| {row.first.robots} | {row.label} | {row.cpu_total:.2f} | {row.cpu_total / floor:.1f} | "
        f"{number(row.cpu('dds'), 2)} | {number(None if others is None else 100 * others, 0)} |"
    )
