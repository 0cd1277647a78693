"""One robot: bids for orders that it hears of, and reports on those that it holds.

It knows the orders that it holds, and those that stations have announced lately; nothing of other
robots.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

from swarm_mission.orders.messages import (
    Announcement,
    AnyMessage,
    Bid,
    Envelope,
    Grant,
    HoldPhase,
    HoldReport,
    Load,
    OrderOffer,
    Received,
    Unload,
    Void,
)
from swarm_mission.orders.order import TransportOrder
from swarm_mission.orders.station_agent import urgency

# Ticks of 0.1 s.
OFFER_LIFE = 15  # for which an announcement counts
BID_PATIENCE = 15  # to wait for the answer to a bid
REPORT_TICKS = 10  # between two reports on an order
ASK_TICKS = 3  # between two questions at a station
AGE_SPEED = 0.1  # [m/s] of cost that an order gets cheaper while it waits
HELD_COST = 10.0  # [m] for each order that the robot has already
BATTERY_COST = 10.0  # [m] for an empty battery
LEAST_BATTERY = 0.2  # charge below which it does not bid
TICKS_PER_SECOND = 10.0


@dataclass(frozen=True, slots=True)
class BidSenses:
    """State of a robot from which its bids follow."""

    way_to: Callable[[str], float]  # [m] to a station by name; inf if there is no way
    speed: float  # [m/s] at most
    charge: Callable[[], float] = lambda: math.nan  # by capacity; NaN without a battery
    # [m] that it can drive before it goes to charge; 0 once it does
    reach: Callable[[], float] = lambda: math.inf
    way_between: Callable[[str, str], float] = lambda first, second: 0.0  # [m], of two stations
    is_on_duty: bool = True  # whether the robot takes further orders

    @property
    def is_fit(self) -> bool:
        """Whether duty and battery allow for another order."""
        return self.is_on_duty and not self.charge() < LEAST_BATTERY and self.reach() > 0.0

    def can_end(self, station: str, target: str) -> bool:
        """Whether the robot can do an order before it goes to charge."""
        return self.way_to(station) + self.way_between(station, target) <= self.reach()

    def cost(self, station: str, held: int) -> float:
        """Return what an order at a station costs [m] with so many orders held already."""
        charge = self.charge()
        drained = 0.0 if math.isnan(charge) else 1.0 - charge
        return self.way_to(station) + HELD_COST * held + BATTERY_COST * drained


@dataclass(slots=True)
class HeldOrder:
    """An order that the robot holds."""

    order: TransportOrder
    number: int  # of the grant
    phase: HoldPhase = HoldPhase.COMING
    is_at_target: bool = False
    told: int = -REPORT_TICKS  # tick of the latest report or question


class RobotBidder:
    """The state machine of one robot's bids and reports; it has no clock and does no I/O.

    Attributes:
        held: Orders by id, in the order of their grants.
        receipts: Orders whose goods a station has taken, with whether they were new to it.
    """

    def __init__(self, name: str, *, capacity: int = 1, bids_for_all: bool = False) -> None:
        """Begin without orders.

        Args:
            capacity: Orders that the robot carries at a time.
            bids_for_all: Whether a dispatcher chooses, who wants to know all costs; else the robot
                bids for the order that suits it best.
        """
        self.name = name
        self.held: dict[str, HeldOrder] = {}
        self.receipts: dict[str, bool] = {}
        self.idle_since = 0  # tick
        self._capacity = capacity
        self._bids_for_all = bids_for_all
        self._offers: dict[str, tuple[int, tuple[OrderOffer, ...]]] = {}  # with tick, by station
        self._bid: tuple[str, int] | None = None  # order and tick of the bid that is out
        self._replies: list[Envelope] = []

    def receive(self, message: AnyMessage, tick: int) -> None:
        """Receive a message, which may be late, repeated, or for others."""
        if isinstance(message, Announcement):
            self._offers[message.station] = tick, message.offers
            return
        if not isinstance(message, Grant | Load | Void | Received) or message.robot != self.name:
            return
        if isinstance(message, Grant):
            self._on_grant(message, tick)
            return
        held = self.held.get(message.order)
        if held is None:
            return
        if isinstance(message, Received):
            if held.is_at_target:
                self.receipts[message.order] = message.is_new
                del self.held[message.order]
        elif held.number <= message.number:
            if isinstance(message, Void):
                if not held.is_at_target:  # there the target answers
                    del self.held[message.order]
            elif held.phase is HoldPhase.HERE:
                held.phase = HoldPhase.LOADED

    def _on_grant(self, grant: Grant, tick: int) -> None:
        held = self.held.get(grant.order.id)
        if held is not None and held.number >= grant.number:
            return
        if held is None and len(self.held) >= self._capacity:
            self._report(grant.station, grant.order.id, grant.number, HoldPhase.RELEASED)
            return
        self.held[grant.order.id] = HeldOrder(grant.order, grant.number)
        self._bid = None

    # What the robot does

    def arrive(self, order: str) -> None:
        """The robot is at the station that it has come to for an order."""
        held = self.held[order]
        if held.phase is HoldPhase.LOADED:
            held.is_at_target = True
        else:
            held.phase = HoldPhase.HERE
        held.told = -REPORT_TICKS

    def give_back(self) -> None:
        """Give all orders back that the robot is only on its way for."""
        for order in [o for o, held in self.held.items() if held.phase is HoldPhase.COMING]:
            self.release(order)

    def release(self, order: str) -> None:
        """Give an order back that is not loaded."""
        held = self.held.pop(order)
        self._report(held.order.origin, order, held.number, HoldPhase.RELEASED)

    def tick(self, tick: int, senses: BidSenses | None) -> list[Envelope]:
        """Decide; return what to send.

        Args:
            senses: None for a robot that does not bid now.
        """
        for held in self.held.values():
            self._tell(held, tick)
        if senses is not None and len(self.held) < self._capacity and senses.is_fit:
            self._choose(tick, senses)
        sent, self._replies = self._replies, []
        return sent

    def _tell(self, held: HeldOrder, tick: int) -> None:
        is_asking = held.phase is HoldPhase.HERE or held.is_at_target
        if tick - held.told < (ASK_TICKS if is_asking else REPORT_TICKS):
            return
        held.told = tick
        order = held.order
        if held.is_at_target:
            self._send(
                order.target,
                Unload(order.target, self.name, order.id, order.origin, order.unload_ticks),
            )
        self._report(order.origin, order.id, held.number, held.phase)

    def _choose(self, tick: int, senses: BidSenses) -> None:
        offers = {
            offer.order: (station, offer)
            for station, (at, offered) in self._offers.items()
            if tick - at <= OFFER_LIFE
            for offer in offered
            if offer.order not in self.held and senses.can_end(station, offer.target)
        }
        if self._bids_for_all:
            for station, offer in offers.values():
                if self._offers[station][0] == tick or tick == self.idle_since:
                    self._make_bid(station, offer, tick, senses)
            return
        if self._bid is not None:
            order, at = self._bid
            if order in offers and tick - at < BID_PATIENCE:
                return
        ranked = [
            (self._rank(station, offer, tick, senses), station, offer)
            for station, offer in offers.values()
        ]
        if ranked:
            _, station, offer = min(ranked, key=lambda item: (item[0], item[2].order))
            if self._make_bid(station, offer, tick, senses):
                self._bid = offer.order, tick

    def _rank(
        self, station: str, offer: OrderOffer, tick: int, senses: BidSenses
    ) -> tuple[int, int, float]:
        priority, overdue, _ = urgency(offer, tick)
        age = (tick - offer.created) / TICKS_PER_SECOND
        return priority, overdue, senses.cost(station, len(self.held)) - AGE_SPEED * age

    def _make_bid(self, station: str, offer: OrderOffer, tick: int, senses: BidSenses) -> bool:
        cost = senses.cost(station, len(self.held))
        if not math.isfinite(cost):
            return False
        eta = round(senses.way_to(station) / senses.speed * TICKS_PER_SECOND)
        bid = Bid(station, self.name, offer.order, cost, eta, self.idle_since)
        self._send("" if self._bids_for_all else station, bid)
        return True

    def _report(self, station: str, order: str, number: int, phase: HoldPhase) -> None:
        self._send(station, HoldReport(station, self.name, order, number, phase))

    def _send(self, receiver: str, message: AnyMessage) -> None:
        self._replies.append(Envelope(self.name, receiver, message))
