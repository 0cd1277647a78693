"""Runs of `python -m benchmarks scale`: which hall, how many robots, for how long."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from benchmarks.scale.result import ScaleResult
from swarm_bench.runs.scenario import Scenario, check_size
from swarm_common.model.engines import usual_engine
from swarm_common.model.errors import ConfigError, UnknownNameError

GRAPH, HARNESS = "graph", "harness"
AUTO = "auto"
PACKED_FROM = 101  # robots; from here on several navigators share a process
PACK = 10
DRIVES = ("planar", "bullet")


@dataclass(frozen=True, slots=True)
class Workload:
    """A hall and what is done in it."""

    world: str  # name
    mission: str  # name
    most: int  # robots for which there is work and room


WORKLOADS: dict[str, Workload] = {
    "hall": Workload("slim_blockage", "loading_route", 100),
    "warehouse": Workload("warehouse", "warehouse_orders", 200),
}


@dataclass(frozen=True, slots=True, kw_only=True)
class ScaleJob:
    """One run."""

    system: str  # `graph` or `harness`
    workload: str  # of `WORKLOADS`
    robots: int  # swarm size
    repeat: int = 0  # number of the run, from 0; all have the same seed
    seconds: float = 120.0  # [s] of simulated time after which the run ends
    goals: int = 0  # per robot, after which it is done; 0 for as many as the mission has
    pack: int = 1  # navigators per process
    engine: str = "bullet"  # physics
    code: Path | None = None  # folder of the code to measure; None for this one

    @property
    def key(self) -> tuple[Any, ...]:
        """Tuple that identifies a result, apart from the code."""
        return (self.system, self.workload, self.robots, self.repeat, *self.setting.values())

    @property
    def setting(self) -> Mapping[str, Any]:
        """How it runs."""
        return {
            "seconds": self.seconds,
            "goals": self.goals,
            "pack": self.pack,
            "engine": self.engine,
        }

    @property
    def scenario(self) -> Scenario:
        """The run as a scenario of the bench."""
        workload = WORKLOADS[self.workload]
        return Scenario(
            name=self.workload,
            world=workload.world,
            mission=workload.mission,
            robots=(self.robots,),
            with_lidar=True,
            noise=0.0,
            time_limit={self.robots: self.seconds},
            stall_limit=self.seconds + 1.0,
        )

    def result(self, **figures: Any) -> ScaleResult:
        """Return the result of the run with these fields."""
        return ScaleResult(
            system=self.system,
            workload=self.workload,
            robots=self.robots,
            repeat=self.repeat,
            setting=self.setting,
            **figures,
        )


def plan_jobs(
    system: str,
    sizes: Sequence[int],
    repeats: int,
    *,
    workload: str = AUTO,
    seconds: float = 120.0,
    goals: int = 0,
    pack: int | None = None,
    engine: str | None = None,
) -> list[ScaleJob]:
    """Return the runs, repeat by repeat, so that a killed sweep has results of every size.

    Args:
        workload: A name in `WORKLOADS`, or `auto`: the hall while robots fit, then the warehouse.
        goals: Per robot; 0 for all of the mission.
        pack: Navigators per process; None for one, and for ten in swarms of more than 100.
        engine: None for bullet on the graph and planar in the harness.
    """
    if workload != AUTO and workload not in WORKLOADS:
        raise UnknownNameError("workload", workload, (AUTO, *WORKLOADS))
    if engine is not None and engine not in DRIVES:
        raise UnknownNameError("engine", engine, DRIVES)
    if repeats < 1:
        raise ConfigError(f"--repeats is {repeats}; expected 1 or more")
    if seconds < 5.0:
        raise ConfigError(f"--seconds is {seconds:g}; expected 5 or more")
    if pack is not None and pack < 1:
        raise ConfigError(f"--pack is {pack}; expected 1 or more")
    first = [
        ScaleJob(
            system=system,
            workload=_workload_for(workload, check_size(size, "--robots")),
            robots=size,
            seconds=seconds,
            goals=goals,
            pack=(pack or (PACK if size >= PACKED_FROM else 1)) if system == GRAPH else 1,
            engine=engine or (usual_engine() if system == GRAPH else "planar"),
        )
        for size in sizes
    ]
    return [dataclasses.replace(job, repeat=number) for number in range(repeats) for job in first]


def _workload_for(name: str, size: int) -> str:
    chosen = ("hall" if size <= WORKLOADS["hall"].most else "warehouse") if name == AUTO else name
    if size > WORKLOADS[chosen].most:
        raise ConfigError(
            f"workload {chosen} has room for {WORKLOADS[chosen].most} robots, not for {size}; "
            "--workload warehouse is larger"
        )
    return chosen
