"""Nav2's navigation actions and goal_pose on the node: requests in, feedback and results out."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

from geometry_msgs.msg import PoseStamped
from rclpy.node import Node

from swarm_common.middleware.rejections import Rejections
from swarm_common.middleware.ros_io import RELIABLE, unpacked
from swarm_nav.behaviour.navigator import Navigator
from swarm_nav.core.goals import Goal, GoalEnded, GoalKind
from swarm_nav.ros.actions import GoalHandle, TickActionServer
from swarm_nav.ros.demand import OnDemand
from swarm_nav.ros.goals import (
    ACTIONS,
    CLIENT,
    ToMap,
    feedback_msg,
    goal_from_request,
    pose_goal,
    result_msg,
    start_tick,
)
from swarm_nav.ros.reach import Reach

FEEDBACK_TICKS = 5
LISTENER_TICKS = 20  # between two looks for who wants feedback; the graph is slow to ask


@dataclass(slots=True)
class Running:
    """An action goal that the brain has not ended yet."""

    server: TickActionServer
    handle: GoalHandle
    goal: Goal
    started_tick: int = 0
    has_listeners: bool = False


class Tasks:
    """All action servers of one navigator."""

    def __init__(
        self,
        node: Node,
        brain: Navigator,
        to_map: ToMap,
        reach: Callable[[], Reach],
        rejections: Rejections,
        is_open: Callable[[], bool],
        on_goal: Callable[[], None],
        on_demand: OnDemand,
    ) -> None:
        """Create the servers.

        Args:
            node: To create them on.
            brain: Takes the goals.
            to_map: Brings a pose of any known frame to map.
            reach: Returns that of the map at hand.
            rejections: Counts what is refused.
            is_open: Whether goals are accepted now (lifecycle).
            on_goal: Called after the brain has got a goal.
            on_demand: Takes the servers that few clients ask for.
        """
        self._node = node
        self._brain = brain
        self._to_map = to_map
        self._reach = reach
        self._rejections = rejections
        self._is_open = is_open
        self._on_goal = on_goal
        self._running: dict[int, Running] = {}
        self._last_id = 0
        self._tick = 0
        self._serve(GoalKind.NAVIGATE, ACTIONS[GoalKind.NAVIGATE])
        for kind, action in ACTIONS.items():
            if kind is not GoalKind.NAVIGATE:
                on_demand.offer_action(kind.value, partial(self._serve, kind, action))
        node.create_subscription(PoseStamped, "goal_pose", self._take_goal_pose, RELIABLE, raw=True)

    def _serve(self, kind: GoalKind, action: Any) -> None:
        def is_sensible(request: Any) -> bool:
            return self._is_open() and self._parse(kind, request) is not None

        def begin(server: TickActionServer, handle: GoalHandle) -> None:
            goal = self._parse(kind, handle.request)
            assert goal is not None  # accepted a moment ago
            self._last_id = goal.goal_id
            self._running[goal.goal_id] = Running(server, handle, goal, self._tick)
            self._start(goal)

        TickActionServer(self._node, action, kind.value, is_sensible, begin, self._cancel)

    def _parse(self, kind: GoalKind, request: Any) -> Goal | None:
        try:
            number, reach = self._last_id + 1, self._reach()
            return goal_from_request(kind, number, request, self._to_map, reach)
        except ValueError as error:
            self._rejections.reject(kind.value, CLIENT, error)
            return None

    def _start(self, goal: Goal) -> None:
        # Also the first goal begins one tick later, whether it came before tick 0 or after it.
        begins = start_tick(goal, self._tick)
        self._brain.set_goal(dataclasses.replace(goal, start_tick=begins))
        self._on_goal()

    def _take_goal_pose(self, data: bytes) -> None:
        try:
            goal = pose_goal(self._last_id + 1, unpacked(data, PoseStamped), self._to_map)
        except ValueError as error:
            self._rejections.reject("goal_pose", CLIENT, error)
            return
        if self._is_open():
            self._last_id = goal.goal_id
            self._start(goal)

    def _cancel(self, handle: GoalHandle) -> None:
        for goal_id, running in self._running.items():
            if running.handle == handle and self._brain.goal_id == goal_id:
                self._brain.cancel_goal()

    def report(self, tick: int, ended: Sequence[GoalEnded]) -> None:
        """Send the results of the goals that ended at this tick, and feedback now and then."""
        self._tick = tick
        for event in ended:
            running = self._running.pop(event.goal_id, None)
            if running is not None:
                result = result_msg(running.goal, event, running.started_tick)
                running.server.finish(running.handle, event.outcome, result)
        running = self._running.get(self._brain.goal_id or 0)
        if running is not None and (tick - running.started_tick) % FEEDBACK_TICKS == 0:
            self._send_feedback(running, tick)

    def _send_feedback(self, running: Running, tick: int) -> None:
        if (tick - running.started_tick) % LISTENER_TICKS == FEEDBACK_TICKS:
            running.has_listeners = running.server.has_listeners
        feedback = self._brain.feedback() if running.has_listeners else None
        if feedback is not None:
            message = feedback_msg(running.goal, feedback, running.started_tick, tick)
            running.server.publish_feedback(running.handle, message)
