"""An action client that knows its goals' ids: service clients, and feedback on request.

rclpy's own client always subscribes to feedback and status. With many robots that costs the
operator more than everything else, and every robot composes feedback that no client reads. It also
hides a goal's id until the server has answered, so that nothing can be asked if the answer is lost.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from action_msgs.srv import CancelGoal
from rclpy.node import Node
from rclpy.task import Future
from unique_identifier_msgs.msg import UUID

from swarm_common.middleware.ros_io import RELIABLE


class GoalClient:
    """Sends goals to one action and asks for their results."""

    def __init__(self, node: Node, kind: Any, name: str, *, with_feedback: bool) -> None:
        """Create the clients of the action's services.

        Args:
            node: Node that all traffic goes through; spinning it is the caller's work.
            kind: Class of the action, like `nav2_msgs.action.NavigateToPose`.
            name: Name of the action, with the namespace: `/Srobot3/navigate_to_pose`.
            with_feedback: Whether to subscribe to the action's feedback.
        """
        self._kind = kind
        make = node.create_client
        self._send = make(kind.Impl.SendGoalService, f"{name}/_action/send_goal")
        self._result = make(kind.Impl.GetResultService, f"{name}/_action/get_result")
        self._cancel = make(CancelGoal, f"{name}/_action/cancel_goal")
        self._listeners: dict[bytes, Callable[[Any], None]] = {}
        if with_feedback:
            node.create_subscription(
                kind.Impl.FeedbackMessage, f"{name}/_action/feedback", self._pass_on, RELIABLE
            )

    def server_is_ready(self) -> bool:
        """Whether the server's services have been found."""
        services = (self._send, self._result, self._cancel)
        return all(service.service_is_ready() for service in services)

    def send_goal(self, goal_id: UUID, goal: Any) -> Future:
        """Send a goal; the future's response has `accepted`.

        Args:
            goal_id: Chosen by the client, before the goal is sent.
            goal: Message of the type `kind.Goal`.
        """
        request = self._kind.Impl.SendGoalService.Request(goal_id=goal_id, goal=goal)
        return self._send.call_async(request)

    def request_result(self, goal_id: UUID) -> Future:
        """Ask for a goal's result; the future's response has `status` and `result`."""
        return self._result.call_async(self._kind.Impl.GetResultService.Request(goal_id=goal_id))

    def request_cancel(self, goal_id: UUID) -> Future:
        """Ask for a goal's end.

        Returns:
            Future of the response, a CancelGoal.Response.
        """
        request = CancelGoal.Request()
        request.goal_info.goal_id = goal_id
        return self._cancel.call_async(request)

    def listen(self, goal_id: UUID, take: Callable[[Any], None]) -> None:
        """Call `take` with each feedback on a goal.

        Args:
            take: Called with the feedback message, from the callbacks of the node. Needs
                `with_feedback`.
        """
        self._listeners[bytes(goal_id.uuid)] = take

    def forget(self, goal_id: UUID) -> None:
        """Stop the callbacks of a goal."""
        self._listeners.pop(bytes(goal_id.uuid), None)

    def _pass_on(self, message: Any) -> None:
        take = self._listeners.get(bytes(message.goal_id.uuid))
        if take is not None:
            take(message.feedback)
