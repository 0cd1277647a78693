"""Configuration of the world process: a JSON file that swarm-up writes."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any

from swarm_common.files.sites_io import parse_spawn
from swarm_common.model.battery import BatterySpec
from swarm_common.model.errors import ConfigError, UnknownNameError
from swarm_common.model.records import Pose
from swarm_common.model.robot_names import DEFAULT, RobotNames
from swarm_common.model.sites import Spawn
from swarm_describe.robots.spec import parse_battery
from swarm_sim.sensing.radio import RadioConfig
from swarm_sim.world.world import WorldConfig

MAX_SPEED = "max"


@dataclass(frozen=True, slots=True)
class RobotEntry:
    """One robot of the swarm."""

    name: str  # namespace
    model: str  # name or path of its model
    # where it stands in the map without a navigator; None for one that works
    broken_at: Pose | None = None
    # where its group starts: name of a spawn, or one of its own; empty for the default
    start: str | Spawn = ""
    battery: BatterySpec | None = None  # None: that of its model, if any
    external: bool = False  # whether a node of the user drives it


@dataclass(frozen=True, slots=True, kw_only=True)
class Settings(WorldConfig):
    """Settings of the world process: those of the simulation, and what is around it."""

    world: str  # name or path
    robots: tuple[RobotEntry, ...]
    pattern: str = DEFAULT  # of the names of robots that come later
    processes: int = 0  # that their navigators are in; 0: one for each
    map: str | None = None  # path of a map file; None: the one that ships with the world
    sites: str | None = None  # path of a sites file; None: the one beside the world
    actors: str | None = None  # path of an actors file; None: the one beside the world
    skip_missing: bool = False  # leave out models and meshes of the world that are not found
    skip_broken: bool = False  # leave out models of the world that are unusable
    spawn: str = ""  # name of a spawn of the sites; empty: the default one
    stations: tuple[str, ...] | None = None  # that robots are sent to; None: all
    seed: int = 0
    speed: float | None = None  # times real time; None: as fast as possible
    paused: bool = False  # at the start; time passes by steps only
    held: bool = False  # in lockstep: time begins when the command `begin` has come
    free_run: bool = False  # no lockstep, for third-party navigators
    cmd_vel_stamped: bool = True  # TwistStamped; False: Twist, in free run only
    wall_limit: float = 15.0  # [s] for a tick; longer than a mission's next goal is waited for
    duration: float | None = None  # [s] of simulated time, then the world ends
    verdict_path: str | None = None
    body_margin: float = 0.26  # [m] that robots allow for what their LiDARs do not see of a body
    trace_dir: str | None = None  # where to leave the map and a time series for the report

    def __post_init__(self) -> None:
        WorldConfig.__post_init__(self)
        if not self.robots:
            raise ConfigError("the world's configuration names no robots")
        if self.speed is not None and self.speed <= 0.0:
            raise ConfigError(f"speed is {self.speed}; it must be positive or 'max'")
        if not (self.cmd_vel_stamped or self.free_run):
            raise ConfigError("cmd_vel_stamped is false; lockstep needs the stamps of TwistStamped")
        if self.wall_limit <= 0.0:
            raise ConfigError(f"wall_limit is {self.wall_limit} s; it must be positive")
        if self.duration is not None and self.duration <= 0.0:
            raise ConfigError(f"duration is {self.duration} s; it must be positive")

    @property
    def names(self) -> RobotNames:
        """Names of all robots."""
        return RobotNames(tuple(robot.name for robot in self.robots), self.pattern)


def parse_settings(data: Mapping[str, Any], where: str) -> Settings:
    """Return the settings in a JSON object."""
    known = [item.name for item in fields(Settings)]
    for key in data:
        if key not in known:
            raise UnknownNameError("key", key, known, where)
    values = dict(data)
    try:
        values["robots"] = tuple(_parse_robot(**robot) for robot in data["robots"])
        if values.get("stations") is not None:
            values["stations"] = tuple(values["stations"])
        values["radio"] = RadioConfig(**(data.get("radio") or {}))
    except (KeyError, TypeError) as cause:
        raise ConfigError(f"{where}: {cause}") from cause
    if values.get("speed") == MAX_SPEED:
        values["speed"] = None
    return Settings(**values)


def _parse_robot(
    name: str,
    model: str,
    broken_at: Sequence[float] | None = None,
    start: object = "",
    battery: object = None,
    external: bool = False,
) -> RobotEntry:
    spot = None if broken_at is None else Pose(*broken_at)
    own = start if isinstance(start, str) else parse_spawn(start, f"start of {name}")
    supply = None if battery is None else parse_battery(battery, f"battery of {name}")
    return RobotEntry(name, model, spot, own, supply, external)


def read_settings(path: str | Path) -> Settings:
    """Return the settings in a JSON file."""
    try:
        data = json.loads(Path(path).read_text(encoding="utf-8"))
    except (OSError, ValueError) as cause:
        raise ConfigError(f"{path}: {cause}") from cause
    return parse_settings(data, str(path))
