"""Raw results of the study: one JSON line per run, compressed once a command has ended."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import msgspec

from swarm_bench.execution.store import Store

STEP = 10.0  # [s] in which orders are counted
JAM = 2  # last batches of a run in which nothing is finished if it is jammed


class StudyLine(msgspec.Struct, frozen=True, kw_only=True):
    """One run."""

    experiment: str
    cell: str
    method: str
    seed: int
    settings: str = ""  # of the method, beside its defaults
    edition: str = ""  # of the code
    goals_sent: int  # of robots that did not die
    goals_reached: int
    robot_robot: int  # contact episodes between robots
    robot_world: int  # likewise with walls and people
    makespan: float | None  # [s]; None if a goal was missed, or the run has no end
    stopped: float  # [s] after which the run would have been stopped
    bound: float | None  # [s] no method is faster; None where robots die
    per_hour: float | None = None  # orders, or goals, after the warm-up of a run without end
    lead_time: float | None = None  # [s] of these, mean
    batches: list[int] | None = None  # of these, in parts of equal length
    created: list[int] | None = None  # orders that came in each `STEP`
    done: list[int] | None = None  # likewise, that were done
    cpu: float = 0.0  # [s] of the whole run
    sim_time: float = 0.0  # [s]
    cpu_ms_per_robot_second: float
    tick_us_p99: float | None  # [µs] of a robot's decision
    longest_decision_ms: float | None  # of the centre; None without one
    bytes_per_robot_second: float | None  # sent by radio, to and from the centre if there is one
    trajectory_sha256: str

    @property
    def key(self) -> tuple[str, str, str, int, str]:
        """Key that identifies the run."""
        return self.experiment, self.cell, self.method, self.seed, self.settings

    @property
    def has_ended(self) -> bool:
        """Whether every goal was reached."""
        return self.makespan is not None

    @property
    def is_success(self) -> bool:
        """Whether nothing touched, and all goals were reached or the run went on to its end."""
        if self.batches is not None:
            return not self.contacts and any(self.batches[-JAM:])
        return not self.contacts and self.has_ended

    @property
    def time(self) -> float:
        """Makespan, or the time at which the run was stopped [s]."""
        return self.stopped if self.makespan is None else self.makespan

    @property
    def gain(self) -> float:
        """Figure that is better when larger: throughput, or the time with a minus."""
        return -self.time if self.per_hour is None else self.per_hour

    @property
    def orders(self) -> tuple[list[int], list[int]] | None:
        """Orders that came and that were done in each `STEP`; None without any."""
        return (self.created, self.done) if self.created and self.done else None

    @property
    def contacts(self) -> int:
        """Contact episodes."""
        return self.robot_robot + self.robot_world

    def as_json(self) -> dict[str, Any]:
        """Return a dictionary for json.dump."""
        data: dict[str, Any] = msgspec.to_builtins(self)
        return {"schema": 1, **{name: value for name, value in data.items() if value is not None}}


OPTIONAL = [name for name, kind in StudyLine.__annotations__.items() if "None" in str(kind)]


def _line(data: dict[str, Any]) -> StudyLine:
    return msgspec.convert(dict.fromkeys(OPTIONAL) | data, StudyLine)


def store_of(folder: Path, edition: str, shard: str = "") -> Store[StudyLine]:
    """Return the store of an edition's lines: quick, full or tuning."""
    return Store(folder / f"{edition}.jsonl.gz", _line, "swarm-bench study", shard)
