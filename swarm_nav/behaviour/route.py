"""The route to the current target: when it is replanned, and where the new one starts."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from swarm_common.model.records import FloatArray
from swarm_nav.behaviour.goal_progress import GoalProgress
from swarm_nav.core.goals import ErrorCode, PlanError
from swarm_nav.interfaces import Proposal, RuleEvent, RuleEventKind
from swarm_nav.traffic import traffic_costs
from swarm_nav.traffic.arbiter import planned
from swarm_nav.traffic.lease import SAME_STATION
from swarm_nav.traffic.robot_state import RobotView

KEEP_COST = 0.8  # [m] that a new path must save
BARRED_PATIENCE = 10.0  # [s] of waiting in vain after which the place ahead costs more
BARRED_TIME = 60.0  # [s] for which it costs more
BARRED_RADIUS = 0.3  # [m] of the place
BARRED_AHEAD = 7  # points of the path from the robot to the place, which leaves the robot outside
FATAL = (ErrorCode.GOAL_OCCUPIED, ErrorCode.GOAL_OUTSIDE_MAP, ErrorCode.NO_VALID_CONTROL)


class Route:
    """Plans the way to the target.

    Attributes:
        last_plan_tick: Tick of the last plan.
    """

    def __init__(self, robot: RobotView) -> None:
        self._s = robot
        self.last_plan_tick = -1000
        self._barred: list[tuple[int, float, float]] = []  # tick and place [m] in map

    def propose(self, task: GoalProgress) -> Proposal | None:
        """Return a plan if it is due, or that the target has no way."""
        return self._plan(task) if self._is_due(task) else None

    def _is_due(self, task: GoalProgress) -> bool:
        s = self._s
        since = s.tick - self.last_plan_tick
        if not task.is_planned or self._is_period_over(task, since):
            return True
        retry = s.retry_ticks
        if since < retry:  # a shorter request is never granted
            return False
        gap = math.dist(s.stop_point, task.place)
        ends_short = s.tube.is_complete and gap > 0.6 * s.config.goal_checker.xy_goal_tolerance
        return ends_short or s.waited_ticks >= retry

    def _is_period_over(self, task: GoalProgress, since: int) -> bool:
        """Whether a periodic plan is due; robots take turns, a given path is not replanned."""
        period = self._s.ticks(self._s.config.planner.replan_period)
        is_turn = (self._s.tick + 7 * self._s.robot_id) % period == 0
        return task.given is None and since >= period and is_turn

    def _plan(self, task: GoalProgress) -> Proposal | None:
        s = self._s
        self.last_plan_tick = s.tick
        try:
            extra = traffic_costs.congestion(s)
            self._stamp_barred(extra)
            path = self._path_to(task, s.stop_point, extra)
            if self._keeps(task, path, extra):
                return None
            here = s.stop_point
            found = planned(
                s, lambda start: path if start == here else self._path_to(task, start, extra)
            )
        except PlanError as error:
            is_final = error.is_final or error.code in FATAL
            event = RuleEvent(RuleEventKind.NO_WAY, error.code, str(error), is_final)
            return Proposal(events=(event,), is_final=False)
        assert found is not None
        assert found.path is not None
        x, y = found.path[-1].tolist() if len(found.path) else (math.nan, math.nan)
        end = RuleEvent(RuleEventKind.PLANNED, place_map=None if math.isnan(x) else (x, y))
        return replace(found, events=(end,), is_final=False)

    def _stamp_barred(self, extra: NDArray[np.float32]) -> None:
        """Raise the cost of ways on which the robot waited in vain; the longer it waited, the more.

        So it tries another way in the end, and may see from there that this one is free. Nobody
        knows exactly where a silent robot stands: what can be seen of it depends on the place.
        """
        s = self._s
        if s.unproductive_ticks >= s.ticks(BARRED_PATIENCE):
            ahead = min(s.tube.stop + BARRED_AHEAD, len(s.tube.points) - 1)
            x, y = s.tube.points[ahead].tolist()
            self._barred.append((s.tick, x, y))
        oldest = s.tick - s.ticks(BARRED_TIME)
        self._barred = [item for item in self._barred if item[0] > oldest]
        places = np.array(self._barred).reshape(-1, 3)[:, 1:]
        cost = traffic_costs.BARRED * len(places)
        traffic_costs.stamp(extra, s, places, BARRED_RADIUS, cost)

    def _path_to(
        self, task: GoalProgress, start: tuple[float, float], extra: NDArray[np.float32]
    ) -> FloatArray:
        s = self._s
        if task.given is not None:
            return task.given.way(s, start)
        target = task.target
        place = (target.x, target.y)
        is_station = any(math.dist(place, station) < SAME_STATION for station in s.stations)
        yaw = target.yaw if is_station and not task.is_passing else math.nan
        return s.planner.plan(start, place, extra, yaw)

    def _keeps(self, task: GoalProgress, path: FloatArray, extra: NDArray[np.float32]) -> bool:
        """Whether the current path is as good as a new one; changes cost turns and reservations."""
        s = self._s
        rest = s.tube.points[s.tube.stop :]
        if not task.is_planned or task.given is not None or len(rest) < 2:
            return False
        if math.dist(rest[-1], task.place) > 0.5 * s.config.goal_checker.xy_goal_tolerance:
            return False
        saved = s.planner.cost_of(rest, extra) - s.planner.cost_of(path, extra)
        return saved < KEEP_COST
