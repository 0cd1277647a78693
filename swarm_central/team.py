"""A method that decides for all robots: what it hears from them, and what it tells them."""

from __future__ import annotations

import struct
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Protocol

from swarm_common.model.grid import Grid
from swarm_common.model.records import Pose, RobotSpec
from swarm_common.model.sites import Sites
from swarm_nav.core.config import NavConfig

REPORT = struct.Struct("<HIfffIIIffB")  # in the order of the fields of `RobotReport`
ORDER = struct.Struct("<HIIB")  # robot, number, first, number of points
POINT = struct.Struct("<ff")


@dataclass(frozen=True, slots=True, kw_only=True)
class RobotReport:
    """A robot's message to the centre, once per tick."""

    robot_id: int
    tick: int  # of the pose
    pose_map: Pose
    passed: int  # number of points of its orders that the robot has left behind
    heard: int  # number of the newest order that arrived; 0 before the first
    goal_id: int  # of the current goal; 0 without one
    goal_map: tuple[float, float]  # [m]; NaN without a goal
    has_arrived: bool  # whether the robot turns or is served at its goal

    @property
    def size(self) -> int:
        """Bytes on the air."""
        return REPORT.size


@dataclass(frozen=True, slots=True, kw_only=True)
class TeamOrder:
    """The centre's message to a robot: drive along straight lines, and stop at the last point.

    An order never takes back space that an older one gave, so a lost one costs time only.
    """

    robot_id: int
    number: int  # grows with each change
    first: int  # index of the first point among all points that the robot has been given
    points_map: tuple[tuple[float, float], ...]  # [m]

    @property
    def size(self) -> int:
        """Bytes on the air."""
        return ORDER.size + len(self.points_map) * POINT.size


class Team(Protocol):
    """Decides for all robots, once per control tick."""

    def observe(self, tick: int, states: Sequence[RobotReport]) -> None:
        """Take the reports that arrived in a tick.

        Args:
            states: At most one per robot; some are lost or late.
        """

    def decide(self) -> Sequence[TeamOrder]:
        """Return the orders to send in the tick of the last `observe`."""

    def figures(self) -> Mapping[str, float]:
        """Return counters for the result of a run, by name."""


class TeamFactory(Protocol):
    """Makes the centre of a run."""

    def __call__(
        self,
        config: NavConfig,
        specs: Sequence[RobotSpec],
        grid: Grid,
        sites: Sites,
        central: Mapping[str, Any],
    ) -> Team:
        """Return a centre that knows the robots' models and the map, but not where they are.

        Args:
            config: Of the robots.
            specs: Models of the robots.
            grid: The map.
            sites: Of the world.
            central: Parameters of the centre, by name.
        """
