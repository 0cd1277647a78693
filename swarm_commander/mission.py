"""Missions: the route of a robot, as written in `params/missions/*.yaml`, without any ROS."""

from __future__ import annotations

import random
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from swarm_commander import exchange
from swarm_common.errors import ConfigError, UnknownNameError
from swarm_common.records import CONTROL_PERIOD, Pose
from swarm_common.resources import share_directory
from swarm_common.sites import Sites, area_count
from swarm_common.yaml_io import check_keys, number, numbers, read_yaml

HOME = "home"
ORDERS = ("as_written", "random")
SWAPS = ("opposite", "other_area")
KINDS = "exactly one of 'stations', 'pose', 'home', 'swap' and 'roam'"


@dataclass(frozen=True, slots=True, kw_only=True)
class Leg:
    """A part of the route: stations by name, one pose of its own, home, or where others are.

    Attributes:
        stations: Names.
        take: Only this many of the stations, from the first in order; None for all.
        order: Of the stations.
        pose_map: A pose.
        home: Where the robot started.
        swap: Where another robot started: `opposite` is half the swarm further on, `other_area`
            a random one of another spawn area.
        roam: Number of random places of the world, no two robots to the same one at a time.
        distance: [m] at least between one place and the next, of `roam`.
        pause: [s] after arriving at each.
    """

    stations: tuple[str, ...] = ()
    take: int | None = None
    order: str = "as_written"
    pose_map: Pose | None = None
    home: bool = False
    swap: str = ""
    roam: int = 0
    distance: float = 0.0
    pause: float = 0.0

    def __post_init__(self) -> None:
        given = (self.stations, self.pose_map is not None, self.home, self.swap, self.roam)
        if sum(map(bool, given)) != 1:
            raise ConfigError(f"a leg needs {KINDS}")
        if self.order not in ORDERS:
            raise UnknownNameError("order", self.order, ORDERS)
        if self.swap and self.swap not in SWAPS:
            raise UnknownNameError("swap", self.swap, SWAPS)
        if self.roam < 0:
            raise ConfigError(f"roam is {self.roam}; it must be a positive number of places")
        if self.take is not None and not 1 <= self.take <= len(self.stations):
            raise ConfigError(f"take is {self.take}; expected 1 to {len(self.stations)} stations")
        for name in ("pause", "distance"):
            if getattr(self, name) < 0.0:
                raise ConfigError(f"{name} is {getattr(self, name)}; it must not be negative")

    @property
    def needs_all_homes(self) -> bool:
        """Whether one robot's goals depend on where the others started."""
        return bool(self.swap or self.roam)


@dataclass(frozen=True, slots=True)
class Stop:
    """One goal of one robot.

    Attributes:
        name: For the operator.
        pose_map: Where.
        pause_ticks: Stay after arriving.
        delay_ticks: Stay before setting off for it.
    """

    name: str
    pose_map: Pose
    pause_ticks: int
    delay_ticks: int = 0


@dataclass(frozen=True, slots=True, kw_only=True)
class Mission:
    """A route and how often a goal is tried again.

    Attributes:
        name: Of the file.
        route: In order.
        retries: Times that a goal is tried again.
        spawn: Name of the world's spawn that the robots start from; empty for the default one.
        start_spread: [s] within which the robots set off, each after a random delay.
    """

    name: str
    route: tuple[Leg, ...]
    retries: int = 3
    spawn: str = ""
    start_spread: float = 0.0

    def __post_init__(self) -> None:
        if not self.route:
            raise ConfigError("the route is empty; expected at least one leg")
        if self.retries < 0:
            raise ConfigError(f"retries is {self.retries}; it must not be negative")
        if self.start_spread < 0.0:
            raise ConfigError(f"start_spread is {self.start_spread} s; it must not be negative")

    @property
    def is_single_goal(self) -> bool:
        """Whether there is only one pose to go to."""
        return len(self.route) == 1 and self.route[0].pose_map is not None

    @property
    def needs_all_homes(self) -> bool:
        """Whether one robot's goals depend on where the others started."""
        return any(leg.needs_all_homes for leg in self.route)

    def check_stations(self, sites: Sites, where: str) -> None:
        """Check that the world has every station, place and spawn of the route.

        Raises:
            UnknownNameError: For the first that it lacks.
            ConfigError: If it has no places for robots that are to roam.
        """
        sites.spawn_named(self.spawn)
        for leg in self.route:
            if leg.roam and not sites.places:
                raise ConfigError(f"a 'roam' leg needs 'places', which {where} does not have")
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
        homes_map: Sequence[Pose] = (),
    ) -> list[Stop]:
        """Return the goals of one robot in order; equal arguments give equal goals.

        Args:
            sites: Of the world; must have the route's stations.
            home_map: Where the robot goes for a `home` leg.
            seed: Of the run.
            robot_id: 3 for Srobot3; robots draw different orders from one seed.
            laps: Times that the route is driven, each with an order of its own.
            limit: Cut after this many goals; None for all.
            homes_map: Where all robots start, for legs that need to know.

        Raises:
            ConfigError: If such a leg does not get them, or there are too few places.
        """
        if self.needs_all_homes and not homes_map:
            raise ConfigError(
                f"mission {self.name} sends robots to where others started;"
                " that is known to swarm-up --mission only"
            )
        stops = []
        for lap in range(laps):
            for number, leg in enumerate(self.route):
                key = f"{lap}/{number}"
                draw = _Draw(sites, home_map, tuple(homes_map), robot_id, self.spawn, seed, key)
                stops += draw.stops(leg)
        if stops and self.start_spread:
            spread = random.Random(f"{seed}/{robot_id}/start").uniform(0.0, self.start_spread)
            first = stops[0]
            delay = round(spread / CONTROL_PERIOD)
            stops[0] = Stop(first.name, first.pose_map, first.pause_ticks, delay)
        return stops[:limit]


@dataclass(frozen=True, slots=True)
class _Draw:
    """What one leg means for one robot in one lap."""

    sites: Sites
    home_map: Pose
    homes_map: tuple[Pose, ...]
    robot_id: int
    spawn: str
    seed: int
    key: str  # of lap and leg

    def stops(self, leg: Leg) -> list[Stop]:
        pause_ticks = round(leg.pause / CONTROL_PERIOD)
        return [Stop(name, pose_map, pause_ticks) for name, pose_map in self._goals(leg)]

    def _goals(self, leg: Leg) -> list[tuple[str, Pose]]:
        if leg.home:
            return [(HOME, self.home_map)]
        if leg.pose_map is not None:
            return [(f"({leg.pose_map.x:g}, {leg.pose_map.y:g})", leg.pose_map)]
        if leg.swap:
            return [self._swapped(leg.swap)]
        if leg.roam:
            return self._roamed(leg)
        names = list(leg.stations)
        if leg.order == "random":
            random.Random(f"{self.seed}/{self.robot_id}/{self.key}").shuffle(names)
        return [(name, self.sites.stations[name]) for name in names[: leg.take]]

    def _swapped(self, swap: str) -> tuple[str, Pose]:
        count = len(self.homes_map)
        if swap == "opposite":
            partners = exchange.opposite(count)
        else:
            areas = area_count(self.sites.spawn_named(self.spawn))
            partners = exchange.other_groups(count, areas, f"{self.seed}/{self.key}")
        partner = partners[self.robot_id - 1]
        home_map = self.homes_map[partner]
        # as a robot arrives there: looking the way that it came
        pose_map = Pose(home_map.x, home_map.y, self.home_map.yaw)
        return f"home of Srobot{partner + 1}", pose_map

    def _roamed(self, leg: Leg) -> list[tuple[str, Pose]]:
        places = self.sites.places
        if len(places) < len(self.homes_map):
            raise ConfigError(
                f"the world has {len(places)} places for {len(self.homes_map)} roaming robots"
            )
        rounds = exchange.roaming(
            self.homes_map, places, leg.roam, leg.distance, f"{self.seed}/{self.key}"
        )
        chosen = [row[self.robot_id - 1] for row in rounds]
        return [(f"place {index + 1}", places[index]) for index in chosen]


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
    check_keys(
        content, ("description", "retries", "spawn", "start_spread", "route"), str(path)
    )
    route = content.get("route")
    if not isinstance(route, list):
        raise ConfigError(f"{path}: route is {route!r}; expected a list of legs")
    legs = tuple(_parse_leg(leg, f"{path}: route, leg {i}") for i, leg in enumerate(route, 1))
    try:
        return Mission(
            name=path.stem,
            route=legs,
            retries=_integer(content.get("retries", 3), "retries"),
            spawn=_text(content.get("spawn", ""), "spawn"),
            start_spread=number(content.get("start_spread", 0.0), "start_spread"),
        )
    except UnknownNameError:
        raise
    except ConfigError as error:
        raise ConfigError(f"{path}: {error}") from None


def _parse_leg(content: Any, where: str) -> Leg:
    if not isinstance(content, dict):
        raise ConfigError(f"{where} is {content!r}; expected {KINDS}")
    known = ("stations", "take", "order", "pose", "home", "swap", "roam", "distance", "pause")
    check_keys(content, known, where)
    names = content.get("stations", [])
    if not isinstance(names, list) or not all(isinstance(name, str) for name in names):
        raise ConfigError(f"{where}: stations must be a list of names, like [loader_1, shipping]")
    home = content.get("home", False)
    if not isinstance(home, bool):
        raise ConfigError(f"{where}: home is {home!r}; expected true")
    pose = content.get("pose")
    try:
        return Leg(
            stations=tuple(names),
            take=_integer(content["take"], "take") if "take" in content else None,
            order=str(content.get("order", "as_written")),
            pose_map=None if pose is None else Pose(*numbers(pose, 3, "pose [x, y, yaw]")),
            home=home,
            swap=_text(content.get("swap", ""), "swap"),
            roam=_integer(content.get("roam", 0), "roam"),
            distance=number(content.get("distance", 0.0), "distance"),
            pause=number(content.get("pause", 0.0), "pause"),
        )
    except ConfigError as error:
        raise ConfigError(f"{where}: {error}") from None


def _integer(value: object, what: str) -> int:
    if isinstance(value, bool) or not isinstance(value, int):
        raise ConfigError(f"{what} is {value!r}; expected an integer")
    return value


def _text(value: object, what: str) -> str:
    if not isinstance(value, str):
        raise ConfigError(f"{what} is {value!r}; expected a text")
    return value
