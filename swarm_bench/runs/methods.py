"""What drives a robot in the bench: our navigator, or a baseline with the same face."""

from __future__ import annotations

import importlib
from collections.abc import Iterator
from typing import Protocol, runtime_checkable

from swarm_central.team import TeamFactory
from swarm_common.model.battery import BatteryReading
from swarm_common.model.beacon import Reception
from swarm_common.model.errors import UnknownNameError
from swarm_common.model.grid import Grid
from swarm_common.model.records import Odometry, Pose, RobotSpec, Scan
from swarm_common.model.sites import Sites
from swarm_nav.core.config import NavConfig
from swarm_nav.core.goals import Goal, Output, Status


class Driver(Protocol):
    """One robot's decisions; `swarm_nav.behaviour.navigator.Navigator` is one.

    In each tick `on_odom` and `on_reception` come first, `on_scan` when a scan is due, then
    `tick`. The output's beacon must be filled in: at least id, tick, radius, pose, twist and
    one held point (the pose), since bench and radio read them. A goal has ended when a `GoalEnded`
    is among the output's events.
    """

    def on_odom(self, odom: Odometry) -> None:
        """Take the odometry of this tick."""

    def on_scan(self, scan: Scan) -> None:
        """Take a scan."""

    def on_battery(self, reading: BatteryReading) -> None:
        """Take a reading of the battery, once a second where the robot has one."""

    def on_reception(self, reception: Reception) -> None:
        """Take the beacons heard in this tick.

        Args:
            reception: Beacons as words, and the rows that are heard; it does not change in this
                tick.
        """

    def set_goal(self, goal: Goal) -> None:
        """Take a goal of kind NAVIGATE, for its start tick.

        Args:
            goal: It replaces one that has not ended.
        """

    def tick(self, tick: int) -> Output:
        """Decide.

        Args:
            tick: Now, later than at the last call.

        Returns:
            The twist to drive, the beacon to send, and what happened since the last tick.
        """

    def status(self) -> Status:
        """Return counters for the result."""


@runtime_checkable
class StagedDriver(Driver, Protocol):
    """A driver that can decide in stages, between which others decide: the same, but faster."""

    def stages(self, tick: int) -> Iterator[Output | None]:
        """Decide in a number of stages that is the same for all drivers.

        Args:
            tick: As of `tick`.

        Yields:
            None after each stage, at last what `tick` returns.
        """


class Method(Protocol):
    """Makes the driver of one robot; the signature of `Navigator`."""

    def __call__(
        self,
        config: NavConfig,
        spec: RobotSpec,
        grid: Grid,
        sites: Sites,
        robot_id: int,
        initial_pose_map: Pose,
    ) -> Driver:
        """Return a driver of a robot that stands at a pose."""


METHODS = {
    "ours": "swarm_nav.behaviour.navigator:Navigator",
    "dwa": "swarm_bench.baselines.dwa:DwaDriver",
    "orca": "swarm_bench.baselines.orca:OrcaDriver",
    "central-mapf": "swarm_bench.baselines.commanded:CommandedDriver",
}
TEAMS = {"central-mapf": "swarm_central.mapf:MapfCentre"}  # the centre of methods that have one


def load_method(name: str) -> Method:
    """Return a method by name.

    Args:
        name: One of `METHODS`.

    Raises:
        UnknownNameError: If there is none.
    """
    if name not in METHODS:
        raise UnknownNameError("method", name, METHODS)
    module, _, attribute = METHODS[name].partition(":")
    method: Method = getattr(importlib.import_module(module), attribute)
    return method


def load_team(name: str) -> TeamFactory | None:
    """Return what makes the centre of a method; None if each robot decides alone."""
    if name not in TEAMS:
        return None
    module, _, attribute = TEAMS[name].partition(":")
    factory: TeamFactory = getattr(importlib.import_module(module), attribute)
    return factory
