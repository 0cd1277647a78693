"""When the orders of a stream come: at random, at intervals, by a shift plan or from a file."""

from __future__ import annotations

import math
import random
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Annotated

from msgspec import Meta

from swarm_common.model.errors import ConfigError
from swarm_common.model.schema import Schema

HOUR = 3600.0  # [s]
LEAST_INTERVAL, MOST_INTERVAL = 0.1, 604_800.0  # [s] between two arrivals on average
MOST_AT_ONCE = 1000  # orders
Amount = Annotated[int, Meta(ge=1, le=MOST_AT_ONCE)]  # of orders


class Shift(Schema):
    """A time in which orders come: at random (`rate`) or at intervals (`every`)."""

    begin: float = 0.0  # [s]
    end: float = math.inf  # [s]
    rate: float = 0.0  # [1/h] of a Poisson process
    every: float = 0.0  # [s] between two arrivals

    def __post_init__(self) -> None:
        if (self.rate > 0.0) == (self.every > 0.0) or min(self.rate, self.every) < 0.0:
            raise ConfigError(
                f"rate is {self.rate:g} per hour and every is {self.every:g} s; expected one of"
                " the two, and that positive"
            )
        if not LEAST_INTERVAL <= self.interval <= MOST_INTERVAL:
            raise ConfigError(
                f"orders come every {self.interval:.3g} s; expected {LEAST_INTERVAL} s to"
                f" {MOST_INTERVAL:g} s"
            )
        if not 0.0 <= self.begin < self.end:
            raise ConfigError(
                f"a shift lasts from {self.begin:g} to {self.end:g} s; expected 0 <= begin < end"
            )

    @property
    def interval(self) -> float:
        """Mean time [s] between two arrivals."""
        return HOUR / self.rate if self.rate else self.every

    def times(self, rng: random.Random) -> Iterator[float]:
        """Yield times [s] in order; random ones come first after a random time."""
        count = 0
        now = self.begin + (rng.expovariate(1.0 / self.interval) if self.rate else 0.0)
        while now < self.end:
            yield now
            count += 1
            if self.rate:
                now += rng.expovariate(1.0 / self.interval)
            else:
                now = self.begin + count * self.every


@dataclass(frozen=True, slots=True, kw_only=True)
class Arrivals:
    """When orders come, and how many at a time."""

    shifts: tuple[Shift, ...] = ()  # one after the other
    listed: tuple[float, ...] = ()  # [s] in order, instead of shifts
    batch: int = 1  # orders of each arrival

    def __post_init__(self) -> None:
        if bool(self.shifts) == bool(self.listed):
            raise ConfigError("expected one of 'rate', 'every', 'shifts' and 'times'")
        for first, second in zip(self.shifts, self.shifts[1:], strict=False):
            if second.begin < first.end:
                raise ConfigError(
                    f"a shift begins at {second.begin:g} s, before the one above it ends at"
                    f" {first.end:g} s"
                )
        if self.listed and (min(self.listed) < 0.0 or list(self.listed) != sorted(self.listed)):
            raise ConfigError("times must be in order, and not negative")

    @property
    def is_finite(self) -> bool:
        """Whether there is a last order."""
        return not self.shifts or math.isfinite(self.shifts[-1].end)

    @property
    def peak_rate(self) -> float:
        """Orders per hour in the busiest shift; of listed times over their whole length."""
        if self.shifts:
            return max(self.batch * HOUR / shift.interval for shift in self.shifts)
        length = self.listed[-1] - self.listed[0]
        return self.batch * (len(self.listed) - 1) * HOUR / length if length else 0.0

    def times(self, rng: random.Random) -> Iterator[float]:
        """Yield the time [s] of each order; equal generators give equal times."""
        arrivals = (at for shift in self.shifts for at in shift.times(rng))
        for at in self.listed or arrivals:
            for _ in range(self.batch):
                yield at
