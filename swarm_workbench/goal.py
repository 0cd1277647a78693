"""A goal on its way."""

from __future__ import annotations

import asyncio
import math
from collections.abc import Callable, Generator
from dataclasses import dataclass
from typing import Any

from swarm_common.model.errors import SwarmError
from swarm_common.model.records import CONTROL_PERIOD, Pose


class GoalTimeoutError(SwarmError):
    """A goal has not ended in the time that its user gave it."""


@dataclass(frozen=True, slots=True)
class GoalResult:
    """How a goal ended; true if it was reached."""

    outcome: str  # `succeeded`, `aborted` or `canceled`
    reason: str  # why it was not reached; empty if it was
    time: float  # [s] of simulated time at which it ended
    duration: float  # [s] from when it was sent

    def __bool__(self) -> bool:
        return self.outcome == "succeeded"


class Goal:
    """A goal of one robot: wait for it, await it, or cancel it.

    Attributes:
        robot: Name of the robot.
        action: Name of Nav2's action.
        pose: Where to, in map; None for an action without a place.
        result: How it ended; None until then.
    """

    def __init__(
        self,
        robot: str,
        action: str,
        pose: Pose | None,
        tick: int,
        run: Callable[[], int],
        cancel: Callable[[Goal], None],
    ) -> None:
        self.robot = robot
        self.action = action
        self.pose = pose
        self.result: GoalResult | None = None
        self._start = tick
        self._run = run
        self._cancel = cancel

    @property
    def is_done(self) -> bool:
        """Whether it has ended."""
        return self.result is not None

    def wait(self, timeout: float = math.inf) -> GoalResult:
        """Let time pass until it has ended; a goal that has returns at once.

        Args:
            timeout: [s] of simulated time.

        Raises:
            GoalTimeoutError: If it has not ended by then; it goes on.
            SwarmError: If the swarm has ended.
        """
        tick = self._start
        first: int | None = None
        while self.result is None:
            tick = self._run()
            first = tick if first is None else first
            if (tick - first) * CONTROL_PERIOD >= timeout and self.result is None:
                raise GoalTimeoutError(
                    f"{self.robot} has not arrived after {timeout:g} s; wait longer, or cancel()"
                )
        return self.result

    def __await__(self) -> Generator[Any, None, GoalResult]:
        return self._settled().__await__()

    async def _settled(self) -> GoalResult:
        while self.result is None:
            await asyncio.to_thread(self._run)
        return self.result

    def cancel(self) -> None:
        """Ask the robot to stop; harmless if the goal has ended."""
        if self.result is None:
            self._cancel(self)

    def settle(self, outcome: str, reason: str, tick: int) -> None:
        """Record its end; called by the backend."""
        if self.result is None:
            time, duration = (round(n * CONTROL_PERIOD, 3) for n in (tick, tick - self._start))
            self.result = GoalResult(outcome, reason, time, duration)

    def __repr__(self) -> str:
        state = self.result.outcome if self.result else "under way"
        return f"<Goal of {self.robot}: {self.action}, {state}>"
