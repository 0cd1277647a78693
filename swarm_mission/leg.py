"""One part of a mission's route, and the goals that it means for a robot."""

from __future__ import annotations

import math
import random
from dataclasses import dataclass
from typing import Annotated, Literal

from msgspec import Meta

from swarm_common.model.errors import ConfigError
from swarm_common.model.records import CONTROL_PERIOD, Pose, wrap_angle
from swarm_common.model.robot_names import RobotNames
from swarm_common.model.schema import NotNegative, PoseNumbers, Schema
from swarm_common.model.sites import Sites, area_count
from swarm_mission import exchange

HOME = "home"
KINDS = "exactly one of 'stations', 'pose', 'home', 'own_place', 'swap' and 'roam'"
Swap = Literal["opposite", "other_area"]


class Leg(Schema):
    """A part of the route: stations by name, one pose of its own, home, or where others are."""

    stations: tuple[str, ...] = ()
    take: int | None = None  # only this many of the stations, from the first in order; None for all
    order: Literal["as_written", "random"] = "as_written"  # of the stations
    pose: PoseNumbers | None = None  # in the map frame
    home: bool = False  # where the robot started
    own_place: bool = False  # the place of the world that has the robot's number
    # where another robot started: `opposite` is half the swarm further on, `other_area` a random
    # one of another spawn area
    swap: Swap | None = None
    # number of random places of the world, no two robots to the same one at a time
    roam: Annotated[int, Meta(ge=0)] = 0
    distance: NotNegative = 0.0  # [m] at least between one place and the next, of `roam`
    pause: NotNegative = 0.0  # [s] after arriving at each

    def __post_init__(self) -> None:
        given = (self.stations, self.pose, self.home, self.own_place, self.swap, self.roam)
        if sum(map(bool, given)) != 1:
            raise ConfigError(f"a leg needs {KINDS}")
        if self.take is not None and not 1 <= self.take <= len(self.stations):
            raise ConfigError(f"take is {self.take}; expected 1 to {len(self.stations)} stations")

    @property
    def pose_map(self) -> Pose | None:
        """Pose of its own."""
        return None if self.pose is None else Pose(*self.pose)

    @property
    def needs_all_homes(self) -> bool:
        """Whether one robot's goals depend on where the others started."""
        return bool(self.swap or self.roam)


@dataclass(frozen=True, slots=True)
class Stop:
    """One goal of one robot."""

    name: str  # for the operator
    pose_map: Pose  # where
    pause_ticks: int  # stay after arriving
    delay_ticks: int = 0  # stay before setting off for it


@dataclass(frozen=True, slots=True)
class Draw:
    """Input from which the stops of one leg follow, for one robot in one lap."""

    sites: Sites  # of the world
    home_map: Pose  # where the robot started
    homes_map: tuple[Pose, ...]  # where all robots started; may be empty if no leg needs them
    robot_id: int  # from 1, as in its beacons
    spawn: str  # name of the spawn that they started from
    seed: int  # of the run
    key: str  # of lap and leg, so that each has draws of its own
    names: RobotNames  # of all robots

    def stops(self, leg: Leg) -> list[Stop]:
        """Return the goals of the leg in order.

        Raises:
            ConfigError: If the world has too few places for the leg.
        """
        pause_ticks = round(leg.pause / CONTROL_PERIOD)
        return [Stop(name, pose_map, pause_ticks) for name, pose_map in self._goals(leg)]

    def _goals(self, leg: Leg) -> list[tuple[str, Pose]]:
        if leg.home:
            return [(HOME, self.home_map)]
        if leg.own_place:
            return [self._own()]
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

    def _own(self) -> tuple[str, Pose]:
        places = self.sites.places
        if self.robot_id > len(places):
            name = self.names.name_of(self.robot_id)
            raise ConfigError(f"the world has {len(places)} places; {name} has none of its own")
        return f"place {self.robot_id}", places[self.robot_id - 1]

    def _swapped(self, swap: Swap) -> tuple[str, Pose]:
        count = len(self.homes_map)
        if swap == "opposite":
            partners = exchange.opposite(count)
        else:
            areas = area_count(self.sites.spawn_named(self.spawn))
            partners = exchange.other_groups(count, areas, f"{self.seed}/{self.key}")
        partner = partners[self.robot_id - 1]
        home_map = self.homes_map[partner]
        # turned round, as a robot arrives: its partner looked to where it had to go
        pose_map = Pose(home_map.x, home_map.y, wrap_angle(home_map.yaw + math.pi))
        return f"home of {self.names.name_of(partner + 1)}", pose_map

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
