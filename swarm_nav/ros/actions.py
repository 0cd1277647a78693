"""Action servers that never block: a goal is handed to the brain and its result sent at the end."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from rclpy.action import CancelResponse, GoalResponse
from rclpy.action.server import ServerGoalHandle
from rclpy.node import Node
from rclpy.qos import QoSProfile

from swarm_common.middleware.rclpy_compat import PatientActionServer
from swarm_common.process.last_resort import FaultLog
from swarm_nav.core.goals import Outcome

# Requests wait until the next look, and DDS forgets all but the newest `depth` of them without a
# word: the usual ten are what one client sends at once.
BURST = QoSProfile(depth=2000)
# [s] of the node's clock. Each status message lists all goals whose results are kept; rclpy's own
# 15 min are for clients that ask long after the end.
RESULT_TIMEOUT = 60
FAULTS = FaultLog("request of an action")

Consider = Callable[[Any], bool]
Begin = Callable[["TickActionServer", ServerGoalHandle], None]
Cancel = Callable[[ServerGoalHandle], None]


class TickActionServer(PatientActionServer):
    """Accepts goals at once and ends them with `finish`, between two ticks.

    rclpy runs an execute callback per goal and polls it while it waits. Here nothing runs, and
    the execute callback is never called.
    """

    def __init__(
        self,
        node: Node,
        kind: Any,
        name: str,
        consider: Consider,
        begin: Begin,
        cancel: Cancel,
    ) -> None:
        """Create the server.

        Args:
            node: To create it on.
            kind: Action type.
            name: Relative to the node's namespace.
            consider: Whether to accept a goal request.
            begin: Called with each accepted goal, which is executing then.
            cancel: Called when a client wants a goal canceled; it ends some ticks later.
        """
        self.kind = kind
        self._begin = begin
        self._feedback_topic = f"{name}/_action/feedback"

        def on_goal(request: Any) -> GoalResponse:
            return GoalResponse.ACCEPT if consider(request) else GoalResponse.REJECT

        def on_cancel(handle: ServerGoalHandle) -> CancelResponse:
            cancel(handle)
            return CancelResponse.ACCEPT

        super().__init__(
            node,
            kind,
            name,
            execute_callback=lambda _: kind.Result(),
            goal_callback=on_goal,
            cancel_callback=on_cancel,
            goal_service_qos_profile=BURST,
            result_service_qos_profile=BURST,
            cancel_service_qos_profile=BURST,
            result_timeout=RESULT_TIMEOUT,
        )

    def notify_execute(self, goal_handle: ServerGoalHandle, execute_callback: Any) -> None:
        """Begin the goal instead of running a callback for it."""
        del execute_callback
        self._begin(self, goal_handle)

    async def execute(self, taken_data: Any) -> None:
        """Do what was asked for; rclpy's executor ends the process if this raises."""
        try:
            await super().execute(taken_data)
        except Exception as error:
            FAULTS.note(error)

    @property
    def has_listeners(self) -> bool:
        """Whether somebody wants feedback."""
        return self.count_subscribers(self._feedback_topic) > 0

    def finish(self, handle: ServerGoalHandle, outcome: Outcome, result: Any) -> None:
        """End a goal and send its result."""
        if not handle.is_active:
            return
        if outcome is Outcome.SUCCEEDED:
            handle.succeed()
        elif handle.is_cancel_requested:
            handle.canceled()
        else:
            handle.abort()
        response = self.kind.Impl.GetResultService.Response()
        response.status, response.result = handle.status, result
        self.answer(bytes(handle.goal_id.uuid), response)
