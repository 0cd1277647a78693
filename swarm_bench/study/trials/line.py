"""Raw results of the study: one JSON line per run, compressed once a command has ended."""

from __future__ import annotations

import functools
import hashlib
from pathlib import Path
from typing import Any

import msgspec

from swarm_bench.execution.store import Store
from swarm_bench.runs.origin import DECIDING
from swarm_common.files.resources import share_directory
from swarm_common.process.compiled_code import edition

STEP = 10.0  # [s] in which orders are counted
JAM = 2  # last batches of a run in which nothing is finished if it is jammed
TRIALS = "swarm_bench/study/trials"
DATA = ("maps", "params", "robots", "worlds")
OF_LINES = ("study/*.yaml", "study/tuning/*.yaml")  # in params: lines tell what they need of them
DIGITS = 8  # of the data's digest


@functools.cache
def study_edition() -> str:
    """Return version and digests of all code and data that decide what a run of the study is.

    Cells and tuned settings are not among them: each line has its own.
    """
    digest = hashlib.sha256()
    for name in DATA:
        root = share_directory(name) / name
        for path in sorted(root.rglob("*")):
            place = path.relative_to(root)
            if path.is_file() and not (name == "params" and any(map(place.match, OF_LINES))):
                digest.update(f"{name}/{place.as_posix()}".encode())
                digest.update(path.read_bytes())
    return f"{edition((*DECIDING, TRIALS))} {digest.hexdigest()[:DIGITS]}"


class StudyLine(msgspec.Struct, frozen=True, kw_only=True):
    """One run."""

    experiment: str
    cell: str
    condition: str  # digest of the cell
    method: str
    seed: int
    settings: str = ""  # of the method, beside its defaults
    edition: str  # of code and data
    failure: str = ""  # error of the centre that ended the run: it did nothing any more
    goals_sent: int  # of robots that did not die
    goals_reached: int
    robot_robot: int  # contact episodes between robots
    robot_world: int  # likewise with walls and people
    makespan: float | None  # [s]; None if a goal was missed, or the run has no end
    stopped: float  # [s] after which the run would have been stopped
    bound: float | None  # [s] no method is faster; None where nothing is known
    blocked: float | None = None  # [s] that a box stood in the way
    per_hour: float | None = None  # orders, or goals, after the warm-up of a run without end
    lead_time: float | None = None  # [s] of these, mean
    batches: list[int] | None = None  # of these, in parts of equal length
    done: list[int] | None = None  # orders done in each `STEP` of the run
    worst_by_median: float | None = None  # goals of the robot with the fewest, by the median
    stood_share: float | None = None  # of the robots' time after the warm-up
    cpu: float = 0.0  # [s] of the whole run
    sim_time: float = 0.0  # [s]
    cpu_ms_per_robot_second: float
    centre_ms_per_robot_second: float | None = None  # of that, the centre's
    tick_us_median: float | None = None  # [µs] of a robot's decision
    tick_us_p99: float | None  # [µs] likewise
    longest_decision_ms: float | None  # of the centre; None without one
    p99_decision_ms: float | None = None  # likewise
    bytes_per_robot_second: float | None  # sent by radio, to and from the centre if there is one
    trajectory_sha256: str

    @property
    def key(self) -> tuple[str, str, str, int, str, str]:
        """Key that identifies the run."""
        return (
            self.experiment, self.cell, self.method, self.seed, self.settings, self.condition
        )  # fmt: skip

    @property
    def has_ended(self) -> bool:
        """Whether every goal was reached."""
        return self.makespan is not None

    @property
    def is_success(self) -> bool:
        """Whether nothing touched, and all goals were reached or the run went on to its end."""
        if self.contacts or self.failure:
            return False
        return self.has_ended if self.batches is None else any(self.batches[-JAM:])

    @property
    def time(self) -> float:
        """Restricted time [s]: the makespan, or the time at which all runs are stopped."""
        return self.stopped if self.makespan is None else min(self.makespan, self.stopped)

    @property
    def contacts(self) -> int:
        """Contact episodes."""
        return self.robot_robot + self.robot_world

    @property
    def repeatable(self) -> dict[str, Any]:
        """Everything that a second run has to have bit for bit: all but times of the machine."""
        data: dict[str, Any] = msgspec.to_builtins(self)
        return {name: value for name, value in data.items() if name not in TIMED}

    def as_json(self) -> dict[str, Any]:
        """Return a dictionary for json.dump."""
        data: dict[str, Any] = msgspec.to_builtins(self)
        return {"schema": 2, **{name: value for name, value in data.items() if value is not None}}


TIMED = (
    "cpu", "cpu_ms_per_robot_second", "centre_ms_per_robot_second", "tick_us_median",
    "tick_us_p99", "longest_decision_ms", "p99_decision_ms", "edition",
)  # fmt: skip
OPTIONAL = [name for name, kind in StudyLine.__annotations__.items() if "None" in str(kind)]


def _line(data: dict[str, Any]) -> StudyLine:
    return msgspec.convert(dict.fromkeys(OPTIONAL) | data, StudyLine)


def store_of(folder: Path, name: str, shard: str = "") -> Store[StudyLine]:
    """Return the store of lines: quick, full or tuning."""
    return Store(folder / f"{name}.jsonl.gz", _line, "swarm-bench study", shard)
