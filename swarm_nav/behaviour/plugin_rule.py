"""A rule that a user brings, asked among the built-in ones."""

from __future__ import annotations

import dataclasses

import numpy as np

from swarm_common.model.records import FloatArray, Pose, RobotSpec
from swarm_common.process.plugins import PluginError
from swarm_nav.core.plugins import RULE, Report
from swarm_nav.interfaces import OtherRobot, Proposal, RuleState
from swarm_nav.traffic.arbiter import STAND
from swarm_nav.traffic.robot_state import RobotView

MOST_GAP = 0.5  # [m] of a path's first point from the stop point


class PluginRule:
    """Shows the plug-in a copy of the robot's state, and checks what it proposes."""

    def __init__(self, name: str, spec: RobotSpec, report: Report) -> None:
        """Make the plug-in.

        Args:
            report: Receives faults; the robot stands meanwhile.

        Raises:
            ConfigError: If it is missing.
        """
        self._own = RULE.guard(name, spec)
        self._report = report

    def propose(self, robot: RobotView) -> Proposal | None:
        """Return the plug-in's proposal; a robot whose rule fails stands."""
        try:
            return self._checked(self._own.call("propose", state_of(robot)), robot)
        except PluginError as error:
            self._report(RULE.codes[error.fault], str(error))
            return STAND

    def _checked(self, found: object, robot: RobotView) -> Proposal | None:
        if found is None:
            return None
        if not isinstance(found, Proposal):
            raise self._own.unusable(f"propose returned {found!r}; expected a Proposal or None")
        counts = [count for count in (found.keep_until, found.keep_ahead) if count is not None]
        if not all(isinstance(count, int) and count >= 0 for count in counts):
            raise self._own.unusable("keep_until and keep_ahead must be None, or int from 0 on")
        numbers = [found.most_speed, found.most_rate, *([] if found.yaw is None else [found.yaw])]
        if np.isnan(np.asarray(numbers, np.float64)).any() or np.isinf(found.yaw or 0.0):
            raise self._own.unusable("yaw, most_speed and most_rate must be numbers")
        if found.events:
            raise self._own.unusable("events are for built-in rules")
        if not isinstance(found.why, str):
            raise self._own.unusable("why must be a str")
        if found.path is None:
            return found
        return dataclasses.replace(found, path=self._path(found.path, robot))

    def _path(self, path: object, robot: RobotView) -> FloatArray:
        """Return a path from the stop point with points as close as those of plans."""
        try:
            points = np.array(path, np.float64)
        except (TypeError, ValueError):
            points = np.full(1, np.nan)
        if points.ndim != 2 or points.shape[1:] != (2,) or len(points) < 2:
            raise self._own.unusable("path must be None, or two or more points (n, 2)")
        contains = robot.terrain.grid.contains
        if not (np.isfinite(points).all() and all(contains(x, y) for x, y in points.tolist())):
            raise self._own.unusable("path has points that are off the map")
        start, end = robot.stop_point, (float(points[-1, 0]), float(points[-1, 1]))
        if np.hypot(*(points[0] - start)) > MOST_GAP:
            raise self._own.unusable("path must begin at state.stop_point_map")
        return robot.planner.finish(points, start, end, robot.planner.no_extra(), False)


def state_of(robot: RobotView) -> RuleState:
    """Return the state that a rule may read: a copy, so that a change of it has no effect."""
    tube, neighbors = robot.tube, robot.neighbors
    heads = neighbors.heads
    others = tuple(
        OtherRobot(
            int(neighbors.ids[row]),
            Pose(*(float(value) for value in heads["pose"][row])),
            neighbors.radius(row),
            int(neighbors.priorities[row]),
            int(heads["blocked_by"][row]),
        )
        for row in np.flatnonzero(~neighbors.gone).tolist()
    )
    return RuleState(
        robot.robot_id, robot.tick, robot.pose, robot.velocity, robot.radius, robot.priority,
        robot.stop_point, tube.points[tube.near :].copy(), tube.stop - tube.near + 1,
        robot.blocked_by, robot.blocked_ticks, robot.obstacle_ticks, others,
    )  # fmt: skip
