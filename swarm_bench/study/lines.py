"""Raw results of the study: one JSON line per run, compressed once a command has ended."""

from __future__ import annotations

import gzip
import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import msgspec

from swarm_bench.runs.json_lines import read_json_lines
from swarm_common.model.errors import ConfigError

STEP = 10.0  # [s] in which orders are counted
JAM = 2  # last batches of a run in which nothing is finished if it is jammed
COMMAND = "swarm-bench study"


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


def read_lines(folder: Path, edition: str) -> list[StudyLine]:
    """Return all lines of an edition, each run once: the compressed ones, and newer ones.

    Args:
        edition: `quick` or `full`.

    Raises:
        ConfigError: If a file cannot be read, or a complete line is no result.
    """
    found: dict[tuple[Any, ...], StudyLine] = {}
    packed = packed_file(folder, edition)
    if packed.is_file():
        try:
            texts = gzip.decompress(packed.read_bytes()).decode().splitlines()
            lines = [_line({k: v for k, v in json.loads(t).items() if k != "schema"})
                     for t in texts]  # fmt: skip
        except (OSError, EOFError, ValueError) as cause:
            raise ConfigError(f"{packed} has no results of {COMMAND}: {cause}") from cause
        found = {line.key: line for line in lines}
    for path in new_files(folder, edition):
        found |= {line.key: line for line in read_json_lines(path, _line, COMMAND)}
    return list(found.values())


def packed_file(folder: Path, edition: str) -> Path:
    """Return the file of compressed lines."""
    return folder / f"{edition}.jsonl.gz"


def new_files(folder: Path, edition: str) -> Sequence[Path]:
    """Return the files of lines that are not compressed yet: of this call, and of shards."""
    return sorted(folder.glob(f"{edition}*.jsonl"))


def pack(folder: Path, edition: str, lines: Sequence[StudyLine]) -> None:
    """Compress all lines into one file, and remove those that it makes needless.

    Equal lines give equal bytes, whatever their order.
    """
    texts = [json.dumps(line.as_json()) for line in sorted(lines, key=lambda line: line.key)]
    data = gzip.compress("".join(f"{text}\n" for text in texts).encode(), mtime=0)
    old = new_files(folder, edition)
    try:
        beside = folder / f"{edition}.new"
        beside.write_bytes(data)
        beside.replace(packed_file(folder, edition))
        for path in old:
            path.unlink()
    except OSError as cause:
        raise ConfigError(f"cannot write {packed_file(folder, edition)}: {cause}") from cause
