"""A centre in the bench: its radio to the robots, and what it costs."""

from __future__ import annotations

import math
import time
from collections import deque
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Protocol, TypeVar

import numpy as np

from swarm_bench.runs.methods import Driver
from swarm_central.team import RobotReport, Team, TeamOrder
from swarm_common.model.records import CONTROL_PERIOD

M = TypeVar("M")


class Commanded(Driver, Protocol):
    """A driver that reports to a centre and takes its orders."""

    def report(self) -> RobotReport:
        """Return what the centre is to know after a tick."""

    def take(self, order: TeamOrder) -> None:
        """Take an order."""


@dataclass(slots=True)
class CentreUsage:
    """What a centre cost so far."""

    seconds: float = 0.0  # of CPU
    longest: float = 0.0  # [s] of wall time of one decision
    bytes_up: int = 0
    bytes_down: int = 0
    ticks: int = 0


@dataclass(slots=True)
class Centre:
    """Carries messages between a team and its robots, with loss and delay at any distance.

    Attributes:
        team: What decides.
        loss: Share of the messages that are lost, in each direction.
        delay: Ticks, beyond the one that a message always takes.
        outage: First and last tick in which the centre does nothing; None for never.
        seed: Of the losses.
    """

    team: Team
    loss: float = 0.0
    delay: int = 0
    outage: tuple[int, int] | None = None
    seed: int = 0
    usage: CentreUsage = field(default_factory=CentreUsage)
    _up: deque[list[RobotReport]] = field(default_factory=deque)
    _down: deque[list[TeamOrder]] = field(default_factory=deque)

    def exchange(self, tick: int, drivers: Sequence[Commanded], dead: set[int]) -> None:
        """Let the team hear, decide and speak in a tick in which the robots have decided.

        Args:
            dead: Indices of those that neither report nor hear.
        """
        draws = np.random.default_rng((self.seed, tick)).random((2, len(drivers) + 1))
        reports = [driver.report() for i, driver in enumerate(drivers) if i not in dead]
        self.usage.bytes_up += sum(report.size for report in reports)
        self._up.append(_kept(reports, lambda r: draws[0, r.robot_id] >= self.loss))
        arrived = self._up.popleft() if len(self._up) > 1 + self.delay else []
        orders = self._decide(tick, arrived)
        self.usage.bytes_down += sum(order.size for order in orders)
        self._down.append(_kept(orders, lambda o: draws[1, o.robot_id] >= self.loss))
        if len(self._down) > self.delay:
            for order in self._down.popleft():
                if order.robot_id - 1 not in dead:
                    drivers[order.robot_id - 1].take(order)

    def _decide(self, tick: int, arrived: Sequence[RobotReport]) -> Sequence[TeamOrder]:
        self.usage.ticks += 1
        if self.outage is not None and self.outage[0] <= tick <= self.outage[1]:
            return ()
        started, cpu = time.perf_counter(), time.process_time()
        self.team.observe(tick, arrived)
        orders = self.team.decide()
        self.usage.longest = max(self.usage.longest, time.perf_counter() - started)
        self.usage.seconds += time.process_time() - cpu
        return orders

    def as_json(self, robots: int) -> dict[str, float]:
        """Return what the centre cost, for a result."""
        share = 1.0 / max(1.0, robots * self.usage.ticks * CONTROL_PERIOD)
        return {
            "cpu_ms_per_robot_second": 1e3 * self.usage.seconds * share,
            "longest_decision_ms": 1e3 * self.usage.longest,
            "bytes_up_per_robot_second": self.usage.bytes_up * share,
            "bytes_down_per_robot_second": self.usage.bytes_down * share,
            **self.team.figures(),
        }


def delay_ticks(delay: float) -> int:
    """Return a delay [s] in whole ticks."""
    return math.ceil(delay / CONTROL_PERIOD - 1e-9)


def _kept(messages: Sequence[M], is_heard: Callable[[M], bool]) -> list[M]:
    return [message for message in messages if is_heard(message)]
