"""An action client without feedback and status: three service clients and nothing else.

rclpy's own client always subscribes to both. With many robots that costs the operator more than
everything else, and every robot composes feedback that nobody reads.
"""

from __future__ import annotations

import uuid
from typing import Any

from action_msgs.srv import CancelGoal
from rclpy.node import Node
from rclpy.task import Future
from unique_identifier_msgs.msg import UUID


class QuietGoalHandle:
    """A goal that the server has answered; the part of ClientGoalHandle that a Task needs.

    Attributes:
        accepted: Whether the server took it.
    """

    def __init__(self, client: QuietActionClient, goal_id: UUID, accepted: bool) -> None:
        """Keep whose goal it is."""
        self.accepted = accepted
        self._client = client
        self._goal_id = goal_id

    def get_result_async(self) -> Future:
        """Ask for the result; the future's response has `status` and `result`."""
        return self._client.request_result(self._goal_id)

    def cancel_goal_async(self) -> Future:
        """Ask for the goal's end."""
        return self._client.request_cancel(self._goal_id)


class QuietActionClient:
    """Sends goals to one action and fetches their results."""

    def __init__(self, node: Node, kind: Any, name: str) -> None:
        """Create the clients.

        Args:
            node: To create them on.
            kind: Action type.
            name: Of the action, absolute.
        """
        self._kind = kind
        make = node.create_client
        self._send = make(kind.Impl.SendGoalService, f"{name}/_action/send_goal")
        self._result = make(kind.Impl.GetResultService, f"{name}/_action/get_result")
        self._cancel = make(CancelGoal, f"{name}/_action/cancel_goal")

    def server_is_ready(self) -> bool:
        """Whether the server's services have been found."""
        services = (self._send, self._result, self._cancel)
        return all(service.service_is_ready() for service in services)

    def send_goal_async(self, goal: Any, feedback_callback: Any = None) -> Future:
        """Send a goal; the future's result is its QuietGoalHandle. There is no feedback."""
        del feedback_callback
        goal_id = UUID(uuid=list(uuid.uuid4().bytes))
        request = self._kind.Impl.SendGoalService.Request(goal_id=goal_id, goal=goal)
        answered = Future()

        def on_answer(future: Future) -> None:
            answered.set_result(QuietGoalHandle(self, goal_id, future.result().accepted))

        self._send.call_async(request).add_done_callback(on_answer)
        return answered

    def request_result(self, goal_id: UUID) -> Future:
        """Ask for a goal's result."""
        return self._result.call_async(self._kind.Impl.GetResultService.Request(goal_id=goal_id))

    def request_cancel(self, goal_id: UUID) -> Future:
        """Ask for a goal's end."""
        request = CancelGoal.Request()
        request.goal_info.goal_id = goal_id
        return self._cancel.call_async(request)
