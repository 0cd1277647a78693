"""A goal on its way to an action server and back, over services that may lose a message.

DDS loses an answer when it is sent before both sides have found each other whole, or when a link
or a process is lost. A client that waits for it waits for ever, so an overdue result is asked for:
for a goal that it knows, the server answers when the goal has ended; for an unknown one, at once.
A goal is sent again under its old id, which the server takes only once.

No clock, no I/O. https://design.ros2.org/articles/actions.html has the services.
"""

from __future__ import annotations

from enum import Enum

PATIENCE = 3.0  # [s] of wall time for an answer that should come at once,
MOST_PATIENCE = 60.0  # [s] and at most, as it doubles while nothing is heard
TASK_TIME = 30.0  # [s] after which a result of a robot that is busy is asked for once more,
MOST_TASK_TIME = 480.0  # [s] and at most


class Phase(Enum):
    """How much is known about a goal."""

    SENT = "sent"
    DOUBTED = "doubted"  # no answer; asked whether the server knows the goal
    SENT_AGAIN = "sent again"
    REFUSED = "refused"  # as a whole, or only a second copy; asked which
    ACCEPTED = "accepted"  # asked for the result
    ENDED = "ended"


class DeliveryEvent(Enum):
    """The news about a goal."""

    ACCEPTANCE = "acceptance"
    REFUSAL = "refusal"
    RESULT = "result"
    UNKNOWN = "unknown"  # the server does not know the goal
    OVERDUE = "overdue"


class Action(Enum):
    """The reaction to it."""

    NOTHING = "nothing"
    SEND = "send"
    ASK = "ask"  # for the result


UNANSWERED: dict[DeliveryEvent, tuple[Phase, Action]] = {
    DeliveryEvent.ACCEPTANCE: (Phase.ACCEPTED, Action.ASK),
    DeliveryEvent.REFUSAL: (Phase.REFUSED, Action.ASK),
    DeliveryEvent.RESULT: (Phase.ENDED, Action.NOTHING),
    DeliveryEvent.OVERDUE: (Phase.DOUBTED, Action.ASK),
}
TRANSITIONS: dict[Phase, dict[DeliveryEvent, tuple[Phase, Action]]] = {
    Phase.SENT: {
        DeliveryEvent.ACCEPTANCE: (Phase.ACCEPTED, Action.ASK),
        DeliveryEvent.REFUSAL: (Phase.REFUSED, Action.ASK),  # for the reason
        DeliveryEvent.OVERDUE: (Phase.DOUBTED, Action.ASK),
    },
    Phase.DOUBTED: UNANSWERED | {DeliveryEvent.UNKNOWN: (Phase.SENT_AGAIN, Action.SEND)},
    Phase.SENT_AGAIN: UNANSWERED
    | {DeliveryEvent.UNKNOWN: (Phase.SENT_AGAIN, Action.NOTHING)},  # asked before it was sent again
    Phase.REFUSED: {
        DeliveryEvent.ACCEPTANCE: (Phase.ACCEPTED, Action.ASK),
        DeliveryEvent.REFUSAL: (Phase.REFUSED, Action.NOTHING),
        DeliveryEvent.RESULT: (Phase.ENDED, Action.NOTHING),
        DeliveryEvent.UNKNOWN: (Phase.ENDED, Action.NOTHING),
        DeliveryEvent.OVERDUE: (Phase.REFUSED, Action.ASK),
    },
    Phase.ACCEPTED: {
        DeliveryEvent.ACCEPTANCE: (Phase.ACCEPTED, Action.NOTHING),
        DeliveryEvent.REFUSAL: (Phase.ACCEPTED, Action.NOTHING),  # of a second copy
        DeliveryEvent.RESULT: (Phase.ENDED, Action.NOTHING),
        DeliveryEvent.UNKNOWN: (Phase.ENDED, Action.NOTHING),  # the server was restarted
        DeliveryEvent.OVERDUE: (Phase.ACCEPTED, Action.ASK),
    },
    Phase.ENDED: {event: (Phase.ENDED, Action.NOTHING) for event in DeliveryEvent},
}


class Delivery:
    """State of one goal.

    Attributes:
        phase: How much is known about it.
        question: Number of the newest request for the result; an answer UNKNOWN to an older one
            says nothing about now.
    """

    def __init__(self, now: float) -> None:
        """Begin with a goal that is sent now.

        Args:
            now: Wall time [s], of any monotonic clock.
        """
        self.phase = Phase.SENT
        self.question = 0
        self._since = now
        self._patience = PATIENCE
        self._task_time = TASK_TIME

    def hear(self, event: DeliveryEvent, now: float, question: int = 0) -> Action:
        """Handle an event at wall time `now`; return the next action.

        Args:
            now: Wall time [s].
            question: For UNKNOWN, the number of the request that it answers.

        Raises:
            ValueError: If the event cannot happen in this phase, see `TRANSITIONS`.
        """
        if event is DeliveryEvent.UNKNOWN and question != self.question:
            return Action.NOTHING
        try:
            self.phase, action = TRANSITIONS[self.phase][event]
        except KeyError:
            raise ValueError(
                f"{event.name} cannot happen to a goal that is {self.phase.value}"
            ) from None
        if event is not DeliveryEvent.OVERDUE:
            self._patience = PATIENCE
        if action is not Action.NOTHING:
            self._since = now
            self.question += action is Action.ASK
        return action

    def look(self, now: float, is_busy: bool) -> Action:
        """Notice an overdue answer; return the next action.

        Args:
            now: Wall time [s].
            is_busy: Whether the robot is known to have a goal.
        """
        waited = now - self._since
        if self.phase is Phase.ENDED:
            return Action.NOTHING
        if self.phase is Phase.ACCEPTED and is_busy:
            if waited < self._task_time:
                return Action.NOTHING
            self._task_time = min(2.0 * self._task_time, MOST_TASK_TIME)
        else:
            if waited < self._patience:
                return Action.NOTHING
            self._patience = min(2.0 * self._patience, MOST_PATIENCE)
        return self.hear(DeliveryEvent.OVERDUE, now)
