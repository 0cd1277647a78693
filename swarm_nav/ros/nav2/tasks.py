"""Nav2's navigation actions and goal_pose on the node: requests in, feedback and results out."""

from __future__ import annotations

import dataclasses
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

from geometry_msgs.msg import PoseStamped, Twist
from nav2_msgs.action import DockRobot, FollowGPSWaypoints, UndockRobot
from std_msgs.msg import Empty

from swarm_common.middleware.courier_io import EndedGoal
from swarm_common.middleware.rejections import RejectedError
from swarm_common.middleware.ros_io import RELIABLE, unpacked
from swarm_common.middleware.tick_action import GoalHandle, TickActionServer
from swarm_common.model.records import CONTROL_PERIOD
from swarm_nav.core.goals import Goal, GoalEnded, GoalKind, Outcome
from swarm_nav.interfaces import RobotBrain
from swarm_nav.ros.nav2.demand import OnDemand
from swarm_nav.ros.nav2.goals import (
    ACTIONS,
    CLIENT,
    NOT_ACTIVE,
    feedback_msg,
    goal_from_request,
    pose_goal,
    result_msg,
    start_tick,
    twist_from_msg,
)
from swarm_nav.ros.nav2.served_node import ServedNode

FEEDBACK_TICKS = 5
# Served in this order: driveOnHeading of nav2_simple_commander waits for the server of backup
# instead of its own, and what is sent to a server that is not there yet is lost.
TOGETHER = (GoalKind.DRIVE_ON_HEADING, GoalKind.BACKUP)
# Actions that are not offered: Nav2's error code and why.
UNSUPPORTED = {
    "dock_robot": (DockRobot, DockRobot.Result.DOCK_NOT_IN_DB, "there are no docks"),
    "undock_robot": (UndockRobot, UndockRobot.Result.DOCK_NOT_VALID, "there are no docks"),
    "follow_gps_waypoints": (
        FollowGPSWaypoints,
        FollowGPSWaypoints.Result.UNKNOWN,
        "the map has no geographic coordinates",
    ),
}
LONG_WAIT = 50  # ticks of delay from which a goal's start is worth a line in the log
STEER_LIMIT = 20.0  # [s] of both clocks after which a robot that nobody steers takes itself back
LISTENER_TICKS = 20  # between two searches for listeners to feedback; asking the graph is slow


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
        self, body: ServedNode, brain: RobotBrain, on_goal: Callable[[], None], on_demand: OnDemand
    ) -> None:
        """Create the server of navigate_to_pose, and offer the others.

        Args:
            on_goal: Called after the brain has got a goal.
        """
        self._body = body
        self._node = body.node
        self._brain, self._services = brain, brain.services
        self._on_goal = on_goal
        self._servers: list[TickActionServer] = []
        self._running: dict[int, Running] = {}
        self._last_id = 0
        self._tick = 0
        self._steered_at, self._steered_tick = 0.0, 0  # wall time and tick of the last wish
        self._serve(GoalKind.NAVIGATE)
        single = [(kind,) for kind in ACTIONS if kind not in (GoalKind.NAVIGATE, *TOGETHER)]
        for kinds in (*single, TOGETHER):
            names = [kind.value for kind in kinds]
            is_rare = GoalKind.TELEOP in kinds
            on_demand.offer_actions(names, partial(self._serve, *kinds), is_rare=is_rare)
        for name, (action, code, reason) in UNSUPPORTED.items():
            refuse = partial(self._refuse, action, name, code, reason)
            on_demand.offer_actions([name], refuse, is_rare=True)
        make = self._node.create_subscription
        make(PoseStamped, "goal_pose", self._receive_goal_pose, RELIABLE, raw=True)

    def _refuse(self, action: Any, name: str, code: int, reason: str) -> None:
        """Offer an action whose goals fail at once; without a server clients wait for ever."""
        result = action.Result(error_code=code, error_msg=reason)
        if hasattr(result, "success"):
            result.success = False

        def end(server: TickActionServer, handle: GoalHandle) -> None:
            """End a goal at once."""
            server.finish(handle, result, succeeded=False)

        TickActionServer(self._node, action, name, lambda _: True, end, lambda _: None)

    def _serve(self, *kinds: GoalKind) -> None:
        for kind in kinds:
            self._serve_one(kind)

    def _serve_one(self, kind: GoalKind) -> None:
        if kind is GoalKind.TELEOP:
            make = self._node.create_subscription
            make(Twist, "cmd_vel_teleop", self._steer, RELIABLE, raw=True)
            make(Empty, "preempt_teleop", self._end_teleop, RELIABLE)

        def is_sensible(request: Any) -> bool:
            """Return True; a request that makes no sense raises.

            Raises:
                RejectedError: If it does not, or the navigator is not active.
            """
            if not self._body.lifecycle.is_active:
                raise RejectedError(NOT_ACTIVE)
            self._parse(kind, request)
            return True

        def begin(server: TickActionServer, handle: GoalHandle) -> None:
            """Give the goal to the brain."""
            goal = self._parse(kind, handle.request)
            self._last_id = goal.goal_id
            self._steered_at, self._steered_tick = time.monotonic(), self._tick
            self._running[goal.goal_id] = Running(server, handle, goal, self._tick)
            self._start(goal)

        self._servers.append(
            TickActionServer(
                self._node, ACTIONS[kind], kind.value, is_sensible, begin, self._cancel
            )
        )

    def _parse(self, kind: GoalKind, request: Any) -> Goal:
        try:
            body, number = self._body, self._last_id + 1
            goal = goal_from_request(kind, number, request, body.to_map, body.map_bounds)
            # Also the first goal begins one tick later, whether it came before tick 0 or after it.
            return dataclasses.replace(goal, start_tick=start_tick(goal, self._tick))
        except ValueError as error:
            self._body.rejections.reject(kind.value, CLIENT, error)
            raise RejectedError(str(error)) from error

    def _start(self, goal: Goal) -> None:
        if (wait := goal.start_tick - self._tick) > LONG_WAIT:
            log = self._node.get_logger().info
            log(f"{goal.kind.value}: begins in {wait * CONTROL_PERIOD:.1f} s, as it was asked to")
        self._brain.set_goal(goal)
        self._on_goal()

    def _receive_goal_pose(self, data: bytes) -> None:
        try:
            goal = pose_goal(self._last_id + 1, unpacked(data, PoseStamped), self._body.to_map)
            goal = dataclasses.replace(goal, start_tick=self._tick + 1)
        except ValueError as error:
            self._body.rejections.reject("goal_pose", CLIENT, error)
            return
        if self._body.lifecycle.is_active:
            self._last_id = goal.goal_id
            self._start(goal)

    def _steer(self, data: bytes) -> None:
        try:
            twist = twist_from_msg(unpacked(data, Twist))
        except ValueError as error:
            self._body.rejections.reject("cmd_vel_teleop", CLIENT, error)
            return
        self._steered_at, self._steered_tick = time.monotonic(), self._tick
        self._services.steer(twist)

    def _end_teleop(self, _: Empty) -> None:
        self._services.end_teleop()

    def _cancel(self, handle: GoalHandle) -> None:
        for goal_id, running in self._running.items():
            if running.handle == handle and self._services.goal_id == goal_id:
                self._services.cancel_goal()

    @property
    def goal(self) -> bytes:
        """Id of the current or pending goal of an action; empty without one."""
        running = self._running.get(self._services.goal_id or 0)
        return b"" if running is None else _id_of(running)

    def knows(self, goal_id: bytes) -> bool:
        """Whether a goal has come, be it accepted or refused."""
        return any(server.knows(goal_id) for server in self._servers)

    def is_cancelled(self, goal_id: bytes) -> bool:
        """Whether a goal has ended, or its client wants that."""
        return all(server.is_cancelled(goal_id) for server in self._servers)

    def refusal_of(self, goal_id: bytes) -> str | None:
        """Return why a goal was refused; None if it was not."""
        reasons = (server.refusal_of(goal_id) for server in self._servers)
        return next((reason for reason in reasons if reason is not None), None)

    def ended_of(self, ended: Sequence[GoalEnded]) -> list[EndedGoal]:
        """Return which goals of actions have ended and how; call it before `report`."""
        found = [(event, self._running.get(event.goal_id)) for event in ended]
        return [
            EndedGoal(
                _id_of(running),
                event.outcome is Outcome.SUCCEEDED,
                f"error {int(event.error_code)}: {event.message}",
                int(event.error_code),
            )
            for event, running in found
            if running is not None
        ]

    def report(self, tick: int, ended: Sequence[GoalEnded]) -> None:
        """Send the results of the goals that ended at this tick, and feedback from time to time.

        Args:
            ended: Goals of any origin; those that no action asked for have no client to tell.
        """
        self._tick = tick
        for event in ended:
            running = self._running.pop(event.goal_id, None)
            if running is not None:
                result = result_msg(
                    running.goal, event, running.started_tick, running.handle.is_cancel_requested
                )
                reached = event.outcome is Outcome.SUCCEEDED
                running.server.finish(running.handle, result, succeeded=reached)
        running = self._running.get(self._services.goal_id or 0)
        if running is not None and running.goal.kind is GoalKind.TELEOP:
            self._reclaim_if_left(running.goal)
        if running is not None and (tick - running.started_tick) % FEEDBACK_TICKS == 0:
            self._send_feedback(running, tick)

    def _reclaim_if_left(self, goal: Goal) -> None:
        """End an assisted teleoperation without a time allowance whose client is gone.

        Clients that steer say so all the time, also that the robot is to stand.
        """
        passed = (self._tick - self._steered_tick) * CONTROL_PERIOD
        if goal.duration <= 0.0 and min(passed, time.monotonic() - self._steered_at) > STEER_LIMIT:
            self._services.end_teleop(f"nobody has steered it for {STEER_LIMIT:.0f} s")

    def _send_feedback(self, running: Running, tick: int) -> None:
        if (tick - running.started_tick) % LISTENER_TICKS == FEEDBACK_TICKS:
            running.has_listeners = running.server.has_listeners
        feedback = self._services.feedback() if running.has_listeners else None
        if feedback is not None:
            message = feedback_msg(running.goal, feedback, running.started_tick, tick)
            running.server.publish_feedback(running.handle, message)


def _id_of(running: Running) -> bytes:
    return bytes(running.handle.info.goal_id.uuid)
