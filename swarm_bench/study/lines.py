"""Raw results of the study: one JSON line per run."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import msgspec

from swarm_bench.runs.json_lines import read_json_lines


class StudyLine(msgspec.Struct, frozen=True, kw_only=True):
    """One run."""

    experiment: str
    cell: str
    method: str
    seed: int
    goals_sent: int  # of robots that did not die
    goals_reached: int
    robot_robot: int  # contact episodes between robots
    robot_world: int  # likewise with walls and people
    makespan: float | None  # [s]; None if a goal was missed
    stopped: float  # [s] after which the run would have been stopped
    bound: float | None  # [s] no method is faster; None where robots die
    cpu_ms_per_robot_second: float
    tick_us_p99: float | None  # [µs] of a robot's decision
    longest_decision_ms: float | None  # of the centre; None without one
    bytes_per_robot_second: float | None  # to and from the centre; None without one
    trajectory_sha256: str

    @property
    def key(self) -> tuple[str, str, str, int]:
        """What tells it apart."""
        return self.experiment, self.cell, self.method, self.seed

    @property
    def has_ended(self) -> bool:
        """Whether every goal was reached."""
        return self.makespan is not None

    @property
    def time(self) -> float:
        """Makespan, or the time at which the run was stopped [s]."""
        return self.stopped if self.makespan is None else self.makespan

    @property
    def contacts(self) -> int:
        """Contact episodes."""
        return self.robot_robot + self.robot_world

    def as_json(self) -> dict[str, Any]:
        """Return a dictionary for json.dump."""
        data: dict[str, Any] = msgspec.to_builtins(self)
        return {"schema": 1, **data}


def read_lines(path: Path) -> Sequence[StudyLine]:
    """Return the lines of a file.

    Raises:
        ConfigError: If the file cannot be read, or a complete line is no result.
    """
    return read_json_lines(path, lambda data: msgspec.convert(data, StudyLine), "swarm-bench study")
