"""The robot's own errand: when it goes to charge, to which station, and until when.

It goes once its charge is down to `battery.low` and what the way to the nearest charging station
takes, with a reserve for detours. It asks for the station by the same lease as for any other. Of
the stations it takes the one where it expects to be charged first, by the way there and by the
robots that it hears asking for it. Where others come first, it looks again from time to time: only
near a station are all heard that ask for it.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from swarm_common.model.battery import BatteryReading, BatterySpec, charging_time
from swarm_common.model.records import Pose
from swarm_nav.core.goals import PlanError
from swarm_nav.planning.planner import Planner
from swarm_nav.traffic.lease import SAME_STATION, Lease
from swarm_nav.traffic.robot_state import RobotView

RESERVE = 2.0  # times the energy of the way to a charging station
CURRENT_PATIENCE = 10.0  # [s] at a station without current, after which it does not charge
FAILED_TIME = 60.0  # [s] for which a station is not tried again
LOOK_PERIOD = 10.0  # [s] between two looks for a better station
SAVED_SHARE = 0.5  # of a robot's charging time that another station must save


class ChargingTrip:
    """The way to a charging station and the stay there; at most one at a time.

    Attributes:
        reading: The newest of the battery; None before the first.
        charger: Pose in map of the charging station to which the robot drives, or at which it is;
            None without one.
        plugged_tick: Tick at which it arrived there; 0 on its way.
        reach: [m] that it can drive before it goes to charge; 0 once it does, inf if it has charged
            enough or has no charging station.
    """

    def __init__(self, battery: BatterySpec, chargers: Sequence[Pose]) -> None:
        """Start before the first reading.

        Args:
            chargers: Charging stations in map; may be none.
        """
        self._battery = battery
        self._chargers = list(chargers)
        self._failed_until: dict[Pose, int] = {}  # tick
        self._planner: Planner | None = None  # of the map that `_costs` are of
        self._costs: dict[Pose, NDArray[np.float32]] = {}  # [m] from each lattice cell, flat
        self.reading: BatteryReading | None = None
        self.charger: Pose | None = None
        self.plugged_tick = 0
        self.reach = math.inf

    @property
    def is_plugged(self) -> bool:
        """Whether the robot stands where it is charged."""
        return self.charger is not None and self.plugged_tick > 0

    def begin(self, charger: Pose) -> None:
        """Set off for a station, also for another one than before."""
        self.charger, self.plugged_tick, self.reach = charger, 0, 0.0

    def end(self) -> None:
        """Forget the station."""
        self.charger, self.plugged_tick = None, 0

    def fail(self, tick: int, retry_ticks: int) -> None:
        """Avoid the present station for a while, and forget it."""
        if self.charger is not None:
            self._failed_until[self.charger] = tick + retry_ticks
        self.end()

    def is_charged(self, robot: RobotView) -> bool:
        """Whether the battery holds what is enough."""
        reading = self.reading
        return reading is not None and reading.share >= robot.config.battery.enough

    def lacks_current(self, robot: RobotView) -> bool:
        """Whether the station that the robot stands at does not charge it."""
        stay = robot.tick - self.plugged_tick
        is_charged = self.reading is not None and self.reading.is_on_charger
        return stay > robot.ticks(CURRENT_PATIENCE) and not is_charged

    def choice(self, robot: RobotView) -> Pose | None:
        """Return the station to charge at; None as long as the battery lasts, or without one."""
        reading = self.reading
        if reading is None or reading.tick != robot.tick or self.charger is not None:
            return None
        ways = self._ways(robot)
        if not ways:
            self.reach = math.inf
            return None
        nearest = RESERVE * min(ways.values())
        speed = robot.config.controller.max_vel_x
        spare = reading.share - robot.config.battery.low
        reach = spare / self._battery.share_of_way(1.0, speed) - nearest
        self.reach = math.inf if self.is_charged(robot) else max(0.0, reach)
        if spare > self._battery.share_of_way(nearest, speed):
            return None
        return min(ways, key=lambda charger: self._time_to_turn(robot, charger, ways[charger]))

    def better(self, robot: RobotView, lease: Lease) -> Pose | None:
        """Return another station where the robot is charged much earlier; None without one.

        Args:
            lease: Its place in the queue of the present one.
        """
        is_due = (robot.tick + 7 * robot.robot_id) % robot.ticks(LOOK_PERIOD) == 0
        if self.charger is None or self.is_plugged or not is_due or not lease.place:
            return None
        times = {
            charger: self._time_to_turn(
                robot, charger, way, lease.place if charger == self.charger else None
            )
            for charger, way in self._ways(robot).items()
        }
        best = min(times, key=times.__getitem__, default=self.charger)
        saved = SAVED_SHARE * self._charging_time(robot)
        present = times.get(self.charger, math.inf)
        return best if best != self.charger and times[best] + saved < present else None

    def _ways(self, robot: RobotView) -> dict[Pose, float]:
        """Return the way [m] to each station that is in reach and has not failed lately."""
        tick, planner = robot.tick, robot.planner
        if planner is not self._planner:
            self._planner, self._costs = planner, {}
        node = planner.lattice.node_of(*robot.stop_point)
        ways = {}
        for charger in self._chargers:
            if self._failed_until.get(charger, 0) > tick:
                continue
            if charger not in self._costs:
                try:
                    costs = planner.cost_to_go((charger.x, charger.y), math.nan)
                except PlanError:
                    costs = np.full(planner.lattice.base.shape, np.inf, np.float32)
                self._costs[charger] = costs.ravel()
            way = math.inf if node is None else float(self._costs[charger][node])
            if math.isfinite(way):
                ways[charger] = way
        return ways

    def _time_to_turn(
        self, robot: RobotView, charger: Pose, way: float, ahead: int | None = None
    ) -> float:
        """Return the time [s] until the robot is charged at a station, as far as it knows.

        Args:
            way: [m] to it.
            ahead: Robots before this one in its queue; None for all that are heard.
        """
        if ahead is None:
            place = np.array([(charger.x, charger.y)])
            ahead, _, _ = robot.neighbors.queue(place, robot.tick, SAME_STATION)
        drive = way / robot.config.controller.max_vel_x
        return drive + ahead * self._charging_time(robot)

    def _charging_time(self, robot: RobotView) -> float:
        limits = robot.config.battery
        return charging_time(self._battery, limits.enough - limits.low)
