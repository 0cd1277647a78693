"""A path that the operator gave (FollowPath): how far the robot is on it, and the way along it."""

from __future__ import annotations

import numpy as np

from swarm_common.model.records import FloatArray
from swarm_nav.core.goals import ErrorCode, PlanError
from swarm_nav.planning.planner import path_length
from swarm_nav.traffic import traffic_costs
from swarm_nav.traffic.robot_state import RobotView

JOINED = 0.1  # [m] from the path within which it is taken up without a plan
LAST_PIECE = 0.5  # [m] before the end from where the goal may count as reached
LOOK_AHEAD = 0.5  # [m] of path beyond a nearest point in which a nearer one is looked for


class GivenPath:
    """Points in map with the index of the robot on them; never goes back to an earlier one."""

    def __init__(self, points: FloatArray) -> None:
        """Start at the first point.

        Args:
            points: (n, 2) [m] in map, n > 0.
        """
        self.points = np.ascontiguousarray(points, np.float64)
        self.index = 0
        steps = np.hypot(*np.diff(self.points, axis=0).T) if len(self.points) > 1 else np.zeros(0)
        self._lengths: FloatArray = np.concatenate((np.zeros(1), np.cumsum(steps)))

    @property
    def is_at_end(self) -> bool:
        """Whether only the last piece is left; a closed path starts where it ends."""
        return path_length(self.points[self.index :]) < LAST_PIECE

    def advance(self, x: float, y: float) -> None:
        """Move the index on to the point nearest to the robot.

        Args:
            x: [m] of the robot, in map.
            y: [m] of the robot, in map.
        """
        self.index = self._nearest(self.index, x, y)

    def way(self, robot: RobotView, start: tuple[float, float]) -> FloatArray:
        """Return the path (n, 2) from a place back to the given one and along its rest.

        Args:
            start: (x, y) [m] in map.

        Raises:
            PlanError: If the given path comes too near to a wall, or there is no way to it.
        """
        index = self._nearest(self.index, robot.pose.x, robot.pose.y)
        rest = self.points[self._nearest(index, *start) :]
        planner = robot.planner
        joint = np.array((start,))
        if np.hypot(*(rest[0] - start)) > JOINED:
            joint = planner.plan(start, (rest[0, 0], rest[0, 1]), traffic_costs.congestion(robot))
        end = (float(rest[-1, 0]), float(rest[-1, 1]))
        path = planner.finish(np.vstack((joint, rest)), start, end, planner.no_extra(), False)
        self._check(path, robot, start)
        return path

    def _nearest(self, index: int, x: float, y: float) -> int:
        """Return the point from an index on to which none shortly after it is nearer.

        The path may pass the same place again much later; at a cusp it does so at once.
        """
        gaps = np.hypot(*(self.points[index:] - (x, y)).T)
        k = 0
        while True:
            start = self._lengths[index + k]
            end = int(np.searchsorted(self._lengths, start + LOOK_AHEAD, "right")) - index
            ahead = gaps[k : max(end, k + 2)]
            step = int(ahead[::-1].argmin())  # of equally near points the last one
            step = len(ahead) - 1 - step
            if step == 0:
                return index + k
            k += step

    @staticmethod
    def _check(path: FloatArray, robot: RobotView, start: tuple[float, float]) -> None:
        terrain, room = robot.terrain, robot.body_radius
        clear = terrain.clearances(np.vstack((np.array([start]), path)), room)
        floor = min(room, clear[0])
        for (x, y), gap in zip(path.tolist(), clear[1:].tolist(), strict=True):
            if not terrain.grid.contains(x, y) or gap < floor - 1e-6:
                what = "leads into a keepout zone" if terrain.is_in_keepout(x, y, room) else ""
                raise PlanError(
                    ErrorCode.NO_VALID_CONTROL,
                    f"the given path {what or 'touches a wall'} at ({x:.2f}, {y:.2f}); the robot"
                    f" needs {room:.2f} m",
                )
