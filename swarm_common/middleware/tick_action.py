"""Action servers that never block: a goal is handed on and its result sent at the end.

An action is three services and two topics (https://design.ros2.org/articles/actions.html), and so
it is built here. rclpy's server polls a coroutine per goal, and rcl forgets goals by timers: when
many are due at a time, rclpy's EventsExecutor calls back for them again and again, for seconds.
"""

from __future__ import annotations

import contextlib
from collections import OrderedDict, deque
from collections.abc import Callable
from typing import Any

from action_msgs.msg import GoalInfo, GoalStatus, GoalStatusArray
from action_msgs.srv import CancelGoal
from rclpy.node import Node
from rclpy.qos import QoSProfile, qos_profile_action_status_default
from rclpy.time import Time

from swarm_common.middleware.rejections import REASON_LENGTH, RejectedError
from swarm_common.process.standard_streams import FaultLog

# Requests wait until the next look, and DDS forgets all but the newest `depth` of them without a
# word: the usual ten are what one client sends at once.
BURST = QoSProfile(depth=2000)
# [s] of the node's clock. Each status message lists all goals whose results are kept; rclpy's own
# 15 min are for clients that ask long after the end.
RESULT_TIMEOUT = 60.0
ACTIVE = (GoalStatus.STATUS_ACCEPTED, GoalStatus.STATUS_EXECUTING, GoalStatus.STATUS_CANCELING)
MOST_ASKED = 100  # requests for the result of a goal that has not ended; the oldest get none
REFUSALS_KEPT = 100  # of which the reason can be asked for
ANY_GOAL = bytes(16)  # in a request to cancel: whichever the stamp says
FAULTS = FaultLog("request of an action")

Consider = Callable[[Any], bool]
Begin = Callable[["TickActionServer", "GoalHandle"], None]
Cancel = Callable[["GoalHandle"], None]
Respond = Callable[[Any, Any], None]


class GoalHandle:
    """A goal that was accepted.

    Attributes:
        request: The goal as its client sent it.
        info: Id and time of acceptance.
        status: See `action_msgs/GoalStatus`.
        accepted_at, ended_at: [ns] of the node's clock.
    """

    def __init__(self, request: Any, info: GoalInfo, accepted_at: int) -> None:
        """Start the goal as executing: goals begin when they are accepted."""
        self.request = request
        self.info = info
        self.status = GoalStatus.STATUS_EXECUTING
        self.accepted_at = accepted_at
        self.ended_at = 0
        self.response: Any = None  # requests for the result, answered once it has ended
        # Headers of the requests for the result until then.
        self.asked: deque[Any] = deque(maxlen=MOST_ASKED)

    @property
    def is_active(self) -> bool:
        """Whether it has not ended."""
        return self.status in ACTIVE

    @property
    def is_cancel_requested(self) -> bool:
        """Whether its client wants it canceled."""
        return bool(self.status == GoalStatus.STATUS_CANCELING)


class TickActionServer:
    """Accepts goals at once and ends them with `finish`, between two ticks."""

    def __init__(
        self, node: Node, kind: Any, name: str, consider: Consider, begin: Begin, cancel: Cancel
    ) -> None:
        """Create the server; it ends with the node.

        Args:
            consider: Whether to accept a goal request. A `RejectedError` says why not; who asks
                for the result is told.
            begin: Called with each accepted goal, which is executing then.
            cancel: Called when a client wants a goal canceled; it ends some ticks later.
        """
        self.kind = kind
        self._node = node
        self._consider, self._begin, self._cancel = consider, begin, cancel
        self._goals: dict[bytes, GoalHandle] = {}  # in the order in which they were accepted
        self._refused: OrderedDict[bytes, str] = OrderedDict()  # why, of the latest ones
        topics = f"{name}/_action"
        self._feedback = node.create_publisher(kind.Impl.FeedbackMessage, f"{topics}/feedback", 10)
        self._status = node.create_publisher(
            GoalStatusArray, f"{topics}/status", qos_profile_action_status_default
        )
        services = kind.Impl
        self._respond_to_goal = self._serve(
            f"{topics}/send_goal", services.SendGoalService, self._on_goal
        )
        self._serve(f"{topics}/cancel_goal", services.CancelGoalService, self._on_cancel)
        self._respond_to_result = self._serve(
            f"{topics}/get_result", services.GetResultService, self._on_result
        )

    def _serve(self, name: str, kind: Any, on_request: Callable[[Any, Any, Any], Any]) -> Respond:
        """Offer a service whose response may be sent later.

        rclpy's executor calls the callback, and then `send_response` with what that returned and
        the header of the request.

        Args:
            on_request: Gets request, empty response and header; returns the response, or None if it
                is sent elsewhere.

        Returns:
            Function that sends a response to the request with a header.
        """
        service = self._node.create_service(
            kind, name, lambda request, _: request, qos_profile=BURST
        )
        send_response = service.send_response

        def respond(response: Any, header: Any) -> None:
            """Send a response."""
            with contextlib.suppress(
                RuntimeError
            ):  # RCLError: the client is gone, or not known yet
                send_response(response, header)

        def send(request: Any, header: Any) -> None:
            """Handle a request, in place of rclpy's sending of a response."""
            try:
                response = on_request(request, kind.Response(), header)
                if response is not None:
                    respond(response, header)
            except Exception as error:  # would end rclpy's executor
                FAULTS.note(error)

        service.send_response = send
        return respond

    # What clients ask for

    def _on_goal(self, request: Any, response: Any, header: Any) -> None:
        self._forget()
        goal_id = bytes(request.goal_id.uuid)
        response.accepted = goal_id not in self._goals and self._accepts(goal_id, request.goal)
        goal = None
        if response.accepted:
            now = self._now()
            response.stamp = Time(nanoseconds=now).to_msg()
            goal = GoalHandle(
                request.goal, GoalInfo(goal_id=request.goal_id, stamp=response.stamp), now
            )
            self._goals[goal_id] = goal
        self._respond_to_goal(response, header)
        if goal is not None:
            self._publish_status()
            self._begin(self, goal)

    def _accepts(self, goal_id: bytes, goal: Any) -> bool:
        self._refused.pop(goal_id, None)
        try:
            return self._consider(goal)
        except RejectedError as error:
            self._refused[goal_id] = str(error)[:REASON_LENGTH]
            while len(self._refused) > REFUSALS_KEPT:
                self._refused.popitem(last=False)
            return False

    def _on_cancel(self, request: Any, response: Any, header: Any) -> Any:
        """Cancel one goal, all that were accepted until a stamp, or simply all."""
        del header
        wanted, goal_id = [], bytes(request.goal_info.goal_id.uuid)
        stamp = request.goal_info.stamp
        until = 10**9 * stamp.sec + stamp.nanosec
        is_all = goal_id == ANY_GOAL and until == 0
        for key, goal in self._goals.items():
            is_older = until > 0 and goal.accepted_at <= until
            is_meant = is_all or is_older or key == goal_id
            if is_meant and goal.status == GoalStatus.STATUS_EXECUTING:
                wanted.append(goal)
        if goal_id != ANY_GOAL and not wanted:
            response.return_code = self._why_not(goal_id)
        for goal in wanted:
            self._cancel(goal)
            goal.status = GoalStatus.STATUS_CANCELING
        response.goals_canceling = [goal.info for goal in wanted]
        if wanted:
            self._publish_status()
        return response

    def _why_not(self, goal_id: bytes) -> int:
        if (goal := self._goals.get(goal_id)) is None:
            return int(CancelGoal.Response.ERROR_UNKNOWN_GOAL_ID)
        if goal.is_active:  # it is being canceled
            return int(CancelGoal.Response.ERROR_REJECTED)
        return int(CancelGoal.Response.ERROR_GOAL_TERMINATED)

    def _on_result(self, request: Any, response: Any, header: Any) -> Any:
        goal = self._goals.get(bytes(request.goal_id.uuid))
        if goal is None:
            response.status = GoalStatus.STATUS_UNKNOWN
            reason = self._refused.get(bytes(request.goal_id.uuid), "")
            if reason and hasattr(response.result, "error_msg"):
                response.result.error_msg = reason
            return response
        if goal.response is None:
            goal.asked.append(header)
        return goal.response

    def knows(self, goal_id: bytes) -> bool:
        """Whether a goal has come, be it accepted or refused."""
        return goal_id in self._goals or goal_id in self._refused

    def is_cancelled(self, goal_id: bytes) -> bool:
        """Whether a goal does not go on: it has ended, its client wants that, or it is unknown."""
        goal = self._goals.get(goal_id)
        return goal is None or not goal.is_active or goal.is_cancel_requested

    def refusal_of(self, goal_id: bytes) -> str | None:
        """Return why a goal was refused; None if it was not."""
        return self._refused.get(goal_id)

    # What the brain says

    @property
    def has_listeners(self) -> bool:
        """Whether somebody wants feedback."""
        return bool(self._feedback.get_subscription_count() > 0)

    def publish_feedback(self, goal: GoalHandle, feedback: Any) -> None:
        """Publish feedback on a goal."""
        self._feedback.publish(
            self.kind.Impl.FeedbackMessage(goal_id=goal.info.goal_id, feedback=feedback)
        )

    def finish(self, goal: GoalHandle, result: Any, *, succeeded: bool) -> None:
        """End a goal and send its result; one that has ended already stays as it is.

        Args:
            succeeded: Otherwise it counts as canceled if its client wanted that, else as aborted.
        """
        if not goal.is_active:
            return
        if succeeded:
            goal.status = GoalStatus.STATUS_SUCCEEDED
        elif goal.is_cancel_requested:
            goal.status = GoalStatus.STATUS_CANCELED
        else:
            goal.status = GoalStatus.STATUS_ABORTED
        goal.ended_at = self._now()
        goal.request = None
        goal.response = self.kind.Impl.GetResultService.Response(status=goal.status, result=result)
        while goal.asked:
            self._respond_to_result(goal.response, goal.asked.popleft())
        self._publish_status()

    def _now(self) -> int:
        return int(self._node.get_clock().now().nanoseconds)

    def _forget(self) -> None:
        oldest = self._now() - round(1e9 * RESULT_TIMEOUT)
        old = [key for key, goal in self._goals.items() if not goal.is_active]
        for key in old:
            if self._goals[key].ended_at < oldest:
                del self._goals[key]

    def _publish_status(self) -> None:
        goals = self._goals.values()
        self._status.publish(
            GoalStatusArray(
                status_list=[GoalStatus(goal_info=goal.info, status=goal.status) for goal in goals]
            )
        )
