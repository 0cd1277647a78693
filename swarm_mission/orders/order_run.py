"""All stations and robots of one process, over one radio: each knows only what it hears."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from typing import Any

from swarm_common.model.records import Pose
from swarm_mission.itinerary import NextGoal
from swarm_mission.orders.courier import Courier
from swarm_mission.orders.dispatch import DISPATCHER, DispatcherAgent, load_dispatcher
from swarm_mission.orders.floor_use import FloorUse
from swarm_mission.orders.order import OrderPlan
from swarm_mission.orders.order_book import OrderBook
from swarm_mission.orders.radio import OrderRadio
from swarm_mission.orders.robot_bidder import BidSenses
from swarm_mission.orders.station_agent import StationAgent


class OrderRun:
    """Orders of a run without ROS.

    Attributes:
        agents: By station.
        couriers: By robot.
        book: What became of every order.
        floor: How floor and robots' time are used.
    """

    def __init__(
        self,
        plan: OrderPlan,
        homes_map: Mapping[str, Pose],
        stations: Mapping[str, Pose],
        radio: OrderRadio,
        seed: int,
        *,
        retries: int = 3,
        remarks: Sequence[str] = (),
    ) -> None:
        """Begin before tick 0.

        Args:
            homes_map: Where robots wait for orders, by name.
            stations: Poses in map by name.
            remarks: On the demand, for the results.

        Raises:
            ConfigError: If there is no such dispatcher.
        """
        dispatcher = load_dispatcher(plan.dispatch)
        is_central = dispatcher is not None
        self.agents = {
            name: StationAgent(name, plan.orders_from(name, seed), awaits_dispatcher=is_central)
            for name in plan.stations
        }
        self.couriers = {
            name: Courier(
                name,
                home,
                stations,
                retries=retries,
                capacity=plan.capacity,
                bids_for_all=is_central,
            )
            for name, home in homes_map.items()
        }
        self.book = OrderBook(plan.dispatch, remarks)
        self.floor = FloorUse()
        self._dispatcher = None if dispatcher is None else DispatcherAgent(dispatcher)
        self._radio = radio
        self._parties: dict[str, StationAgent | Courier | DispatcherAgent] = {
            **self.agents,
            **self.couriers,
            **({DISPATCHER: self._dispatcher} if self._dispatcher is not None else {}),
        }

    @property
    def is_over(self) -> bool:
        """Whether all orders have come and are done, and nobody is served any more."""
        return all(agent.is_over for agent in self.agents.values())

    @property
    def has_open(self) -> bool:
        """Whether an order is not done."""
        return any(agent.has_open for agent in self.agents.values())

    def step(
        self, tick: int, senses: Mapping[str, BidSenses], dead: Collection[str] = ()
    ) -> dict[str, NextGoal]:
        """Let everybody hear, decide and send.

        Args:
            senses: State of each robot that lives, by name.
            dead: Robots that do and hear nothing.

        Returns:
            Goals that replace those that robots have, by name.
        """
        for name, messages in self._radio.receive(tick, list(self._parties)).items():
            if name not in dead and name in self._parties:
                for message in messages:
                    self._parties[name].receive(message, tick)
        goals = {}
        for agent in self.agents.values():
            self._radio.send(tick, agent.tick(tick))
            self._collect(agent)
        if self._dispatcher is not None:
            self._radio.send(tick, self._dispatcher.tick(tick))
        for name, courier in self.couriers.items():
            if name in dead:
                continue
            sent, goal = courier.tick(tick, senses[name])
            self._radio.send(tick, sent)
            self._collect(courier)
            if goal is not None:
                goals[name] = goal
        return goals

    def results(self, sim_time: float) -> dict[str, Any]:
        """Return all figures of the run."""
        return {**self.book.as_json(sim_time), **self.floor.as_json()}

    def _collect(self, party: StationAgent | Courier) -> None:
        if party.events:
            self.book.apply_all(party.events)
            party.events.clear()
