"""What one run of `swarm-bench scale` cost, and the file of JSON lines that keeps it."""

from __future__ import annotations

import dataclasses
import math
import statistics
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from swarm_bench.runs.json_lines import read_json_lines, rounded

SCHEMA = 1


@dataclass(frozen=True, slots=True, kw_only=True)
class ScaleResult:
    """One run; None where a system has no such thing, or it could not be measured.

    Attributes:
        system: `graph`, `harness`, or a peer's name.
        workload: Hall and mission.
        robots: Swarm size.
        repeat: Number of the run.
        setting: How it ran: seconds, goals, pack, engine.
        start_up: [s] of wall time until every robot could decide.
        sim_time: [s] at the end.
        wall_time: [s] that these took, without the start-up.
        cpu_ms: CPU time [ms] per robot and simulated second, of `world`, `navigators` and
            `other`, and of `dds`: the threads of Fast DDS in all of these, counted there, too.
        memory_mb: `total`: proportional share of all processes; `robot`: private memory of a
            robot (of a process with its share of robots), `rss`: resident, shared pages counted
            in each process.
        late_ticks: Answers that came too late.
        collisions: Contact episodes.
        goals_reached: In time.
        tick_us: [µs] of a robot's decisions in a tick: `median`, `p99`.
        others: Share of the machine's processors that something else used meanwhile.
        code: Commit.
        machine: In one line.
        trajectory_sha256: Of the true poses; empty for peers.
    """

    system: str
    workload: str
    robots: int
    repeat: int
    setting: Mapping[str, Any]
    start_up: float | None
    sim_time: float
    wall_time: float
    cpu_ms: Mapping[str, float | None]
    memory_mb: Mapping[str, float | None]
    late_ticks: int | None = None
    collisions: int | None = None
    goals_reached: int | None = None
    tick_us: Mapping[str, float | None] = field(default_factory=dict)
    others: float | None = None
    code: str = ""
    machine: str = ""
    trajectory_sha256: str = ""

    @property
    def real_time_factor(self) -> float:
        """Simulated by wall time."""
        return self.sim_time / self.wall_time if self.wall_time else math.nan

    @property
    def cpu_total(self) -> float:
        """CPU time [ms] per robot and simulated second, of everything."""
        return sum(self.cpu_ms.get(part) or 0.0 for part in ("world", "navigators", "other"))

    @property
    def key(self) -> tuple[Any, ...]:
        """As `ScaleJob.key`."""
        return (self.system, self.workload, self.robots, self.repeat, *self.setting.values())

    def as_json(self) -> dict[str, Any]:
        """Return a dictionary for json.dump."""
        return {"schema": SCHEMA, **rounded(dataclasses.asdict(self))}


def read_scale_results(path: Path) -> list[ScaleResult]:
    """Return the results in a file; see `read_json_lines`."""
    return read_json_lines(path, lambda data: ScaleResult(**data), "swarm-bench scale")


def median_of(values: Sequence[float | None]) -> float | None:
    """Return the median of the known values, None without any."""
    known = [value for value in values if value is not None]
    return statistics.median(known) if known else None
