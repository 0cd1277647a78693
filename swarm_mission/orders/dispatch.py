"""Who gets an order: robots by their claims, or a dispatcher that knows all, to compare with.

A dispatcher hears the announcements and all bids, and tells stations whom to choose. Stations
grant their orders as ever, so that whatever a dispatcher says, nothing is granted twice.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Protocol

import numpy as np

from swarm_common.model.errors import ConfigError
from swarm_common.process.plugins import load_plugin
from swarm_mission.orders.messages import (
    Announcement,
    AnyMessage,
    Assignment,
    Bid,
    Envelope,
    OrderOffer,
)
from swarm_mission.orders.station_agent import urgency

DISPATCHER = "dispatcher"  # its name on the radio
CLAIM = "claim"
# Ticks of 0.1 s.
DISPATCH_TICKS = 5  # between two decisions
NEWS_LIFE = 15  # for which announcements and bids count
ANSWER_TICKS = 15  # for which a robot that was assigned is left out


class Dispatcher(Protocol):
    """Decides who gets which order; the interface of `dispatch: module:Class`.

    It is made without arguments.
    """

    def assign(
        self, tick: int, offers: Sequence[OrderOffer], bids: Mapping[str, Sequence[Bid]]
    ) -> Iterable[Bid]:
        """Return the bids that are to be granted.

        Args:
            tick: Tick of 0.1 s.
            offers: Open orders of all stations, the most urgent first.
            bids: Bids of all idle robots, by order; a robot bids for each order that it hears of.

        Returns:
            Bids out of `bids`, at most one for each order and each robot.
        """


class Fifo:
    """The oldest order to the robot that has been idle for longest."""

    def assign(
        self, tick: int, offers: Sequence[OrderOffer], bids: Mapping[str, Sequence[Bid]]
    ) -> Iterable[Bid]:
        """Return the bids that are to be granted."""
        return _one_by_one(offers, bids, lambda bid: (bid.idle_since, bid.robot))


class Nearest:
    """The oldest order to the robot that has the lowest cost for it."""

    def assign(
        self, tick: int, offers: Sequence[OrderOffer], bids: Mapping[str, Sequence[Bid]]
    ) -> Iterable[Bid]:
        """Return the bids that are to be granted."""
        return _one_by_one(offers, bids, lambda bid: (bid.cost, bid.robot))


class Central:
    """All orders to all robots at the least total cost (the Hungarian method's problem)."""

    def assign(
        self, tick: int, offers: Sequence[OrderOffer], bids: Mapping[str, Sequence[Bid]]
    ) -> Iterable[Bid]:
        """Return the bids that are to be granted."""
        from scipy.optimize import linear_sum_assignment

        robots = sorted({bid.robot for each in bids.values() for bid in each})
        wanted = offers[: len(robots)]  # the most urgent that can be served
        column = {robot: index for index, robot in enumerate(robots)}
        costs = np.full((len(wanted), len(robots)), 1e9)
        chosen: dict[tuple[int, int], Bid] = {}
        for row, offer in enumerate(wanted):
            for bid in bids.get(offer.order, ()):
                costs[row, column[bid.robot]] = bid.cost
                chosen[row, column[bid.robot]] = bid
        pairs = zip(*linear_sum_assignment(costs), strict=True)
        return [chosen[pair] for row, at in pairs if (pair := (int(row), int(at))) in chosen]


DISPATCHERS = {
    CLAIM: "",  # none
    **{name: f"{__name__}:{name.title()}" for name in ("fifo", "nearest", "central")},
}


def load_dispatcher(name: str) -> Dispatcher | None:
    """Return a dispatcher by name or `module:Class`; None for `claim`.

    Raises:
        ConfigError: If there is no such class.
    """
    if name == CLAIM:
        return None
    make = load_plugin("dispatchers", name, DISPATCHERS, "dispatch")
    try:
        made: Dispatcher = make()
    except Exception as error:  # whatever a class of the user's does
        raise ConfigError(f"dispatch is '{name}', which cannot be made: {error}") from error
    if not hasattr(made, "assign"):
        raise ConfigError(f"dispatch is '{name}', which has no method 'assign'")
    return made


class DispatcherAgent:
    """A dispatcher on the radio."""

    def __init__(self, dispatcher: Dispatcher) -> None:
        self._dispatcher = dispatcher
        self._offers: dict[str, tuple[int, tuple[OrderOffer, ...]]] = {}  # with tick, by station
        self._bids: dict[tuple[str, str], tuple[int, Bid]] = {}  # with tick, by order and robot
        self._assigned: dict[str, int] = {}  # tick, by robot

    def receive(self, message: AnyMessage, tick: int) -> None:
        """Receive a message from the radio."""
        if isinstance(message, Announcement):
            self._offers[message.station] = tick, message.offers
        elif isinstance(message, Bid):
            self._bids[message.order, message.robot] = tick, message

    def tick(self, tick: int) -> list[Envelope]:
        """Decide; return what to send."""
        if tick % DISPATCH_TICKS:
            return []
        self._bids = {k: (at, b) for k, (at, b) in self._bids.items() if tick - at <= NEWS_LIFE}
        fresh = [offers for at, offers in self._offers.values() if tick - at <= NEWS_LIFE]
        offers = sorted((o for each in fresh for o in each), key=lambda o: urgency(o, tick))
        bids: dict[str, list[Bid]] = {}
        for _, bid in self._bids.values():
            if tick - self._assigned.get(bid.robot, -ANSWER_TICKS) >= ANSWER_TICKS:
                bids.setdefault(bid.order, []).append(bid)
        sent = []
        for bid in self._dispatcher.assign(tick, offers, bids):
            self._assigned[bid.robot] = tick
            message = Assignment(bid.station, bid.robot, bid.order)
            sent.append(Envelope(DISPATCHER, bid.station, message))
        return sent


def _one_by_one(
    offers: Sequence[OrderOffer],
    bids: Mapping[str, Sequence[Bid]],
    key: Callable[[Bid], tuple[float, str]],
) -> list[Bid]:
    taken: set[str] = set()
    chosen = []
    for offer in offers:
        free = [bid for bid in bids.get(offer.order, ()) if bid.robot not in taken]
        if free:
            best = min(free, key=key)
            taken.add(best.robot)
            chosen.append(best)
    return chosen
