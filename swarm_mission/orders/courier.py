"""Courier of one robot with orders: where it is to drive next, and when it is served."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from swarm_common.model.records import Pose
from swarm_mission.itinerary import RETRY_TICKS, NextGoal, StopOutcome
from swarm_mission.leg import HOME, Stop
from swarm_mission.orders.messages import AnyMessage, Envelope, HoldPhase
from swarm_mission.orders.order import TransportOrder
from swarm_mission.orders.order_book import OrderEvent, OrderEventKind
from swarm_mission.orders.robot_bidder import BidSenses, RobotBidder
from swarm_mission.orders.states import COURIER_TRANSITIONS, CourierEvent, CourierState

# Ticks of 0.1 s.
GRACE_TICKS = 10  # at a station after the last order, before the robot drives home
INSIST_TICKS = 50  # between two tries to reach a target with goods that was missed often
BIDDING = (CourierState.IDLE, CourierState.PARKING, CourierState.DRIVING)


@dataclass(frozen=True, slots=True)
class Errand:
    """The station that the robot is on its way to, and for which order."""

    order: TransportOrder
    is_origin: bool

    @property
    def station(self) -> str:
        """Name of the station."""
        return self.order.origin if self.is_origin else self.order.target


class Courier:
    """The state machine of one robot with orders; it has no clock and does no I/O.

    Attributes:
        state: What the robot does.
        bidder: Bidder of the robot, which offers to carry orders.
        events: What happened since they were last taken, for the results.
        outcomes: Stations that it reached or missed, and its ways home.
    """

    def __init__(
        self,
        name: str,
        home_map: Pose,
        stations: Mapping[str, Pose],
        *,
        retries: int = 3,
        capacity: int = 1,
        bids_for_all: bool = False,
    ) -> None:
        """Begin at home, without orders.

        Args:
            home_map: Where it waits for orders.
            retries: Times that a goal is tried again.
            capacity: Orders that it carries at a time.
            bids_for_all: Whether it bids for all orders, as in `RobotBidder`.
        """
        self.state = CourierState.IDLE
        self.bidder = RobotBidder(name, capacity=capacity, bids_for_all=bids_for_all)
        self.events: list[OrderEvent] = []
        self.outcomes: list[StopOutcome] = []
        self._home_map = home_map
        self._stations = stations
        self._retries = retries
        self._target: Errand | None = None
        self._stop = Stop(HOME, home_map, 0)
        self._attempt = 1
        self._number = 0
        self._begun = 0  # tick at which it was free to set off for the current stop
        self._until = 0  # tick at which the service ends
        self._leave: int | None = None  # tick at which an idle robot drives home
        self._at = ""  # station where it stands

    @property
    def name(self) -> str:
        """Name of the robot."""
        return self.bidder.name

    @property
    def total(self) -> int:
        """Number of stations that it has reached or missed, and of its ways home."""
        return len(self.outcomes)

    @property
    def is_over(self) -> bool:
        """Whether the robot has nothing to do now."""
        return self.state in (CourierState.IDLE, CourierState.PARKING)

    @property
    def next_stop(self) -> str:
        """Where it is on its way to; empty if it is not."""
        return self._stop.name if self.state is CourierState.DRIVING else ""

    @property
    def has_goods(self) -> bool:
        """Whether it carries the goods of an order."""
        return any(held.phase is HoldPhase.LOADED for held in self.bidder.held.values())

    @property
    def share(self) -> str:
        """The field of `RobotShares` that its time counts to, if it moves."""
        match self.state:
            case CourierState.DRIVING:
                return "driving_loaded" if self.has_goods else "driving_empty"
            case CourierState.PARKING:
                return "driving_empty"
            case CourierState.SERVED:
                return "service"
            case CourierState.ASKING:
                return "waiting"
            case CourierState.IDLE:
                return "idle"

    def receive(self, message: AnyMessage, tick: int) -> None:
        """Receive a message from the radio."""
        self.bidder.receive(message, tick)

    def on_end(self, reached: bool, tick: int, reason: str = "") -> NextGoal | None:
        """Handle the end of the goal under way; return the next goal, None if there is none now."""
        self._pass_time(tick)
        if self.state not in (CourierState.DRIVING, CourierState.PARKING):
            return None
        was_parking = self.state is CourierState.PARKING
        if reached or was_parking:
            self._settle(reached, tick, reason)
            self._enter(CourierEvent.REACHED if reached else CourierEvent.MISSED)
            if not was_parking:
                self._arrive(tick)
            return None
        self._enter(CourierEvent.MISSED)
        return self._try_again(tick, reason)

    def tick(self, tick: int, senses: BidSenses) -> tuple[list[Envelope], NextGoal | None]:
        """Decide; return what to send, and a goal that replaces any other."""
        self._pass_time(tick)
        if self.bidder.held and senses.reach() <= 0.0:  # it goes to charge
            self.bidder.give_back()
        goal = self._decide(tick, senses)
        is_bidding = self.state in BIDDING and not self.has_goods
        return self.bidder.tick(tick, senses if is_bidding else None), goal

    def _pass_time(self, tick: int) -> None:
        """Do what is due: a service ends, an idle robot drives home."""
        if self.state is CourierState.SERVED and tick >= self._until:
            if self._target is not None:
                self._enter(CourierEvent.STOP)
                self._depart(self._until)
            else:
                self._enter(CourierEvent.SERVICE_OVER)
                self._leave = self._until + GRACE_TICKS
                self.bidder.idle_since = tick
        if self.state is CourierState.IDLE and self._leave is not None and tick >= self._leave:
            self._enter(CourierEvent.HOME)
            self._depart(self._leave)
            self._leave = None

    def _decide(self, tick: int, senses: BidSenses) -> NextGoal | None:
        target = self._target
        if self.state is CourierState.ASKING and target is not None:
            if goal := self._be_served(target, tick, senses):
                return goal
        is_void = target is not None and target.order.id not in self.bidder.held
        if self.state in (CourierState.DRIVING, CourierState.ASKING) and is_void:
            return self._go_on(tick, senses)
        if self.state in (CourierState.IDLE, CourierState.PARKING) and self.bidder.held:
            return self._go_on(tick, senses)
        return None

    def _be_served(self, target: Errand, tick: int, senses: BidSenses) -> NextGoal | None:
        """Begin the service if the station agrees; return the goal after it."""
        held = self.bidder.held.get(target.order.id)
        if target.is_origin:
            if held is None or held.phase is not HoldPhase.LOADED:
                return None
            ticks, what = target.order.load_ticks, OrderEventKind.LOADING
        else:
            if not self.bidder.receipts.pop(target.order.id, False):
                return None
            ticks, what = target.order.unload_ticks, OrderEventKind.UNLOADING
        self._enter(CourierEvent.SERVICE)
        self._until = tick + ticks
        self._note(what, tick, target, until=self._until)
        self._target = self._choose(senses)
        if self._target is None:
            return self._goal(Stop(HOME, self._home_map, 0), self._until + GRACE_TICKS)
        return self._goal_of(self._target, self._until)

    def _go_on(self, tick: int, senses: BidSenses) -> NextGoal:
        """Set off for the next station, or home."""
        self._target = self._choose(senses)
        self._leave = None
        if self._target is None:
            self._enter(CourierEvent.HOME)
            self.bidder.idle_since = tick
            goal = self._goal(Stop(HOME, self._home_map, 0), tick)
        else:
            self._enter(CourierEvent.STOP)
            goal = self._goal_of(self._target, tick)
        self._depart(tick)
        return goal

    def _choose(self, senses: BidSenses) -> Errand | None:
        """Return the next station: the nearest to be loaded at, else to be unloaded at."""
        targets = [
            Errand(held.order, held.phase is not HoldPhase.LOADED)
            for held in self.bidder.held.values()
        ]
        if not targets:
            return None
        return min(targets, key=lambda t: (not t.is_origin, senses.way_to(t.station), t.order.id))

    def _arrive(self, tick: int) -> None:
        assert self._target is not None
        self._at = self._target.station
        self._note(OrderEventKind.ARRIVED, tick, self._target)
        if self._target.order.id in self.bidder.held:
            self.bidder.arrive(self._target.order.id)

    def _depart(self, tick: int) -> None:
        if self._at:
            self.events.append(OrderEvent(OrderEventKind.LEFT, tick, "", self._at, self.name))
            self._at = ""

    def _try_again(self, tick: int, reason: str) -> NextGoal | None:
        """Return another try of a goal that was missed; give the order back if that was the last.

        Goods cannot be given back: the robot tries on.
        """
        target = self._target
        assert target is not None
        self._attempt += 1
        is_spent = self._attempt > self._retries + 1
        if is_spent:
            self._settle(False, tick, reason)
            self._attempt = 1
        if is_spent and target.is_origin and target.order.id in self.bidder.held:
            self.bidder.release(target.order.id)
            return None
        pause = INSIST_TICKS if is_spent else RETRY_TICKS
        return NextGoal(self._stop, tick + pause, self._number, self._attempt)

    def _goal_of(self, target: Errand, start_tick: int) -> NextGoal:
        pose = self._stations[target.station]
        return self._goal(Stop(target.station, pose, 0), start_tick)

    def _goal(self, stop: Stop, start_tick: int) -> NextGoal:
        self._stop, self._begun, self._attempt = stop, start_tick, 1
        self._number += 1
        return NextGoal(stop, start_tick, self._number, 1)

    def _settle(self, reached: bool, tick: int, reason: str) -> None:
        why = "" if reached else reason
        self.outcomes.append(StopOutcome(self._stop, reached, tick, self._begun, why))

    def _note(self, what: OrderEventKind, tick: int, target: Errand, until: int = 0) -> None:
        event = OrderEvent(what, tick, target.order.id, target.station, self.name, until=until)
        self.events.append(event)

    def _enter(self, event: CourierEvent) -> None:
        self.state = COURIER_TRANSITIONS[self.state][event]
