"""Missions: the route of a robot, as written in `params/missions/*.yaml`, without any ROS."""

from __future__ import annotations

import random
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Annotated

from msgspec import Meta

from swarm_common.files.convert import located, read
from swarm_common.files.resources import names_to_propose, share_directory
from swarm_common.model.errors import ConfigError, UnknownNameError
from swarm_common.model.records import CONTROL_PERIOD, Pose
from swarm_common.model.robot_names import RobotNames
from swarm_common.model.schema import NotNegative
from swarm_common.model.sites import Sites, area_count
from swarm_mission.leg import HOME, Draw, Leg, Stop
from swarm_mission.orders.dispatch import load_dispatcher
from swarm_mission.orders.order import OrderPlan, check_names
from swarm_mission.orders.order_file import ORDER_KEYS, OrderFile

USUAL = "loading_route"  # mission of a robot that got none


@dataclass(frozen=True, slots=True, kw_only=True)
class Mission:
    """A route, or orders, and how often a goal is tried again."""

    name: str  # of the file
    route: tuple[Leg, ...] = ()  # in order; empty for orders
    orders: OrderPlan | None = None  # that robots serve instead of a route
    retries: int = 3  # times that a goal is tried again
    # name of the world's spawn that the robots start from; empty for the default one
    spawn: str = ""
    start_spread: float = 0.0  # [s] within which the robots set off, each after a random delay

    def __post_init__(self) -> None:
        if not self.route and self.orders is None:
            raise ConfigError("the route is empty; expected at least one leg")
        if self.route and self.orders is not None:
            raise ConfigError("there are orders and a route; expected one of the two")

    @property
    def stations(self) -> tuple[str, ...]:
        """Names of the stations that robots are sent to, sorted."""
        if self.orders is not None:
            return self.orders.stations
        return tuple(sorted({name for leg in self.route for name in leg.stations}))

    def with_groups(self, sites: Sites) -> Mission:
        """Return this mission with stations in place of the groups that the world has.

        Raises:
            ConfigError: If orders would go from a station to itself.
        """
        if self.orders is None:
            return self
        return replace(self, orders=self.orders.with_groups(sites.groups))

    def dispatched_by(self, dispatch: str) -> Mission:
        """Return this mission with orders that somebody else gives to the robots.

        Args:
            dispatch: Name of the dispatcher, as in a mission file.

        Raises:
            ConfigError: If it has no orders, or there is no such dispatcher.
        """
        if self.orders is None:
            raise ConfigError(f"dispatch is '{dispatch}', but mission {self.name} has no orders")
        load_dispatcher(dispatch)
        return replace(self, orders=replace(self.orders, dispatch=dispatch))

    @property
    def is_single_goal(self) -> bool:
        """Whether there is only one pose to go to."""
        return len(self.route) == 1 and self.route[0].pose_map is not None

    @property
    def needs_all_homes(self) -> bool:
        """Whether one robot's goals depend on where the others started."""
        return any(leg.needs_all_homes for leg in self.route)

    def check_stations(
        self, sites: Sites, where: str, *, robots: int = 1, highest: int = 1
    ) -> None:
        """Check that the world has every station, place and spawn of the route.

        Args:
            where: Source of the sites, for the message.
            robots: Size of the swarm; each that roams needs a place.
            highest: Number of the last robot with this mission, which needs a place of its own.

        Raises:
            UnknownNameError: For the first that it lacks.
            ConfigError: If it has too few places, or no areas for `swap: other_area`;
                or a goal lies in a keepout zone.
        """
        count = len(sites.places)
        areas = area_count(sites.spawn_named(self.spawn))
        if self.orders is not None:
            check_names(self.orders, sites.stations, where)
        for leg in self.route:
            if leg.swap == "other_area" and areas < 2:
                raise ConfigError(
                    f"a 'swap: other_area' leg needs a spawn of several areas, which {where} does"
                    " not have; 'swap: opposite' needs none"
                )
            kind, needed = ("roam", robots) if leg.roam else ("own_place", highest)
            if (leg.roam or leg.own_place) and not count:
                raise ConfigError(f"a '{kind}' leg needs 'places', which {where} does not have")
            if (leg.roam or leg.own_place) and count < needed:
                raise ConfigError(
                    f"a '{kind}' leg needs a place for each of {needed} robots; {where}, has"
                    f" {count}: add 'places' there, or take at most {count} robots"
                )
            for name in leg.stations:
                if name not in sites.stations:
                    raise UnknownNameError("station", name, sites.stations, where)
            pose = leg.pose_map
            if pose is not None and (zone := sites.zones.keepout_at(pose.x, pose.y)):
                raise ConfigError(
                    f"the goal ({pose.x:g}, {pose.y:g}) lies in {zone} of {where}; no robot may go"
                    " there: move one of them"
                )

    def order_stops(self, sites: Sites, home_map: Pose) -> list[Stop]:
        """Return all places that orders may send a robot to."""
        stations = [Stop(name, sites.stations[name], 0) for name in self.stations]
        return [*stations, Stop(HOME, home_map, 0)]

    def stops(
        self,
        sites: Sites,
        home_map: Pose,
        *,
        seed: int,
        robot_id: int,
        laps: int = 1,
        first_lap: int = 0,
        limit: int | None = None,
        homes_map: Sequence[Pose] = (),
        names: RobotNames | None = None,
    ) -> list[Stop]:
        """Return the goals of one robot in order; equal arguments give equal goals.

        Args:
            sites: Sites of the world; must have the route's stations.
            home_map: Where the robot goes for a `home` leg.
            robot_id: From 1; robots draw different orders from one seed.
            laps: Times that the route is driven, each with an order of its own.
            first_lap: Number of the first of them, from 0.
            limit: Cut after this many goals; None for all.
            homes_map: Where all robots start, for legs that need to know.
            names: Names of all robots, for people; None for the usual ones.

        Raises:
            ConfigError: If such a leg does not get them, or there are too few places; or the
                mission has orders instead of a route.
        """
        if self.orders is not None:
            raise ConfigError(
                f"mission {self.name} has orders, which are for a whole swarm: run it by swarm-up"
                " --mission or swarm-bench"
            )
        if self.needs_all_homes and not homes_map:
            raise ConfigError(
                f"mission {self.name} sends robots to where others started;"
                " that is known to swarm-up --mission only"
            )
        stops: list[Stop] = []
        for lap in range(first_lap, first_lap + laps):
            if limit is not None and len(stops) >= limit:
                break
            for index, leg in enumerate(self.route):
                key = f"{lap}/{index}"
                draw = Draw(
                    sites,
                    home_map,
                    tuple(homes_map),
                    robot_id,
                    self.spawn,
                    seed,
                    key,
                    names or RobotNames(),
                )
                stops += draw.stops(leg)
        if stops and self.start_spread and not first_lap:
            spread = random.Random(f"{seed}/{robot_id}/start").uniform(0.0, self.start_spread)
            first = stops[0]
            delay = round(spread / CONTROL_PERIOD)
            stops[0] = Stop(first.name, first.pose_map, first.pause_ticks, delay)
        return stops[:limit]


def single_goal(pose_map: Pose) -> Mission:
    """Return the mission of one goal.

    Args:
        pose_map: Where to, in the frame `map`.
    """
    return Mission(name="goal", route=(Leg(pose=(pose_map.x, pose_map.y, pose_map.yaw)),))


def usual_mission(sites: Sites, where: str) -> Mission:
    """Return the mission for a robot without one: `loading_route` if its world has the stations.

    Otherwise all stations in random order, or the place with the robot's number; then home.

    Raises:
        ConfigError: If the world has nothing to go to.
    """
    usual = load_mission(USUAL)
    if all(name in sites.stations for leg in usual.route for name in leg.stations):
        return usual
    if sites.work_stations:
        out = Leg(stations=sites.work_stations, order="random")
    elif sites.places:
        out = Leg(own_place=True)
    else:
        raise ConfigError(f"{where} has no stations and no places; give --goal X Y YAW")
    return Mission(name="tour", route=(out, Leg(home=True)))


def mission_names() -> list[str]:
    """Return the names of the missions that come with us, sorted."""
    return sorted(path.stem for path in _folder().glob("*.yaml"))


def mission_path(name_or_path: str) -> Path:
    """Return the file of a mission of `params/missions`, or the user's own.

    Args:
        name_or_path: Name of a mission, or a path that ends in `.yaml` or has a folder.

    Raises:
        UnknownNameError: If it is a name and no such mission exists; a path is not checked.
    """
    path = Path(name_or_path)
    if path.suffix in (".yaml", ".yml") or len(path.parts) > 1:
        return path
    names = mission_names()
    if name_or_path not in names:
        raise UnknownNameError("mission", name_or_path, names_to_propose(name_or_path, names))
    return _folder() / f"{name_or_path}.yaml"


def _folder() -> Path:
    return share_directory("params") / "params" / "missions"


def load_mission(name_or_path: str) -> Mission:
    """Return a mission of `params/missions` by name, or one from the user's own file.

    Raises:
        ConfigError: If there is no such mission or something in it is wrong.
    """
    path = mission_path(name_or_path)
    content = read(path, _MissionFile)
    with located(path):
        orders = content.order_plan(path)
        if orders is None and (key := next((k for k in ORDER_KEYS if getattr(content, k)), "")):
            raise ConfigError(f"'{key}' is for orders, and there are none; add 'orders'")
        if orders is not None and content.start_spread is not None:
            raise ConfigError("'start_spread' is for a route; orders come when they come")
        return Mission(
            name=path.stem,
            route=content.route,
            orders=orders,
            retries=content.retries,
            spawn=content.spawn,
            start_spread=content.start_spread or 0.0,
        )


class _MissionFile(OrderFile):
    """Content of a mission file."""

    description: str | None = None
    route: tuple[Leg, ...] = ()
    retries: Annotated[int, Meta(ge=0)] = 3
    spawn: str = ""
    start_spread: NotNegative | None = None
