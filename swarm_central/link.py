"""The radio between a centre and its robots, and what the centre costs."""

from __future__ import annotations

import math
import time
from collections import deque
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from typing import TypeVar

import numpy as np

from swarm_central.team import RobotReport, Team, TeamOrder
from swarm_common.model.records import CONTROL_PERIOD

M = TypeVar("M", RobotReport, TeamOrder)


@dataclass(slots=True)
class CentreUsage:
    """Costs of a centre so far."""

    seconds: float = 0.0  # of CPU
    decisions: list[float] = field(default_factory=list)  # [s] of wall time of each
    bytes_up: int = 0
    bytes_down: int = 0
    ticks: int = 0


@dataclass(slots=True)
class Centre:
    """Carries messages between a team and its robots, with loss and delay at any distance.

    Attributes:
        team: Team that decides.
        robots: Highest id of a robot whose messages may be lost.
        loss: Share of the messages that are lost, in each direction.
        delay: Ticks, beyond the one that a message always takes.
        outage: First and last tick in which the centre does nothing; None for never.
        seed: Seed of the losses.
    """

    team: Team
    robots: int
    loss: float = 0.0
    delay: int = 0
    outage: tuple[int, int] | None = None
    seed: int = 0
    usage: CentreUsage = field(default_factory=CentreUsage)
    _up: deque[tuple[int, list[RobotReport]]] = field(default_factory=deque)
    _down: deque[tuple[int, list[TeamOrder]]] = field(default_factory=deque)

    def step(self, tick: int, reports: Sequence[RobotReport]) -> list[TeamOrder]:
        """Let the team hear, decide and speak.

        Args:
            reports: Reports that robots sent in this tick.

        Returns:
            The orders that arrive now.
        """
        draws = np.random.default_rng((self.seed, tick)).random((2, self.robots + 1)).tolist()
        self.usage.bytes_up += sum(report.size for report in reports)
        self._up.append((tick, self._kept(reports, draws[0])))
        arrived = list(_due(self._up, tick - self.delay - 1))
        orders = self._decide(tick, arrived)
        self.usage.bytes_down += sum(order.size for order in orders)
        self._down.append((tick, self._kept(orders, draws[1])))
        return list(_due(self._down, tick - self.delay))

    def _kept(self, messages: Sequence[M], draws: Sequence[float]) -> list[M]:
        return [m for m in messages if m.robot_id > self.robots or draws[m.robot_id] >= self.loss]

    def _decide(self, tick: int, arrived: Sequence[RobotReport]) -> Sequence[TeamOrder]:
        self.usage.ticks += 1
        if self.outage is not None and self.outage[0] <= tick <= self.outage[1]:
            return ()
        started, cpu = time.perf_counter(), time.process_time()
        self.team.observe(tick, arrived)
        orders = self.team.decide()
        self.usage.decisions.append(time.perf_counter() - started)
        self.usage.seconds += time.process_time() - cpu
        return orders

    def as_json(self, robots: int) -> dict[str, float]:
        """Return the cost of the centre, for a result."""
        share = 1.0 / max(1.0, robots * self.usage.ticks * CONTROL_PERIOD)
        return {
            "cpu_ms_per_robot_second": 1e3 * self.usage.seconds * share,
            "longest_decision_ms": 1e3 * max(self.usage.decisions, default=0.0),
            "p99_decision_ms": 1e3 * float(np.percentile(self.usage.decisions or [0.0], 99.0)),
            "bytes_up_per_robot_second": self.usage.bytes_up * share,
            "bytes_down_per_robot_second": self.usage.bytes_down * share,
            **self.team.figures(),
        }


def delay_ticks(delay: float) -> int:
    """Return a delay [s] in whole ticks."""
    return math.ceil(delay / CONTROL_PERIOD - 1e-9)


def _due(waves: deque[tuple[int, list[M]]], last: int) -> Iterator[M]:
    while waves and waves[0][0] <= last:
        yield from waves.popleft()[1]
