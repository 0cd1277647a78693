"""One robot's way through the stops of its mission: what to send next, decided without ROS."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from enum import Enum

from swarm_common.model.records import CONTROL_PERIOD
from swarm_mission.leg import Stop

RETRY_TICKS = 10  # [ticks] between a failed goal and the next try
LOST_REASON = "the robot was lost"


class ItineraryState(Enum):
    """Where a robot is in its mission."""

    READY = "ready"  # nothing sent yet
    UNDER_WAY = "under way"
    GIVING_WAY = "giving way"  # a goal of another client took the robot over
    DONE = "done"
    LOST = "lost"


class ItineraryEvent(Enum):
    """Event in the life of an itinerary."""

    START = "start"
    REACHED = "reached"
    FAILED = "failed"
    TAKEN_OVER = "taken over"
    FREE_AGAIN = "free again"
    FORGOTTEN = "forgotten"  # by the robot, whose navigator was restarted
    LOST = "lost"
    FOUND = "found"  # after it was lost


# START, FAILED and so on may lead to DONE instead when no stop is left; see `_advance`.
TRANSITIONS: dict[ItineraryState, dict[ItineraryEvent, ItineraryState]] = {
    ItineraryState.READY: {
        ItineraryEvent.START: ItineraryState.UNDER_WAY,
        ItineraryEvent.LOST: ItineraryState.LOST,
    },
    ItineraryState.UNDER_WAY: {
        ItineraryEvent.REACHED: ItineraryState.UNDER_WAY,
        ItineraryEvent.FAILED: ItineraryState.UNDER_WAY,
        ItineraryEvent.TAKEN_OVER: ItineraryState.GIVING_WAY,
        ItineraryEvent.FORGOTTEN: ItineraryState.UNDER_WAY,
        ItineraryEvent.LOST: ItineraryState.LOST,
    },
    ItineraryState.GIVING_WAY: {
        ItineraryEvent.FREE_AGAIN: ItineraryState.UNDER_WAY,
        ItineraryEvent.LOST: ItineraryState.LOST,
    },
    ItineraryState.DONE: {ItineraryEvent.LOST: ItineraryState.DONE},
    ItineraryState.LOST: {event: ItineraryState.LOST for event in ItineraryEvent}
    | {ItineraryEvent.FOUND: ItineraryState.UNDER_WAY},
}


@dataclass(frozen=True, slots=True)
class NextGoal:
    """A goal to send."""

    stop: Stop  # where to
    start_tick: int  # tick at which to set off; 0 for at once
    number: int  # of the stop within the mission, from 1
    attempt: int  # 1 for the first try


@dataclass(frozen=True, slots=True)
class StopOutcome:
    """A stop that is settled."""

    stop: Stop  # where to
    reached: bool  # whether the robot got there
    tick: int  # at which it was settled
    start_tick: int = 0  # at which the robot was first free to set off for it
    reason: str = ""  # why it was missed; empty if it was reached

    @property
    def duration(self) -> float:
        """Time [s] that the stop took, with all tries."""
        return max(0, self.tick - self.start_tick) * CONTROL_PERIOD


class Itinerary:
    """State of one robot's mission.

    Attributes:
        state: Where it is.
        outcomes: The settled stops in order.
    """

    def __init__(
        self,
        stops: Sequence[Stop],
        retries: int,
        settled: int = 0,
        more: Callable[[], Sequence[Stop]] = tuple,
    ) -> None:
        """Begin.

        Args:
            retries: Times that a goal is tried again.
            settled: Stops at the beginning that are settled already.
            more: Returns further stops when all are settled; none: the mission is done.
        """
        self._more = more
        self.state = ItineraryState.READY
        self.outcomes: list[StopOutcome] = []
        self._stops = tuple(stops)[settled:]
        self._settled_before = min(settled, len(stops))
        self._retries = retries
        self._attempt = 1
        self._first_tick = 0

    @property
    def total(self) -> int:
        """Number of stops, with those settled before."""
        return self._settled_before + len(self._stops)

    @property
    def next_stop(self) -> str:
        """Name of the first stop that is not settled; empty if all are."""
        settled = len(self.outcomes)
        return self._stops[settled].name if settled < len(self._stops) else ""

    @property
    def is_over(self) -> bool:
        """Whether nothing more will be sent."""
        return self.state in (ItineraryState.DONE, ItineraryState.LOST)

    def start(self, tick: int = 0) -> NextGoal | None:
        """Begin.

        Args:
            tick: Now, for a mission that goes on after a break; its first delays are over.

        Returns:
            The first goal; None if there is none at all.

        Raises:
            ValueError: If the mission has begun already.
        """
        self._enter(ItineraryEvent.START)
        return self._advance(tick)

    def on_end(
        self, reached: bool, tick: int, reason: str = "", *, is_final: bool = False
    ) -> NextGoal | None:
        """Settle the goal under way.

        Args:
            reached: Whether the robot got there.
            is_final: Whether another try would fail, too.

        Returns:
            The next goal, which may be the same for another try; None if nothing more is to be
            sent.

        Raises:
            ValueError: If no goal is under way.
        """
        if (
            self._enter(ItineraryEvent.REACHED if reached else ItineraryEvent.FAILED)
            is ItineraryState.LOST
        ):
            return None
        stop = self._stops[len(self.outcomes)]
        if not reached and not is_final and self._attempt <= self._retries:
            self._attempt += 1
            return self._order(tick + RETRY_TICKS)
        why = "" if reached else reason
        self.outcomes.append(StopOutcome(stop, reached, tick, self._first_tick, why))
        self._attempt = 1
        return self._advance(tick + stop.pause_ticks if reached else tick + RETRY_TICKS)

    def on_taken_over(self) -> None:
        """Another client sent the robot elsewhere: wait until it is free again.

        Raises:
            ValueError: If no goal is under way.
        """
        self._enter(ItineraryEvent.TAKEN_OVER)

    def on_free_again(self, tick: int) -> NextGoal | None:
        """The other's goal has ended: send ours once more; this is not a failed try.

        Returns:
            The goal to send; None for a robot that is lost.

        Raises:
            ValueError: If no other client had the robot.
        """
        if self._enter(ItineraryEvent.FREE_AGAIN) is ItineraryState.LOST:
            return None
        return self._order(tick + RETRY_TICKS)

    def on_forgotten(self, tick: int) -> NextGoal | None:
        """The robot does not know its goal any more: send it once more; no try has failed.

        Returns:
            The goal to send; None for a robot that is lost.

        Raises:
            ValueError: If no goal is under way.
        """
        if self._enter(ItineraryEvent.FORGOTTEN) is ItineraryState.LOST:
            return None
        return self._order(max(tick, self._first_tick))

    def on_found(self, tick: int) -> tuple[int, NextGoal]:
        """The lost robot is back: its remaining goals are open again.

        Only for a robot whose goals `on_lost` returned.

        Returns:
            Number of stops that were missed by the loss and are open again, and the goal to send.

        Raises:
            ValueError: If the robot was not lost.
        """
        self._enter(ItineraryEvent.FOUND)
        kept = [outcome for outcome in self.outcomes if outcome.reason != LOST_REASON]
        count = len(self.outcomes) - len(kept)
        self.outcomes = kept
        return count, self._order(max(tick, self._first_tick))

    def on_lost(self, tick: int) -> list[StopOutcome]:
        """The robot is gone: return its remaining stops, which count as failed.

        Returns:
            Outcomes of the stops that were open, all missed; none if the mission was over.
        """
        if self._enter(ItineraryEvent.LOST) is ItineraryState.DONE:
            return []
        rest = [
            StopOutcome(stop, False, tick, tick, LOST_REASON)
            for stop in self._stops[len(self.outcomes) :]
        ]
        self.outcomes.extend(rest)
        return rest

    def _advance(self, start_tick: int) -> NextGoal | None:
        if len(self.outcomes) == len(self._stops):
            self._stops += tuple(self._more())
        if len(self.outcomes) == len(self._stops):
            self.state = ItineraryState.DONE
            return None
        self._first_tick = start_tick + self._stops[len(self.outcomes)].delay_ticks
        return self._order(self._first_tick)

    def _order(self, start_tick: int) -> NextGoal:
        number = len(self.outcomes)
        place = self._settled_before + number + 1
        return NextGoal(self._stops[number], start_tick, place, self._attempt)

    def _enter(self, event: ItineraryEvent) -> ItineraryState:
        try:
            self.state = TRANSITIONS[self.state][event]
        except KeyError:
            raise ValueError(
                f"{event.name} cannot happen to a mission that is {self.state.value}"
            ) from None
        return self.state
