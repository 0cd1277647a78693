"""Rules that give up held space: to a tube that is too near, before an obstacle, or unused."""

from __future__ import annotations

import numpy as np

from swarm_nav.interfaces import Proposal, RuleEvent, RuleEventKind
from swarm_nav.reservation import tube_kernels
from swarm_nav.traffic.robot_state import RobotView

OVERLAP_SLACK = 0.06  # [m] by which tubes may be nearer than both radii
WATCHDOG_MOTION = 0.06  # [m]
UNUSED = Proposal(events=(RuleEvent(RuleEventKind.UNUSED),), holds_place=True, is_final=False)


class KeepApart:
    """Gives up points that are too near to another tube.

    They are if a radius has grown (localisation), and where robots that did not hear each other
    have taken space before a thing that only their LiDARs saw.
    """

    def propose(self, robot: RobotView) -> Proposal | None:
        """Keep what lies before the first point that is too near."""
        tube = robot.tube
        first = tube_kernels.first_overlap(
            tube.points, tube.near, tube.stop, robot.radius, OVERLAP_SLACK,
            robot.neighbors.claims(),
        )  # fmt: skip
        return None if first > tube.stop else Proposal(keep_until=first - 1, is_final=False)


class StopBeforeObstacle:
    """Gives up held space before anything that the LiDAR sees in it."""

    def propose(self, robot: RobotView) -> Proposal | None:
        """Keep what lies before the first point that is too near to a hit, and nearer than now."""
        tube = robot.tube
        points = robot.obstacle_points()
        if len(points) == 0:
            return None
        held = tube.points[tube.near : tube.stop + 1]
        gaps = np.hypot(
            held[:, None, 0] - points[None, :, 0], held[:, None, 1] - points[None, :, 1]
        ).min(axis=1)
        clearance = (
            robot.obstacle_clearance if robot.oblong is None else robot.obstacle_clearances(held)
        )
        bad = np.flatnonzero((gaps < clearance) & (gaps <= gaps[0]))
        bad = bad[bad > 0]
        if not len(bad):
            return None
        last = tube.near + int(bad[0]) - 1
        return Proposal(is_obstructed=True, keep_until=last, is_final=False)


class DropUnused:
    """Gives up space that is held but not driven into for `traffic.stuck_time`."""

    def __init__(self, robot: RobotView) -> None:
        self._pose, self._tick = robot.pose, robot.tick

    def propose(self, robot: RobotView) -> Proposal | None:
        """Keep the place only; whoever has a goal plans anew."""
        tube = robot.tube
        if robot.pose.distance(self._pose) > WATCHDOG_MOTION or tube.stop <= tube.near:
            self._pose, self._tick = robot.pose, robot.tick
        elif robot.tick - self._tick > robot.stuck_ticks and abs(robot.twist.vx) < 0.02:
            self._tick = robot.tick
            return UNUSED
        return None
