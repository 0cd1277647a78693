"""One station: announces its orders, grants each to one robot, and hands the goods over.

It knows its own orders only. The latest grant of an order is the only one that counts, and goods
are handed over to its holder alone, so an order is on its way with one robot at most while that
robot is heard. Goods of a robot that stays mute are sent once more; the target takes an order's
goods once, whoever brings them, so nothing is done twice.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field

from swarm_mission.orders.messages import (
    Announcement,
    AnyMessage,
    Assignment,
    Bid,
    Delivered,
    Envelope,
    Grant,
    HoldPhase,
    HoldReport,
    Load,
    Noted,
    OrderOffer,
    Received,
    Unload,
    Void,
)
from swarm_mission.orders.order import TransportOrder
from swarm_mission.orders.order_book import OrderEvent, OrderEventKind
from swarm_mission.orders.states import ORDER_TRANSITIONS, OrderChange, OrderState

# Ticks of 0.1 s.
ANNOUNCE_TICKS = 10  # between two announcements
BID_WINDOW = 3  # from the first bid for an order to its grant
BID_LIFE = 20  # for which a bid counts
REPEAT_TICKS = 5  # after which a message is sent again that must arrive
MUTE_TICKS = 100  # without a report, after which a robot on its way has lost its order,
LOST_TICKS = 600  # and one with the goods
LATE_TICKS = 600  # beyond three times what a robot has said that its way takes
MOST_OFFERS = 8  # in an announcement
MOST_DOUBLINGS = 6  # of the patience with robots that are late


@dataclass(slots=True)
class _Entry:
    """An order and who has it."""

    order: TransportOrder
    state: OrderState = OrderState.OPEN
    robot: str = ""  # of the latest grant
    number: int = 0  # of the latest grant
    heard: int = 0  # tick of its latest report
    deadline: int = 0  # tick by which the robot is to be here
    sent: int = 0  # tick of the latest grant message
    is_confirmed: bool = False  # whether the robot has reported since the grant
    bids: dict[str, tuple[int, Bid]] = field(default_factory=dict)  # with their ticks, by robot


class StationAgent:
    """The state machine of one station; it has no clock and does no I/O.

    Attributes:
        events: What happened since they were last taken, for the results.
    """

    def __init__(
        self, name: str, orders: Iterator[TransportOrder], *, awaits_dispatcher: bool = False
    ) -> None:
        """Begin before the first order.

        Args:
            orders: Orders of this station, in the order of time; may never end.
            awaits_dispatcher: Whether a dispatcher chooses who gets an order; else the lowest bid.
        """
        self.name = name
        self.events: list[OrderEvent] = []
        self._coming = orders
        self._next = next(orders, None)
        self._awaits_dispatcher = awaits_dispatcher
        self._open: dict[str, _Entry] = {}  # all that is not done
        self._assigned: dict[str, str] = {}  # robot, by order
        self._bringers: dict[str, str] = {}  # robot, by order whose goods have arrived here
        self._ends: dict[str, int] = {}  # tick of the end of their service, likewise
        self._untold: dict[str, tuple[str, int]] = {}  # of these: origin, tick of the last message
        self._announced = -ANNOUNCE_TICKS
        self._is_news = False
        self._now = self._busy_until = 0  # ticks
        self._replies: list[Envelope] = []

    @property
    def is_over(self) -> bool:
        """Whether all orders have come and are done, nobody is served for one of them."""
        is_told = self._next is None and not self._open and not self._untold
        return is_told and self._now >= self._busy_until

    @property
    def has_open(self) -> bool:
        """Whether an order is not done."""
        return bool(self._open)

    def receive(self, message: AnyMessage, tick: int) -> None:
        """Receive a message, which may be late, repeated, or about others."""
        if message.station != self.name:
            return
        match message:
            case Bid():
                self._on_bid(message, tick)
            case Assignment():
                self._assigned[message.order] = message.robot
            case HoldReport():
                self._on_report(message, tick)
            case Unload():
                self._on_unload(message, tick)
            case Delivered():
                self._on_delivered(message, tick)
            case Noted():
                self._untold.pop(message.order, None)
            case _:
                pass

    def tick(self, tick: int) -> list[Envelope]:
        """Decide; return what to send."""
        self._now = tick
        self._take_new(tick)
        for entry in self._open.values():
            if entry.state is not OrderState.OPEN:
                self._watch(entry, tick)
            if entry.state is OrderState.OPEN and (entry.bids or self._awaits_dispatcher):
                self._grant(entry, tick)
            if entry.state is OrderState.GRANTED:
                self._repeat_grant(entry, tick)
        self._tell_origins(tick)
        sent, self._replies = self._replies, []
        if self._is_news or tick - self._announced >= ANNOUNCE_TICKS:
            self._is_news = False
            self._announced = tick
            sent.append(self._envelope("", Announcement(self.name, self._offers(tick))))
        return sent

    def _take_new(self, tick: int) -> None:
        while self._next is not None and self._next.created <= tick:
            order = self._next
            self._open[order.id] = _Entry(order)
            self.events.append(
                OrderEvent(
                    OrderEventKind.CREATED,
                    order.created,
                    order.id,
                    self.name,
                    target=order.target,
                    priority=order.priority,
                    due=order.due,
                )
            )
            self._next = next(self._coming, None)
            self._is_news = True

    def _offers(self, tick: int) -> tuple[OrderOffer, ...]:
        orders = [each.order for each in self._open.values() if each.state is OrderState.OPEN]
        chosen = sorted(orders, key=lambda order: urgency(order, tick))[:MOST_OFFERS]
        return tuple(OrderOffer(o.id, o.target, o.created, o.priority, o.due) for o in chosen)

    # Who gets it

    def _on_bid(self, bid: Bid, tick: int) -> None:
        entry = self._open.get(bid.order)
        if entry is not None and entry.state is OrderState.OPEN:
            entry.bids[bid.robot] = tick, bid

    def _grant(self, entry: _Entry, tick: int) -> None:
        fresh = {r: (at, bid) for r, (at, bid) in entry.bids.items() if tick - at <= BID_LIFE}
        entry.bids = fresh
        bid = self._chosen(entry, tick)
        if bid is None:
            return
        self._change(entry, OrderChange.GRANT)
        entry.number += 1
        entry.robot, entry.heard, entry.is_confirmed = bid.robot, tick, False
        patience = LATE_TICKS + 3 * max(0, bid.eta)
        entry.deadline = tick + patience * 2 ** min(entry.number - 1, MOST_DOUBLINGS)
        entry.sent = tick - REPEAT_TICKS
        entry.bids = {}
        for other in self._open.values():
            other.bids.pop(bid.robot, None)
        self._note(OrderEventKind.GRANTED, entry.order.id, tick, bid.robot)

    def _chosen(self, entry: _Entry, tick: int) -> Bid | None:
        if self._awaits_dispatcher:
            robot = self._assigned.pop(entry.order.id, "")
            return entry.bids[robot][1] if robot in entry.bids else None
        if not entry.bids:
            return None
        if tick - min(at for at, _ in entry.bids.values()) < BID_WINDOW:
            return None
        return min((bid for _, bid in entry.bids.values()), key=lambda bid: (bid.cost, bid.robot))

    def _repeat_grant(self, entry: _Entry, tick: int) -> None:
        if not entry.is_confirmed and tick - entry.sent >= REPEAT_TICKS:
            entry.sent = tick
            grant = Grant(self.name, entry.robot, entry.order, entry.number)
            self._reply(entry.robot, grant)

    # What its holder does

    def _on_report(self, report: HoldReport, tick: int) -> None:
        entry = self._open.get(report.order)
        is_holder = (
            entry is not None
            and entry.state in (OrderState.GRANTED, OrderState.LOADED)
            and (entry.robot, entry.number) == (report.robot, report.number)
        )
        if entry is None or not is_holder:
            if report.phase is not HoldPhase.RELEASED:
                void = Void(self.name, report.robot, report.order, report.number)
                self._reply(report.robot, void)
            return
        entry.heard, entry.is_confirmed = tick, True
        if report.phase is HoldPhase.RELEASED:
            self._take_back(entry, "given back", tick)
        elif report.phase is HoldPhase.HERE:
            if entry.state is OrderState.GRANTED:
                self._change(entry, OrderChange.LOAD)
            load = Load(self.name, report.robot, report.order, report.number)
            self._reply(report.robot, load)

    def _watch(self, entry: _Entry, tick: int) -> None:
        if entry.state is OrderState.GRANTED and tick - entry.heard > MUTE_TICKS:
            self._take_back(entry, "mute", tick)
        elif entry.state is OrderState.GRANTED and tick > entry.deadline:
            self._take_back(entry, "late", tick)
        elif entry.state is OrderState.LOADED and tick - entry.heard > LOST_TICKS:
            self._take_back(entry, "lost with the goods", tick)

    def _take_back(self, entry: _Entry, reason: str, tick: int) -> None:
        self._change(entry, OrderChange.TAKE_BACK)
        self._reply(entry.robot, Void(self.name, entry.robot, entry.order.id, entry.number))
        self._note(OrderEventKind.TAKEN_BACK, entry.order.id, tick, entry.robot, reason=reason)
        entry.bids = {}
        self._is_news = True

    # Goods that arrive

    def _on_unload(self, unload: Unload, tick: int) -> None:
        if unload.order not in self._bringers:
            self._bringers[unload.order] = unload.robot
            self._untold[unload.order] = unload.origin, tick - REPEAT_TICKS
            self._ends[unload.order] = tick + unload.ticks + REPEAT_TICKS
            self._note(OrderEventKind.RECEIVED, unload.order, tick, unload.robot)
        # It asks again if it has not heard the answer; only then is it served.
        self._busy_until = max(self._busy_until, tick + unload.ticks + REPEAT_TICKS)
        is_new = self._bringers[unload.order] == unload.robot
        self._reply(unload.robot, Received(self.name, unload.robot, unload.order, is_new))

    def _tell_origins(self, tick: int) -> None:
        for order, (origin, sent) in self._untold.items():
            if tick - sent >= REPEAT_TICKS:
                self._untold[order] = origin, tick
                told = Delivered(origin, self.name, order, self._ends[order])
                self._reply(origin, told)

    def _on_delivered(self, message: Delivered, tick: int) -> None:
        entry = self._open.pop(message.order, None)
        self._busy_until = max(self._busy_until, message.until)
        if entry is not None:
            if entry.state in (OrderState.GRANTED, OrderState.LOADED):
                void = Void(self.name, entry.robot, entry.order.id, entry.number)
                self._reply(entry.robot, void)
            self._is_news |= entry.state is OrderState.OPEN
            self._change(entry, OrderChange.DELIVERED)
        self._reply(message.target, Noted(message.target, self.name, message.order))

    # Small helpers

    def _change(self, entry: _Entry, change: OrderChange) -> None:
        entry.state = ORDER_TRANSITIONS[entry.state][change]

    def _note(
        self, what: OrderEventKind, order: str, tick: int, robot: str, reason: str = ""
    ) -> None:
        self.events.append(OrderEvent(what, tick, order, self.name, robot, reason=reason))

    def _envelope(self, receiver: str, message: AnyMessage) -> Envelope:
        return Envelope(self.name, receiver, message)

    def _reply(self, receiver: str, message: AnyMessage) -> None:
        self._replies.append(self._envelope(receiver, message))


def urgency(order: TransportOrder | OrderOffer, tick: int) -> tuple[int, int, int]:
    """Return a key by which the most urgent order comes first: priority, overdue, age."""
    is_overdue = order.due is not None and tick > order.due
    return -order.priority, 0 if is_overdue else 1, order.created
