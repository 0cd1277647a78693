"""Nav2's planning actions on the node: a leg at a time, so that no plan keeps a tick waiting."""

from __future__ import annotations

import time
from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import partial
from typing import Any

import numpy as np
from geometry_msgs.msg import PoseStamped
from nav2_msgs.action import ComputePathThroughPoses, ComputePathToPose, SmoothPath

from swarm_common.middleware.rejections import RejectedError
from swarm_common.middleware.ros_io import path_msg, pose_msg
from swarm_common.middleware.tick_action import GoalHandle, TickActionServer
from swarm_common.model.records import FloatArray, Pose
from swarm_nav.core.goals import ErrorCode, Outcome, PlanError
from swarm_nav.interfaces import Services
from swarm_nav.ros.nav2.demand import OnDemand
from swarm_nav.ros.nav2.goals import (
    CLIENT,
    NOT_ACTIVE,
    check_count,
    duration_msg,
    path_goal,
    plan_error_code,
)
from swarm_nav.ros.nav2.map_bounds import OffMapError
from swarm_nav.ros.nav2.served_node import ServedNode

SMOOTHERS = "", "simple_smoother"  # ids that name the one there is
MOST_LEGS = 1000  # of one plan
MOST_WAITING = 100  # plans; further ones are refused
PORTION = 0.05  # [s] of wall time for plans between two ticks, and the current leg


@dataclass(slots=True)
class Job:
    """A plan that was asked for."""

    name: str  # of the action
    server: TickActionServer
    handle: GoalHandle  # of the goal
    goals: Sequence[PoseStamped]  # of the request
    stops: list[Pose]  # poses in map that it goes through, the start first
    started: float
    # path (n, 2) of each leg that is planned
    pieces: list[FloatArray] = field(default_factory=list)

    @property
    def is_through(self) -> bool:
        """Whether its action is compute_path_through_poses."""
        return self.server.kind is ComputePathThroughPoses


class Plans:
    """The servers of both actions, and the plans that wait."""

    def __init__(self, body: ServedNode, services: Services, on_demand: OnDemand) -> None:
        """Offer the servers; none is created yet."""
        self._body = body
        self._services = services
        self._tick = 0
        self._waiting: deque[Job] = deque()
        for action, name in (
            (ComputePathToPose, "compute_path_to_pose"),
            (ComputePathThroughPoses, "compute_path_through_poses"),
        ):
            on_demand.offer_actions([name], partial(self._serve, action, name))
        on_demand.offer_actions(["smooth_path"], self._serve_smoothing, is_rare=True)

    def _serve(self, action: Any, name: str) -> None:
        def has_room(_: Any) -> bool:
            if len(self._waiting) >= MOST_WAITING:
                error = RejectedError(f"{MOST_WAITING} plans wait already")
                self._body.rejections.reject(name, CLIENT, error)
                raise error
            if not self._body.lifecycle.is_active:
                raise RejectedError(NOT_ACTIVE)
            return True

        def begin(server: TickActionServer, handle: GoalHandle) -> None:
            """Queue the plan, or end the goal at once if it makes no sense."""
            request = handle.request
            goals = request.goals if action is ComputePathThroughPoses else [request.goal]
            job = Job(name, server, handle, goals, [], time.perf_counter())
            try:
                if not goals:
                    raise PlanError(ErrorCode.NO_VIAPOINTS_GIVEN, "no goals given")
                check_count(goals, MOST_LEGS)
                start = self._start(request)
                job.stops = [start, *(self._body.to_map(goal) for goal in goals)]
            except (PlanError, ValueError) as error:
                self._fail(job, error)
                return
            self._waiting.append(job)

        TickActionServer(self._body.node, action, name, has_room, begin, lambda _: None)

    def _start(self, request: Any) -> Pose:
        if not request.use_start:
            return self._services.pose_map
        try:
            return self._body.to_map(request.start)
        except OffMapError as error:
            error.code = ErrorCode.START_OUTSIDE_MAP
            raise

    def _serve_smoothing(self) -> None:
        def begin(server: TickActionServer, handle: GoalHandle) -> None:
            """Smooth the path, and end the goal with it."""
            started = time.perf_counter()
            result = SmoothPath.Result()
            try:
                goal, path = self._smoothed(handle.request)
                result.path = path_msg(path, self._tick)
                result.path.poses[-1].pose.orientation = pose_msg(goal).orientation
                result.was_completed = True
            except PlanError as error:
                result.error_code, result.error_msg = int(error.code), str(error)
            except ValueError as error:
                self._body.rejections.reject("smooth_path", CLIENT, error)
                result.error_code, result.error_msg = int(ErrorCode.SMOOTH_BAD_PATH), str(error)
            result.smoothing_duration = duration_msg(time.perf_counter() - started)
            server.finish(handle, result, succeeded=result.was_completed)

        def is_open(_: Any) -> bool:
            return self._body.lifecycle.is_active

        TickActionServer(self._body.node, SmoothPath, "smooth_path", is_open, begin, lambda _: None)

    def _smoothed(self, request: Any) -> tuple[Pose, FloatArray]:
        """Return the last pose of a path, in map, and the path when it is smooth."""
        if request.smoother_id not in SMOOTHERS:
            raise PlanError(
                ErrorCode.SMOOTH_BAD_ID,
                f"there is no smoother '{request.smoother_id}'; expected {SMOOTHERS[1]}",
            )
        goal = path_goal(0, request, self._body.to_map, self._body.map_bounds)
        if len(goal.path_map) < 2:
            raise PlanError(ErrorCode.SMOOTH_BAD_PATH, "the path has fewer than two poses")
        path = self._services.smooth(goal.path_map)
        if request.check_for_collisions and not self._services.is_clear(path):
            raise PlanError(ErrorCode.SMOOTH_COLLISION, "the smoothed path is too near to a wall")
        return goal.poses_map[-1], path

    def look(self, tick: int) -> None:
        """Plan some of the legs that wait, at most for a while."""
        self._tick = tick
        end = time.perf_counter() + PORTION
        while self._waiting and time.perf_counter() < end:
            job = self._waiting[0]
            leg = len(job.pieces)
            is_unwanted = job.handle.is_cancel_requested
            if not is_unwanted and leg < len(job.goals):
                try:
                    piece = self._services.make_plan(job.stops[leg], [job.stops[leg + 1]])
                except (PlanError, ValueError) as error:
                    self._waiting.popleft()
                    self._fail(job, error)
                    continue
                job.pieces.append(piece if leg == 0 else piece[1:])
            if is_unwanted or len(job.pieces) == len(job.goals):
                self._waiting.popleft()
                self._finish(job, tick)

    def _fail(self, job: Job, error: PlanError | ValueError) -> None:
        if isinstance(error, RejectedError):
            self._body.rejections.reject(job.name, CLIENT, error)
        result = job.server.kind.Result()
        result.error_code, result.error_msg = plan_error_code(error, job.is_through), str(error)
        self._send(job, Outcome.ABORTED, result)

    def _finish(self, job: Job, tick: int) -> None:
        result = job.server.kind.Result()
        if job.handle.is_cancel_requested:
            self._send(job, Outcome.CANCELED, result)
            return
        result.path = path_msg(np.vstack(job.pieces), tick)
        if result.path.poses:
            result.path.poses[-1].pose.orientation = pose_msg(job.stops[-1]).orientation
        self._send(job, Outcome.SUCCEEDED, result)

    def _send(self, job: Job, outcome: Outcome, result: Any) -> None:
        result.planning_time = duration_msg(time.perf_counter() - job.started)
        job.server.finish(job.handle, result, succeeded=outcome is Outcome.SUCCEEDED)
