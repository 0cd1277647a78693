"""Missions: the route of a robot, as written in `params/missions/*.yaml`, without any ROS."""

from __future__ import annotations

import random
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from swarm_common.errors import ConfigError, UnknownNameError
from swarm_common.records import CONTROL_PERIOD, Pose
from swarm_common.resources import share_directory
from swarm_common.sites import Sites
from swarm_common.yaml_io import check_keys, number, numbers, read_yaml

HOME = "home"
ORDERS = ("as_written", "random")


@dataclass(frozen=True, slots=True, kw_only=True)
class Leg:
    """A part of the route: stations by name, one pose of its own, or home."""

    stations: tuple[str, ...] = ()
    pose_map: Pose | None = None
    home: bool = False
    order: str = "as_written"
    pause: float = 0.0  # [s] after arriving at each

    def __post_init__(self) -> None:
        if (bool(self.stations) + (self.pose_map is not None) + self.home) != 1:
            raise ConfigError("a leg needs exactly one of 'stations', 'pose' and 'home'")
        if self.order not in ORDERS:
            raise UnknownNameError("order", self.order, ORDERS)
        if self.pause < 0.0:
            raise ConfigError(f"pause is {self.pause} s; it must not be negative")


@dataclass(frozen=True, slots=True)
class Stop:
    """One goal of one robot."""

    name: str
    pose_map: Pose
    pause_ticks: int


@dataclass(frozen=True, slots=True, kw_only=True)
class Mission:
    """A route and how often a goal is tried again."""

    name: str
    route: tuple[Leg, ...]
    retries: int = 3

    def __post_init__(self) -> None:
        if not self.route:
            raise ConfigError("the route is empty; expected at least one leg")
        if self.retries < 0:
            raise ConfigError(f"retries is {self.retries}; it must not be negative")

    @property
    def is_single_goal(self) -> bool:
        """Whether there is only one pose to go to."""
        return len(self.route) == 1 and self.route[0].pose_map is not None

    def check_stations(self, sites: Sites, where: str) -> None:
        """Check that the world has every station of the route.

        Raises:
            UnknownNameError: For the first that it lacks.
        """
        for leg in self.route:
            for name in leg.stations:
                if name not in sites.stations:
                    raise UnknownNameError("station", name, sites.stations, where)

    def stops(
        self,
        sites: Sites,
        home_map: Pose,
        *,
        seed: int,
        robot_id: int,
        laps: int = 1,
        limit: int | None = None,
    ) -> list[Stop]:
        """Return the goals of one robot in order; equal arguments give equal goals.

        Args:
            sites: Of the world; must have the route's stations.
            home_map: Where the robot goes for a `home` leg.
            seed: Of the run.
            robot_id: 3 for Srobot3; robots draw different orders from one seed.
            laps: Times that the route is driven, each with an order of its own.
            limit: Cut after this many goals; None for all.
        """
        stops = [
            stop
            for lap in range(laps)
            for number, leg in enumerate(self.route)
            for stop in _stops_of_leg(
                leg,
                sites,
                home_map,
                random.Random(f"{seed}/{robot_id}/{lap}/{number}"),
            )
        ]
        return stops[:limit]


def _stops_of_leg(leg: Leg, sites: Sites, home_map: Pose, rng: random.Random) -> list[Stop]:
    pause_ticks = round(leg.pause / CONTROL_PERIOD)
    if leg.home:
        return [Stop(HOME, home_map, pause_ticks)]
    if leg.pose_map is not None:
        name = f"({leg.pose_map.x:g}, {leg.pose_map.y:g})"
        return [Stop(name, leg.pose_map, pause_ticks)]
    names = list(leg.stations)
    if leg.order == "random":
        rng.shuffle(names)
    return [Stop(name, sites.stations[name], pause_ticks) for name in names]


def single_goal(pose_map: Pose) -> Mission:
    """Return the mission of one goal."""
    return Mission(name="goal", route=(Leg(pose_map=pose_map),))


def mission_path(name_or_path: str) -> Path:
    """Return the file of a mission of `params/missions`, or the user's own.

    Raises:
        UnknownNameError: If it is neither.
    """
    path = Path(name_or_path)
    if path.suffix in (".yaml", ".yml") or len(path.parts) > 1:
        return path
    folder = share_directory() / "params" / "missions"
    names = {path.stem for path in folder.glob("*.yaml")}
    if name_or_path not in names:
        raise UnknownNameError("mission", name_or_path, names)
    return folder / f"{name_or_path}.yaml"


def load_mission(name_or_path: str) -> Mission:
    """Return a mission of `params/missions` by name, or one from the user's own file.

    Raises:
        ConfigError: If there is no such mission or something in it is wrong.
    """
    path = mission_path(name_or_path)
    content = read_yaml(path)
    check_keys(content, ("description", "retries", "route"), str(path))
    route = content.get("route")
    if not isinstance(route, list):
        raise ConfigError(f"{path}: route is {route!r}; expected a list of legs")
    retries = content.get("retries", 3)
    if isinstance(retries, bool) or not isinstance(retries, int):
        raise ConfigError(f"{path}: retries is {retries!r}; expected an integer")
    legs = tuple(_parse_leg(leg, f"{path}: route, leg {i}") for i, leg in enumerate(route, 1))
    try:
        return Mission(name=path.stem, route=legs, retries=retries)
    except ConfigError as error:
        raise ConfigError(f"{path}: {error}") from None


def _parse_leg(content: Any, where: str) -> Leg:
    if not isinstance(content, dict):
        raise ConfigError(f"{where} is {content!r}; expected 'stations:', 'pose:' or 'home: true'")
    check_keys(content, ("stations", "pose", "home", "order", "pause"), where)
    names = content.get("stations", [])
    if not isinstance(names, list) or not all(isinstance(name, str) for name in names):
        raise ConfigError(f"{where}: stations must be a list of names, like [loader_1, shipping]")
    home = content.get("home", False)
    if not isinstance(home, bool):
        raise ConfigError(f"{where}: home is {home!r}; expected true")
    pose = content.get("pose")
    pose_map = None if pose is None else Pose(*numbers(pose, 3, f"{where}: pose [x, y, yaw]"))
    pause = number(content.get("pause", 0.0), f"{where}: pause")
    order = str(content.get("order", "as_written"))
    try:
        return Leg(stations=tuple(names), pose_map=pose_map, home=home, order=order, pause=pause)
    except ConfigError as error:
        raise ConfigError(f"{where}: {error}") from None
