"""Orders in the bench: the robots' goals come from what stations and robots agree on."""

from __future__ import annotations

import dataclasses
from collections.abc import Collection, Mapping, Sequence

from swarm_common.model.records import FloatArray
from swarm_mission.itinerary import NextGoal
from swarm_mission.mission import Mission
from swarm_mission.orders.courier import Courier
from swarm_mission.orders.demand import measured_demand
from swarm_mission.orders.floor_use import SAMPLE_TICKS
from swarm_mission.orders.order import OrderPlan
from swarm_mission.orders.order_run import OrderRun
from swarm_mission.orders.radio import OrderRadio
from swarm_mission.orders.robot_bidder import BidSenses
from swarm_mission.orders.way_lengths import WayLengths
from swarm_nav.core.goals import Status
from swarm_run.loop import Driver
from swarm_sim.world.setup import WorldSetup


def make_orders(
    mission: Mission,
    plan: OrderPlan,
    setup: WorldSetup,
    drivers: Sequence[Driver],
    radio: OrderRadio,
    seed: int,
) -> BenchOrders:
    """Return the orders of a mission.

    Raises:
        ConfigError: If no swarm can serve them.
    """
    sites, specs = setup.scene.sites, setup.specs
    homes = dict(zip(setup.names, setup.starts, strict=True))
    ways, remarks = measured_demand(plan, sites, setup.grid, specs, len(specs))
    run = OrderRun(
        plan, homes, sites.stations, radio, seed, retries=mission.retries, remarks=remarks
    )
    robots = [OrderSenses(driver, ways) for driver in drivers]
    senses = [
        BidSenses(robot.way_to, spec.max_vel_x, way_between=ways.between)
        if spec.battery is None
        else BidSenses(
            robot.way_to, spec.max_vel_x, robot.charge, robot.reach, way_between=ways.between
        )
        for robot, spec in zip(robots, specs, strict=True)
    ]
    return BenchOrders(run, robots, dict(zip(homes, senses, strict=True)))


class OrderSenses:
    """State of a robot for its bids, asked for once in a tick at most."""

    def __init__(self, driver: Driver, ways: WayLengths) -> None:
        self._driver, self._ways = driver, ways
        self._status: Status | None = None

    def forget(self) -> None:
        """Another tick has begun."""
        self._status = None

    def way_to(self, station: str) -> float:
        """Return the way [m] to a station."""
        pose = self._now().pose_map
        return self._ways.length(pose.x, pose.y, station)

    def charge(self) -> float:
        """Return the battery's charge by its capacity; NaN without one."""
        return self._now().battery

    def reach(self) -> float:
        """Return the way [m] that the robot can drive before it goes to charge."""
        return self._now().reach

    def _now(self) -> Status:
        if self._status is None:
            self._status = self._driver.status()
        return self._status


class BenchOrders:
    """The orders of a run in progress.

    Attributes:
        run: Stations, robots and radio.
        couriers: One per robot, in their order.
    """

    def __init__(
        self, run: OrderRun, robots: Sequence[OrderSenses], senses: Mapping[str, BidSenses]
    ) -> None:
        self.run = run
        self.couriers: list[Courier] = list(run.couriers.values())
        self._robots = robots
        self._senses = senses

    def step(
        self, tick: int, dead: Collection[str], off_duty: Collection[str] = ()
    ) -> dict[str, NextGoal]:
        """Let stations and robots decide; return new goals by name of the robot.

        Args:
            off_duty: Robots that finish what they have, and take nothing more.
        """
        for robot in self._robots:
            robot.forget()
        resting = {
            name: dataclasses.replace(self._senses[name], is_on_duty=False) for name in off_duty
        }
        return self.run.step(tick, {**self._senses, **resting}, dead)

    def watch(
        self, tick: int, names: Sequence[str], poses: FloatArray, dead: Collection[str]
    ) -> None:
        """Sample where the robots are.

        Args:
            poses: True ones (n, 3) in map.
        """
        if tick % SAMPLE_TICKS:
            return
        for name, (x, y, _), courier in zip(names, poses.tolist(), self.couriers, strict=True):
            if name not in dead:
                self.run.floor.note(tick, name, x, y, courier.share)
