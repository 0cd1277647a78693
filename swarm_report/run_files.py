"""Schemas of the files of a run: the one door through which `swarm-report` reads them."""

from __future__ import annotations

import contextlib
import json
from pathlib import Path
from typing import Annotated, Any, NotRequired, Required, TypedDict

import msgspec
from msgspec import Meta

from swarm_common.files.journal import read_journal
from swarm_common.model.breaches import Count, Number
from swarm_common.model.errors import ConfigError
from swarm_run.record.run_record import Breaches, Goals

Millimetres = list[Number | None]  # of each robot; None of one that is absent


class Collisions(TypedDict):
    """Number of collisions; None without a verdict."""

    robot_robot: Count | None
    robot_world: Count | None


class Duration(TypedDict, total=False):
    """How long goals took [s]."""

    median: Number | None
    worst: Number | None


class ZoneCounts(TypedDict):
    """Entries and violations in keepout and speed zones; times [s] are sums over robots."""

    keepout_entries: Count
    keepout_time: Number
    speed_violations: Count
    speed_violation_time: Number


class LostEntry(TypedDict):
    """Time that robots lost."""

    seconds: Number


class StopEntry(TypedDict):
    """The longest stop of a robot."""

    duration: Number  # [s]


class Report(TypedDict):
    """Part of report.json that is read; it has more (docs/report.md)."""

    swarm_size: Count
    goals: Goals
    collisions: Collisions
    cpu_ms_per_robot_second: dict[str, Number | None]
    world: NotRequired[str | None]
    robot: NotRequired[str | None]
    mission: NotRequired[str | None]
    seed: NotRequired[int | None]
    sim_time: NotRequired[Number | None]
    real_time_factor: NotRequired[Number | None]
    near_misses: NotRequired[Count | None]
    min_clearance: NotRequired[Number | None]
    zones: NotRequired[ZoneCounts]
    makespan: NotRequired[Number | None]
    throughput_per_minute: NotRequired[Number | None]
    lost: NotRequired[LostEntry | None]
    longest_stop: NotRequired[StopEntry | None]
    goal_duration: NotRequired[Duration | None]
    trajectory_sha256: NotRequired[str | None]
    breaches: NotRequired[Breaches]
    robots: NotRequired[dict[str, dict[str, Number | None]]]
    exit_code: NotRequired[int | None]
    failures: NotRequired[list[str]]
    broken: NotRequired[list[str]]


class WorldRobotEntry(TypedDict):
    """A robot of the world's settings."""

    name: str


class WorldEntry(TypedDict, total=False):
    """Part of config/world.json that is read."""

    world: str
    map: str | None
    sites: str | None
    robots: list[WorldRobotEntry]
    seed: int


class Crew(TypedDict, total=False):
    """A line of trace/world.jsonl that says who there is."""

    robots: Required[list[str]]
    near_mm: Number


class Sample(TypedDict):
    """A line of trace/world.jsonl with the truth at a time."""

    t: Number  # [s]
    x: Millimetres
    y: Millimetres
    yaw: Millimetres  # [mrad]
    to_robot: Millimetres
    to_world: Millimetres


class StateLine(TypedDict):
    """A line of trace/robots.jsonl: what a robot does from then on."""

    t: Number  # [s]
    robot: str
    state: str
    station: str
    place: Annotated[int, Meta(ge=0, le=10**6)]
    blocker: NotRequired[str]  # robot that it waits or makes way for; empty for none


class WaitLine(TypedDict):
    """A line of trace/robots.jsonl: how long a robot had stood because of another one."""

    t: Number  # [s]
    robot: str
    waited: Number  # [s]


class GoalLine(TypedDict):
    """A line of trace/robots.jsonl: what became of a goal."""

    t: Number  # [s]
    robot: str
    goal: str
    outcome: str
    duration: Number  # [s]


class UsageLine(TypedDict):
    """A line of trace/usage.jsonl."""

    wall: Number  # [s]
    t: Number  # [s]
    cpu: dict[str, Number]  # [s] by group
    memory_mb: NotRequired[dict[str, Number]]  # by group


def read_json(path: Path, kind: type[Any] = dict[str, Any]) -> dict[str, Any]:
    """Return the object in a file, checked to be of a kind; empty if there is no file.

    Raises:
        ConfigError: If the file holds something else; the message says what and where.
    """
    try:
        text = path.read_text(encoding="utf-8")
    except FileNotFoundError:
        return {}
    except (OSError, ValueError) as cause:
        raise ConfigError(f"{path} cannot be read: {cause}") from cause
    try:
        content: dict[str, Any] = json.loads(text, parse_constant=_refuse)
        msgspec.convert(content, kind)
    except (ValueError, RecursionError) as cause:
        raise ConfigError(f"{path} is damaged, or not ours: {cause}") from cause
    return content


def read_trace(path: Path, *kinds: type[Any]) -> tuple[list[list[Any]], int]:
    """Return the lines of a journal by kind, and the number of damaged lines, which are of none."""
    found: list[list[Any]] = [[] for _ in kinds]
    damaged = 0
    for line in read_journal(path):
        for lines, kind in zip(found, kinds, strict=True):
            with contextlib.suppress(ValueError, RecursionError):
                lines.append(msgspec.convert(line, kind))
                break
        else:
            damaged += 1
    return found, damaged


def _refuse(word: str) -> float:
    raise ValueError(f"{word} is no number")
