"""Records of every order, station and robot; the same for bench and report."""

from __future__ import annotations

import statistics
from collections import defaultdict
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from enum import Enum
from typing import Any

import msgspec

from swarm_common.model.records import CONTROL_PERIOD

HOUR = 3600.0  # [s]
DIGITS = 3


class OrderEventKind(Enum):
    """Kind of an event in the life of an order."""

    CREATED = "created"
    GRANTED = "granted"
    TAKEN_BACK = "taken_back"
    LOADING = "loading"  # a robot is at the origin, and its service there begins
    UNLOADING = "unloading"  # likewise at the target
    RECEIVED = "received"  # the target has taken the goods
    ARRIVED = "arrived"  # a robot has come to a station for the order
    LEFT = "left"  # a robot has left a station


class OrderEvent(msgspec.Struct, frozen=True, omit_defaults=True):
    """Something that stations and robots tell for the results."""

    what: OrderEventKind
    tick: int
    order: str = ""
    station: str = ""
    robot: str = ""
    target: str = ""  # of an order that came
    reason: str = ""  # for which it was taken back
    until: int = 0  # tick at which a service ends
    priority: int = 0
    due: int | None = None  # tick


@dataclass(slots=True)
class OrderRecord:
    """One order; ticks, None for what has not happened."""

    id: str
    origin: str
    target: str
    created: int
    priority: int = 0
    due: int | None = None
    robot: str = ""
    granted: int | None = None
    taken_back: int = 0  # times
    at_origin: int | None = None
    loading: int | None = None
    loaded: int | None = None
    at_target: int | None = None
    unloading: int | None = None
    done: int | None = None  # tick at which the service at the target ends
    receipts: int = 0  # times that the target took the goods: 1 at most

    def as_json(self, now: int) -> dict[str, Any]:
        """Return the record with times [s]; what lies in the future has not happened."""
        done = self.done if self.done is not None and self.done <= now else None
        waiting = _between(self.created, self.granted)
        parts = (_between(self.granted, self.at_origin), _between(self.loaded, self.at_target))
        services = (_between(self.loading, self.loaded), _between(self.unloading, self.done))
        handovers = (
            _between(self.at_origin, self.loading),
            _between(self.at_target, self.unloading),
        )
        is_done = done is not None
        return {
            "id": self.id,
            "from": self.origin,
            "to": self.target,
            "robot": self.robot,
            "priority": self.priority,
            "created": _seconds(self.created),
            "done": _seconds(done),
            "waiting": waiting,
            "driving": _total(parts) if is_done else None,
            "handover": _total(handovers) if is_done else None,
            "service": _total(services) if is_done else None,
            "lead_time": _between(self.created, done),
            "lateness": _between(self.due, done),
            "taken_back": self.taken_back,
            "receipts": self.receipts,
        }


class RobotShares(msgspec.Struct):
    """Times [s] of a robot; together they are the time that it was watched."""

    driving_empty: float = 0.0
    driving_loaded: float = 0.0
    waiting: float = 0.0  # standing on its way, or for a station to answer
    service: float = 0.0
    idle: float = 0.0


@dataclass(slots=True)
class _Visits:
    """A station's robots."""

    present: dict[str, int] = field(default_factory=dict)  # tick of arrival, by robot
    stays: list[tuple[int, int]] = field(default_factory=list)
    services: list[tuple[int, int]] = field(default_factory=list)


class OrderBook:
    """Adds events up; those of one order may come in another order than they happened.

    Attributes:
        records: By order.
        remarks: What was said before the run.
    """

    def __init__(self, dispatch: str = "claim", remarks: Sequence[str] = ()) -> None:
        self.records: dict[str, OrderRecord] = {}
        self.remarks = tuple(remarks)
        self.dispatch = dispatch
        self._early: defaultdict[str, list[OrderEvent]] = defaultdict(list)
        self._visits: defaultdict[str, _Visits] = defaultdict(_Visits)

    def apply_all(self, events: Iterable[OrderEvent]) -> None:
        """Add events."""
        for event in events:
            self.apply(event)

    def apply(self, event: OrderEvent) -> None:
        """Add an event."""
        self._visit(event)
        if event.what is OrderEventKind.CREATED:
            self.records[event.order] = OrderRecord(
                event.order, event.station, event.target, event.tick, event.priority, event.due
            )
            for early in self._early.pop(event.order, ()):
                self._record(early)
        elif event.order in self.records:
            self._record(event)
        elif event.order:
            self._early[event.order].append(event)

    def _record(self, event: OrderEvent) -> None:
        record = self.records[event.order]
        match event.what:
            case OrderEventKind.GRANTED if not record.receipts:
                record.granted, record.robot = event.tick, event.robot
                record.at_origin = record.loading = record.loaded = record.at_target = None
            case OrderEventKind.TAKEN_BACK:
                record.taken_back += 1
            case OrderEventKind.ARRIVED if not record.receipts or event.robot == record.robot:
                if event.station == record.origin:
                    record.at_origin = event.tick
                else:
                    record.at_target = event.tick
            case OrderEventKind.LOADING if not record.receipts or event.robot == record.robot:
                record.loading, record.loaded = event.tick, event.until
            case OrderEventKind.UNLOADING:
                record.unloading, record.done = event.tick, event.until
            case OrderEventKind.RECEIVED:
                record.receipts += 1
                record.robot = event.robot
                if record.done is None:  # as it stays if the robot dies before it is told
                    record.done = event.tick
            case _:
                pass

    def _visit(self, event: OrderEvent) -> None:
        visits = self._visits[event.station]
        match event.what:
            case OrderEventKind.ARRIVED:
                visits.present.setdefault(event.robot, event.tick)
            case OrderEventKind.LOADING | OrderEventKind.UNLOADING:
                visits.services.append((event.tick, event.until))
            case OrderEventKind.LEFT if event.robot in visits.present:
                visits.stays.append((visits.present.pop(event.robot), event.tick))
            case _:
                pass

    def as_json(self, sim_time: float) -> dict[str, Any]:
        """Return all figures at a time [s] since the start."""
        now = round(sim_time / CONTROL_PERIOD)
        orders = [record.as_json(now) for record in self.records.values()]
        done = [order for order in orders if order["done"] is not None]
        late = [order["lateness"] for order in done if order["lateness"] is not None]
        return {
            "dispatch": self.dispatch,
            "remarks": list(self.remarks),
            "created": len(orders),
            "done": len(done),
            "open": len(orders) - len(done),
            "taken_back": sum(order["taken_back"] for order in orders),
            "throughput_per_hour": _rounded(HOUR * len(done) / sim_time if sim_time else 0.0),
            **{
                name: _spread([order[name] for order in done])
                for name in ("lead_time", "waiting", "driving", "service")
            },
            "lateness": {**_spread(late), "late": sum(value > 0.0 for value in late)},
            "stations": self._stations(now),
            "orders": orders,
        }

    def _stations(self, now: int) -> dict[str, Any]:
        names = {record.origin for record in self.records.values()}
        names |= {record.target for record in self.records.values()}
        return {name: self._station(name, now) for name in sorted(names)}

    def _station(self, name: str, now: int) -> dict[str, Any]:
        visits = self._visits[name]
        stays = [*visits.stays, *((begin, now) for begin in visits.present.values())]
        busy = covered(visits.services, now)
        occupied = covered([*stays, *visits.services], now)
        own = [record for record in self.records.values() if record.origin == name]
        waits = [(r.created, r.loading if r.loading is not None else now) for r in own]
        served = [r for r in self.records.values() if name in (r.origin, r.target)]
        length = max(now, 1)
        return {
            "orders_from": len(own),
            "orders_done": sum(r.done is not None and r.done <= now for r in served),
            "utilisation": _rounded(busy / length),
            "occupied": _rounded(occupied / length),
            "blocked": _rounded((occupied - busy) / length),
            "queue": _rounded(sum(max(0, min(e, now) - b) for b, e in waits) / length),
            "queue_worst": most_at_once(waits),
        }


def covered(spans: Iterable[tuple[int, int]], now: int) -> int:
    """Return for how many ticks before now one span or more lasts."""
    total, reached = 0, 0
    for begin, end in sorted(spans):
        total += max(0, min(end, now) - max(begin, reached))
        reached = max(reached, min(end, now))
    return total


def most_at_once(spans: Iterable[tuple[int, int]]) -> int:
    """Return how many spans overlap at most; one that ends makes room for one that begins."""
    steps = sorted(step for begin, end in spans for step in ((begin, 1), (end, -1)))
    most = count = 0
    for _, step in steps:
        count += step
        most = max(most, count)
    return most


def _spread(values: Sequence[float]) -> dict[str, float | None]:
    if not values:
        return {"mean": None, "median": None, "p95": None, "worst": None}
    ordered = sorted(values)
    return {
        "mean": _rounded(statistics.fmean(ordered)),
        "median": _rounded(statistics.median(ordered)),
        "p95": _rounded(ordered[min(len(ordered) - 1, int(0.95 * len(ordered)))]),
        "worst": _rounded(ordered[-1]),
    }


def _between(first: int | None, second: int | None) -> float | None:
    return None if first is None or second is None else _seconds(second - first)


def _total(parts: Iterable[float | None]) -> float:
    return _rounded(sum(part for part in parts if part is not None))


def _seconds(ticks: int | None) -> float | None:
    return None if ticks is None else _rounded(ticks * CONTROL_PERIOD)


def _rounded(value: float) -> float:
    return round(value, DIGITS)
