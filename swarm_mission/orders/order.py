"""One transport order, and streams of them; equal seeds give equal orders, for any swarm."""

from __future__ import annotations

import heapq
import itertools
import math
import random
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace

import msgspec

from swarm_common.model.errors import ConfigError, UnknownNameError
from swarm_common.model.records import CONTROL_PERIOD
from swarm_mission.orders.arrivals import Arrivals
from swarm_mission.orders.service import AT_ONCE, ServiceTime


class TransportOrder(msgspec.Struct, frozen=True):
    """Something to be moved from one station to another."""

    id: str  # stream and number in it, from 1, like `2-17`
    origin: str  # station
    target: str  # station
    created: int  # tick
    load_ticks: int  # of service at the origin
    unload_ticks: int  # of service at the target
    priority: int = 0  # larger ones first
    due: int | None = None  # tick by which it is to be served


@dataclass(frozen=True, slots=True, kw_only=True)
class OrderStream:
    """Orders of one kind."""

    number: int  # of the stream, from 1
    origins: tuple[str, ...]  # stations, one of which is drawn
    targets: tuple[str, ...]
    arrivals: Arrivals
    loading: ServiceTime = AT_ONCE
    unloading: ServiceTime = AT_ONCE
    priority: int = 0
    due: float | None = None  # [s] after it came

    def __post_init__(self) -> None:
        if not self.origins or not self.targets:
            raise ConfigError("from and to must name a station each")
        for origin in self.origins:
            if not set(self.targets) - {origin}:
                raise ConfigError(f"orders go from {origin} to {origin}; expected another station")

    def routes(self) -> list[tuple[str, str, float]]:
        """Return origin, target and share of the orders, for all pairs of stations."""
        pairs = []
        for origin in self.origins:
            targets = [name for name in self.targets if name != origin]
            share = 1.0 / len(self.origins) / len(targets)
            pairs += [(origin, target, share) for target in targets]
        return pairs

    def draw(self, seed: int) -> Iterator[TransportOrder]:
        """Yield the stream's orders in the order of time."""
        times = self.arrivals.times(random.Random(f"{seed}/orders/{self.number}/times"))
        rng = random.Random(f"{seed}/orders/{self.number}")
        for count, at in enumerate(times, 1):
            origin = rng.choice(self.origins)
            target = rng.choice([name for name in self.targets if name != origin])
            created = math.ceil(at / CONTROL_PERIOD - 1e-9)
            yield TransportOrder(
                id=f"{self.number}-{count}",
                origin=origin,
                target=target,
                created=created,
                load_ticks=round(self.loading.draw(rng) / CONTROL_PERIOD),
                unload_ticks=round(self.unloading.draw(rng) / CONTROL_PERIOD),
                priority=self.priority,
                due=None if self.due is None else created + round(self.due / CONTROL_PERIOD),
            )


@dataclass(frozen=True, slots=True, kw_only=True)
class OrderPlan:
    """All that a mission says of orders."""

    streams: tuple[OrderStream, ...]
    dispatch: str = "claim"
    capacity: int = 1  # orders that a robot carries at a time

    def __post_init__(self) -> None:
        if not self.streams:
            raise ConfigError("orders is empty; expected at least one stream")

    @property
    def stations(self) -> tuple[str, ...]:
        """Names of all stations that orders come from or go to, sorted."""
        names = (name for stream in self.streams for name in (*stream.origins, *stream.targets))
        return tuple(sorted(set(names)))

    def with_groups(self, groups: Mapping[str, tuple[str, ...]]) -> OrderPlan:
        """Return this plan with stations in place of groups of them."""
        streams = tuple(
            replace(
                stream,
                origins=expand(stream.origins, groups),
                targets=expand(stream.targets, groups),
            )
            for stream in self.streams
        )
        return replace(self, streams=streams)

    def orders_from(self, station: str, seed: int) -> Iterator[TransportOrder]:
        """Yield the orders of one station in the order of time; it forgets those of the others."""
        streams = [stream.draw(seed) for stream in self.streams if station in stream.origins]
        merged = heapq.merge(*streams, key=lambda order: order.created)
        return (order for order in merged if order.origin == station)


def expand(names: tuple[str, ...], groups: Mapping[str, tuple[str, ...]]) -> tuple[str, ...]:
    """Return stations and groups of them as stations, each once, in the order of the names.

    Raises:
        ConfigError: If a group contains itself.
    """
    found: list[str] = []
    for name in names:
        found += _members(name, groups, ())
    return tuple(dict.fromkeys(found))


def _members(
    name: str, groups: Mapping[str, tuple[str, ...]], above: tuple[str, ...]
) -> Iterator[str]:
    if name in above:
        circle = " > ".join([*above[above.index(name) :], name])
        raise ConfigError(f"groups: {circle}: a group contains itself")
    if name not in groups:
        yield name
        return
    yield from itertools.chain.from_iterable(
        _members(each, groups, (*above, name)) for each in groups[name]
    )


def check_names(plan: OrderPlan, known: Mapping[str, object], where: str) -> None:
    """Refuse stations that the world does not have.

    Raises:
        UnknownNameError: For the first that it lacks.
    """
    for stream in plan.streams:
        for name in (*stream.origins, *stream.targets):
            if name not in known:
                raise UnknownNameError("station", name, known, where)
