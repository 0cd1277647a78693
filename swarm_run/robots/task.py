"""One action goal on its way, from the request to the result."""

from __future__ import annotations

import time
from collections.abc import Callable
from enum import Enum
from functools import partial
from typing import Any
from uuid import uuid4

from action_msgs.msg import GoalStatus
from rclpy.task import Future
from unique_identifier_msgs.msg import UUID

from swarm_run.robots.delivery import Action, Delivery, DeliveryEvent, Phase
from swarm_run.robots.goal_client import GoalClient

REFUSED = "the robot refused the goal"
FORGOTTEN = "the robot does not know the goal any more; was its navigator restarted?"


class TaskResult(Enum):
    """How a task ended, with BasicNavigator's names."""

    UNKNOWN = 0
    SUCCEEDED = 1
    CANCELED = 2
    FAILED = 3


_RESULTS = {
    GoalStatus.STATUS_SUCCEEDED: TaskResult.SUCCEEDED,
    GoalStatus.STATUS_CANCELED: TaskResult.CANCELED,
    GoalStatus.STATUS_ABORTED: TaskResult.FAILED,
}


class Task:
    """One action goal on its way: requested, accepted or refused, ended.

    Attributes:
        feedback: Latest feedback message; None before the first.
        result: Result message; None until the end and for a goal that was refused or forgotten.
        is_forgotten: Whether the robot took the goal and does not know it any more.
        outcome: How it ended; UNKNOWN until then.
        reason: Why it did not succeed, in words; empty until the end and of a success.
    """

    def __init__(
        self, client: GoalClient, goal: Any, on_end: Callable[[Task], None] | None = None
    ) -> None:
        """Send a goal.

        Args:
            client: Client of the action, which sends the goal.
            goal: Message of the action's goal type.
            on_end: Called with the task when it has ended.
        """
        self.feedback: Any = None
        self.result: Any = None
        self.outcome = TaskResult.UNKNOWN
        self.reason = ""
        self.is_forgotten = False
        self._client = client
        self._goal = goal
        self._goal_id = UUID(uuid=list(uuid4().bytes))
        self._on_end = on_end
        self._is_cancelled = False
        self._refusal = ""  # why the robot refused the goal, if it says so
        self._delivery = Delivery(time.monotonic())
        client.listen(self._goal_id, self._receive_feedback)
        self._do(Action.SEND)

    @property
    def goal_id(self) -> bytes:
        """Id of the goal."""
        return bytes(self._goal_id.uuid)

    @property
    def is_complete(self) -> bool:
        """Whether it has ended."""
        return self._delivery.phase is Phase.ENDED

    @property
    def is_accepted(self) -> bool:
        """Whether the robot has taken the goal, or it has ended."""
        return self._delivery.phase in (Phase.ACCEPTED, Phase.ENDED)

    def cancel(self) -> None:
        """Ask for the end; harmless when it has come."""
        self._is_cancelled = True
        if not self.is_complete:
            self._client.request_cancel(self._goal_id)

    def look(self, is_busy: bool) -> None:
        """Ask again for an overdue answer.

        Args:
            is_busy: Whether the robot has a goal; a busy one may take its time for the result.
        """
        self._do(self._delivery.look(time.monotonic(), is_busy))

    def ask(self) -> None:
        """Ask for the result at once: the robot was silent, or its navigator has been restarted."""
        if not self.is_complete:
            self._do(self._delivery.hear(DeliveryEvent.OVERDUE, time.monotonic()))

    def give_up(self, reason: str) -> None:
        """End as failed without an answer: nobody is there to give one.

        Args:
            reason: For people.
        """
        if not self.is_complete:
            known = self._delivery.phase
            self._delivery.phase = Phase.ENDED
            self._end(known, reason)

    def _do(self, action: Action) -> None:
        if action is Action.SEND:
            sent = self._client.send_goal(self._goal_id, self._goal)
            sent.add_done_callback(self._receive_answer)
        elif action is Action.ASK:
            asked = self._client.request_result(self._goal_id)
            asked.add_done_callback(partial(self._receive_result, self._delivery.question))

    def _receive_feedback(self, feedback: Any) -> None:
        self.feedback = feedback

    def _receive_answer(self, future: Future) -> None:
        is_accepted = future.result().accepted
        self._hear(DeliveryEvent.ACCEPTANCE if is_accepted else DeliveryEvent.REFUSAL)
        if is_accepted and self._is_cancelled:
            self.cancel()

    def _receive_result(self, question: int, future: Future) -> None:
        response = future.result()
        if response.status == GoalStatus.STATUS_UNKNOWN:
            self._refusal = getattr(response.result, "error_msg", "")
            self._hear(DeliveryEvent.UNKNOWN, question)
            return
        if not self.is_complete:
            self.result = response.result
            self.outcome = _RESULTS.get(response.status, TaskResult.FAILED)
        self._hear(DeliveryEvent.RESULT)

    def _hear(self, event: DeliveryEvent, question: int = 0) -> None:
        known = self._delivery.phase
        if known is Phase.ENDED:
            return
        self._do(self._delivery.hear(event, time.monotonic(), question))
        if self.is_complete:
            self._end(known)

    def _end(self, known: Phase, reason: str = "") -> None:
        """End the task; `known` is the phase of the goal just before."""
        self._client.forget(self._goal_id)
        if self.result is None:
            self.outcome = TaskResult.FAILED
            self.is_forgotten = known is Phase.ACCEPTED and not reason
            self.reason = reason or (FORGOTTEN if self.is_forgotten else refused(self._refusal))
        elif self.outcome is not TaskResult.SUCCEEDED:
            self.reason = why_not(self.result, self.outcome)
        if self._on_end is not None:
            self._on_end(self)


def refused(why: str) -> str:
    """Return that the robot refused a goal, and why if it says so.

    Args:
        why: In the robot's words; empty if it gave no reason.
    """
    return f"{REFUSED}: {why}" if why else REFUSED


def why_not(result: Any, outcome: TaskResult) -> str:
    """Return why a goal did not succeed, for people.

    Args:
        result: Result message; its `error_code` and `error_msg` are used if it has them.
        outcome: Its name stands in where there is no message.
    """
    code = getattr(result, "error_code", 0)
    message = getattr(result, "error_msg", "") or outcome.name.lower()
    return f"error {code}: {message}" if code else message
