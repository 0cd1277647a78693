"""One action goal on its way, from the request to the result."""

from __future__ import annotations

from collections.abc import Callable
from enum import Enum
from typing import Any

from action_msgs.msg import GoalStatus
from rclpy.action import ActionClient
from rclpy.task import Future

from swarm_commander.quiet_action import QuietActionClient


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
        result: Result message; None until the end and for a refused goal.
        outcome: How it ended; UNKNOWN until then.
        is_complete: Whether it has ended.
    """

    def __init__(self, on_end: Callable[[Task], None] | None = None) -> None:
        self.feedback: Any = None
        self.result: Any = None
        self.outcome = TaskResult.UNKNOWN
        self.is_complete = False
        self._on_end = on_end
        self._handle: Any = None
        self._is_cancelled = False

    def send(self, client: ActionClient | QuietActionClient, goal: Any) -> None:
        """Send the goal."""
        future = client.send_goal_async(goal, feedback_callback=self._take_feedback)
        future.add_done_callback(self._take_answer)

    def cancel(self) -> None:
        """Ask for the end; harmless when it has come."""
        self._is_cancelled = True
        if self._handle is not None and not self.is_complete:
            self._handle.cancel_goal_async()

    def _take_feedback(self, message: Any) -> None:
        self.feedback = message.feedback

    def _take_answer(self, future: Future) -> None:
        self._handle = future.result()
        if self._handle is None or not self._handle.accepted:
            self._end(TaskResult.FAILED)
            return
        self._handle.get_result_async().add_done_callback(self._take_result)
        if self._is_cancelled:
            self.cancel()

    def _take_result(self, future: Future) -> None:
        response = future.result()
        self.result = response.result
        self._end(_RESULTS.get(response.status, TaskResult.FAILED))

    def _end(self, outcome: TaskResult) -> None:
        self.outcome = outcome
        self.is_complete = True
        if self._on_end is not None:
            self._on_end(self)
