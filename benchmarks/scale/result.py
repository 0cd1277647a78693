"""Cost of one run of `python -m benchmarks scale`, and the file of JSON lines that keeps it."""

from __future__ import annotations

import dataclasses
import math
import statistics
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import msgspec

from swarm_bench.runs.json_lines import read_json_lines, rounded

SCHEMA = 1


@dataclass(frozen=True, slots=True, kw_only=True)
class ScaleResult:
    """One run; None where a system has no such thing, or it could not be measured."""

    system: str  # `graph`, `harness`, or a peer's name
    workload: str  # hall and mission
    robots: int  # swarm size
    repeat: int  # number of the run
    setting: Mapping[str, Any]  # how it ran: seconds, goals, pack, engine
    start_up: float | None  # [s] of wall time until every robot could decide
    sim_time: float  # [s] at the end
    wall_time: float  # [s] that these took, without the start-up
    # CPU time [ms] per robot and simulated second, of `world`, `navigators` and `other`, and of
    # `dds`: the threads of Fast DDS in all of these, counted there, too
    cpu_ms: Mapping[str, float | None]
    # `total`: proportional share of all processes; `robot`: private memory of a robot (of a process
    # with its share of robots), `rss`: resident, shared pages counted in each process
    memory_mb: Mapping[str, float | None]
    late_ticks: int | None = None  # answers that came too late
    collisions: int | None = None  # contact episodes
    goals_reached: int | None = None  # in time
    # [µs] of a robot's decisions in a tick: `median`, `p99`
    tick_us: Mapping[str, float | None] = field(default_factory=dict)
    # share of the machine's processors that something else used meanwhile
    others: float | None = None
    code: str = ""  # commit
    machine: str = ""  # in one line
    trajectory_sha256: str = ""  # of the true poses; empty for peers

    @property
    def real_time_factor(self) -> float:
        """Simulated by wall time."""
        return self.sim_time / self.wall_time if self.wall_time else math.nan

    @property
    def cpu_total(self) -> float:
        """CPU time [ms] per robot and simulated second, of everything."""
        return sum(self.cpu_ms.get(part) or 0.0 for part in ("world", "navigators", "other"))

    @property
    def kind(self) -> tuple[Any, ...]:
        """Tuple that repeats of one run share."""
        return (self.system, self.workload, self.robots, *self.setting.values())

    @property
    def key(self) -> tuple[Any, ...]:
        """As `ScaleJob.key`."""
        return (self.system, self.workload, self.robots, self.repeat, *self.setting.values())

    def as_json(self) -> dict[str, Any]:
        """Return a dictionary for json.dump."""
        return {"schema": SCHEMA, **rounded(dataclasses.asdict(self))}


def read_scale_results(path: Path) -> list[ScaleResult]:
    """Return the results in a file; see `read_json_lines`."""
    return read_json_lines(
        path, lambda data: msgspec.convert(data, ScaleResult), "python -m benchmarks scale"
    )


def median_of(values: Sequence[float | None]) -> float | None:
    """Return the median of the known values, None without any."""
    known = [value for value in values if value is not None]
    return statistics.median(known) if known else None
