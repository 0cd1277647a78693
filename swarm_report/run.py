"""Data in the folder of a run, as arrays; of a run that ended badly as much as there is."""

from __future__ import annotations

import functools
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from swarm_common.files.map_io import load_map
from swarm_common.files.sites_io import load_sites
from swarm_common.model.errors import ConfigError, SwarmError
from swarm_common.model.grid import Grid
from swarm_common.model.records import FloatArray
from swarm_common.model.sites import Sites
from swarm_report.run_files import (
    Crew,
    GoalLine,
    Report,
    Sample,
    StateLine,
    UsageLine,
    WaitLine,
    WorldEntry,
    read_json,
    read_trace,
)

SHORTEST_GAP = 0.2  # [s] of wall time over which a CPU share means something
FACTOR_SAMPLES = 3  # over which the real-time factor is taken

MEASURES: tuple[Literal["x", "y", "yaw", "to_robot", "to_world"], ...]
MEASURES = ("x", "y", "yaw", "to_robot", "to_world")


@dataclass(frozen=True, slots=True)
class Series:
    """Samples of the truth, once a second of simulated time."""

    times: FloatArray  # (T,) [s]
    poses: FloatArray  # (T, n, 3) x, y [m], yaw [rad] in map
    to_robot: FloatArray  # (T, n) [m] smallest distance to another robot since the sample before
    to_world: FloatArray  # (T, n) [m] likewise to an obstacle
    near: float  # [m] beyond which distances were not measured; they are shown as this


@dataclass(frozen=True, slots=True)
class Span:
    """A robot in one state from `start` to `end` [s]; `place` 0 holds a lease or needs none."""

    robot: int
    start: float
    end: float
    state: str
    station: str
    place: int
    blocker: str = ""  # robot that it waits or makes way for; empty for none

    @property
    def length(self) -> float:
        """Duration [s]."""
        return self.end - self.start


@dataclass(frozen=True, slots=True)
class GoalEvent:
    """A goal that was `sent`, `reached` or `failed` at `time` [s] after `duration` [s]."""

    robot: int
    time: float
    goal: str
    outcome: str
    duration: float


@dataclass(frozen=True, slots=True)
class UsageSeries:
    """CPU and speed over the wall clock."""

    wall: FloatArray  # (k,) [s] since the start of the command
    sim: FloatArray  # (k,) [s] of simulated time
    factor: FloatArray  # (k,) real-time factor
    cores: dict[str, FloatArray]  # CPU seconds per second (k,) by group of processes
    memory_mb: dict[str, FloatArray]  # (k,) by group, shared pages counted once; may be empty


class RunData:
    """A run's folder, each part read when it is first asked for.

    Attributes:
        robots: Names in order.
        report: Content of report.json; empty if the run did not get that far.
        left_out: Number of damaged lines of the trace, by file.
    """

    def __init__(self, folder: Path, report: Mapping[str, Any] | None = None) -> None:
        """Find the run; `report` is its report, if that is not written yet.

        Raises:
            ConfigError: If the folder is not that of a run, or a file in it is damaged.
        """
        self.folder = folder
        self.report: Mapping[str, Any] = report or read_json(folder / "report.json", Report)
        self.config = read_json(folder / "config" / "world.json", WorldEntry)
        if not self.report and not self.config:
            raise ConfigError(
                f"{folder} is not the folder of a run: neither report.json nor config/world.json"
                " is in it; expected a folder like runs/latest"
            )
        self.left_out: dict[str, int] = {}
        heads: list[Crew]
        self._samples: list[Sample]
        heads, self._samples = self._trace("world.jsonl", Crew, Sample)
        self._near = next((line["near_mm"] for line in heads if "near_mm" in line), 500) / 1000.0
        named = [entry["name"] for entry in self.config.get("robots", [])]
        if heads and heads[-1]["robots"][: len(named)] == named:  # others may have come later
            named = heads[-1]["robots"]
        self.robots = named or list(self.report.get("robots", {}))
        self._index = {name: index for index, name in enumerate(self.robots)}

    def _trace(self, name: str, *kinds: type[Any]) -> list[list[Any]]:
        found, damaged = read_trace(self.folder / "trace" / name, *kinds)
        if damaged:
            self.left_out[f"trace/{name}"] = damaged
        return found

    @property
    def name(self) -> str:
        """Name of the folder."""
        return self.folder.resolve().name

    @functools.cached_property
    def series(self) -> Series | None:
        """The truth over time; None if there is none."""
        count = len(self.robots)
        good = [
            line
            for line in self._samples
            if len({len(line[key]) for key in MEASURES}) == 1 and 0 < len(line["x"]) <= count
        ]
        if not good:
            return None
        absent = [None] * count  # such a robot has no place
        x, y, yaw, to_robot, to_world = (
            np.array([(line[key] + absent)[:count] for line in good], float) / 1000.0
            for key in MEASURES
        )
        times = np.array([line["t"] for line in good], float)
        return Series(times, np.stack([x, y, yaw], 2), to_robot, to_world, self._near)

    @functools.cached_property
    def _state_log(self) -> tuple[list[StateLine], list[GoalLine]]:
        found = self._trace("robots.jsonl", StateLine, WaitLine, GoalLine)
        states, _, goals = ([line for line in k if line["robot"] in self._index] for k in found)
        return states, goals

    @functools.cached_property
    def end(self) -> float:
        """End of the run [s] of simulated time, as far as known."""
        times = [line["t"] for lines in self._state_log for line in lines]
        times += [line["t"] for line in self._samples[-1:]]
        return max([float(self.report.get("sim_time") or 0.0), *times])

    @functools.cached_property
    def spans(self) -> list[Span]:
        """Activities of each robot with their times, in order of robots and time."""
        changes: list[list[StateLine]] = [[] for _ in self.robots]
        for line in self._state_log[0]:
            changes[self._index[line["robot"]]].append(line)
        spans = []
        for robot, lines in enumerate(changes):
            starts = [line["t"] for line in lines]
            ends = [*starts[1:], self.end][: len(starts)]
            for line, start, end in zip(lines, starts, ends, strict=True):
                if end > start:
                    spans.append(
                        Span(
                            robot, start, end, line["state"], line["station"], line["place"],
                            line.get("blocker", ""),
                        )
                    )  # fmt: skip
        return spans

    @functools.cached_property
    def goals(self) -> list[GoalEvent]:
        """Goals of the mission in order of time."""
        events = [
            GoalEvent(
                self._index[line["robot"]],
                line["t"],
                line["goal"],
                line["outcome"],
                line["duration"],
            )
            for line in self._state_log[1]
        ]
        return sorted(events, key=lambda event: event.time)

    @functools.cached_property
    def usage(self) -> UsageSeries | None:
        """CPU time over the wall clock; None if there is none."""
        lines: list[UsageLine] = []
        for line in self._trace("usage.jsonl", UsageLine)[0]:
            if not lines or line["wall"] - lines[-1]["wall"] > SHORTEST_GAP:
                lines.append(line)
        if len(lines) < 2:
            return None
        wall, sim = (np.array([line[key] for line in lines], float) for key in ("wall", "t"))
        gaps = np.maximum(np.diff(wall), 1e-3)
        cores = {group: _rates(lines, group, gaps) for group in lines[-1]["cpu"]}
        memory = {
            group: _column(lines, "memory_mb", group)[1:]
            for group in lines[-1].get("memory_mb", {})
        }
        return UsageSeries(wall[1:], sim[1:], _factor(wall, sim), cores, memory)

    @functools.cached_property
    def grid(self) -> Grid | None:
        """The map of the run; None if it is not there."""
        for path in (self.folder / "trace" / "map.yaml", self.config.get("map")):
            try:
                if path is not None:
                    return load_map(path).upright()
            except SwarmError:
                continue
        return None

    @functools.cached_property
    def sites(self) -> Sites:
        """Stations of the world; none if they are not known any more."""
        path = self.config.get("sites")
        try:
            return load_sites(Path(path)) if path else Sites()
        except SwarmError:
            return Sites()

    def states_at(self, times: FloatArray) -> NDArray[np.str_]:
        """Return the state (T, n) of each robot at times (T,) [s]; empty where unknown."""
        states = np.full((len(times), len(self.robots)), "", dtype="U12")
        for span in self.spans:
            first, last = np.searchsorted(times, (span.start, span.end))
            states[first:last, span.robot] = span.state
        return states


def mission_goals(report: Mapping[str, Any]) -> int:
    """Return the number of goals of a report's mission, whatever became of them."""
    goals = report.get("goals", {})
    return sum(goals.get(key, 0) for key in ("reached", "failed", "pending"))


def _column(lines: list[UsageLine], key: Literal["cpu", "memory_mb"], group: str) -> FloatArray:
    return np.array([line.get(key, {}).get(group, 0.0) for line in lines], float)


def _factor(wall: FloatArray, sim: FloatArray) -> FloatArray:
    """Return the real-time factor at each sample but the first, over a few samples."""
    first = np.maximum(np.arange(1, len(wall)) - FACTOR_SAMPLES, 0)
    return (sim[1:] - sim[first]) / np.maximum(wall[1:] - wall[first], 1e-3)


def _rates(lines: list[UsageLine], group: str, gaps: FloatArray) -> FloatArray:
    """Return CPU seconds per second; a counter that has become less was set to zero."""
    counts = _column(lines, "cpu", group)
    steps = np.diff(counts)
    return np.where(steps < 0.0, counts[1:], steps) / gaps
