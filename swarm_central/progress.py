"""State of one robot as the centre knows it, and how far the centre let it drive."""

from __future__ import annotations

import math
from collections.abc import Iterator

from swarm_central.team import RobotReport, TeamOrder

Point = tuple[float, float]
REACHED = 0.01  # [m] from a point at which space that was given ends there
LONGEST_ORDER = 12  # points


class RobotProgress:
    """One robot: what it last reported, and the space that it may drive on.

    Attributes:
        vertex: Vertex at which the robot will be once it has driven all that was given.
        left: The vertex before that.
        heading: Direction in which it arrives there.
        points: Everything that it was given, in order; the first is where it stood at the start.
        stop: The end of what was given: the last point, or a place on the way to `aim`.
        aim: Point that is being given piece by piece; None if all of it was.
        queue: Points to give next, in any case: onto the roadmap, or to a place beside it.
        report: The newest.
        is_beside: Whether it was last given the way to a place beside its vertex.
        since: Tick of the goal.
    """

    def __init__(self, report: RobotReport, vertex: int, heading: int) -> None:
        """Start with the first report of a robot.

        Args:
            vertex: Vertex of the roadmap to which it is to drive first.
            heading: The nearest direction of the roadmap.
        """
        self.report = report
        self.vertex = self.left = vertex
        self.heading = heading
        self.points: list[Point] = [(report.pose_map.x, report.pose_map.y)]
        self.stop: Point = self.points[0]
        self.aim: Point | None = None
        self.queue: list[Point] = []
        self.is_beside = False
        self.since = report.tick
        self._number = report.heard

    def take(self, report: RobotReport) -> bool:
        """Receive a report if it is newer; return whether the goal has changed."""
        if report.tick <= self.report.tick and self._number:
            return False
        has_changed = report.goal_id != self.report.goal_id
        self.report = report
        if has_changed:
            self.since = report.tick
            if self.is_beside and self.aim is not None:  # no need to go there any more
                self.end_here()
        return has_changed

    def held(self) -> Iterator[tuple[Point, Point]]:
        """Yield the lines on which the robot may be or may still drive, from its last pose on."""
        pose = self.report.pose_map
        before = (pose.x, pose.y)
        for point in self._ahead():
            yield before, point
            before = point
        if before == (pose.x, pose.y):
            yield before, before

    def _ahead(self) -> list[Point]:
        ahead = self.points[max(1, self.report.passed) :]
        return ahead if self.aim is None else [*ahead, self.stop]

    def extend(self, length: float) -> None:
        """Give the way to the aim a piece further.

        Args:
            length: [m]
        """
        assert self.aim is not None
        rest = math.dist(self.stop, self.aim)
        if rest - length < REACHED:
            self.stop = self.aim
            self.points.append(self.aim)
            self.aim = None
        else:
            share = length / rest
            self.stop = (
                self.stop[0] + share * (self.aim[0] - self.stop[0]),
                self.stop[1] + share * (self.aim[1] - self.stop[1]),
            )
        self._number += 1

    def end_here(self) -> None:
        """Give no more of the way to the aim; what was given stays."""
        self.points.append(self.stop)
        self.aim = None
        self._number += 1

    def turn_back(self, point: Point) -> None:
        """Send the robot back to the vertex that it left for one that it cannot reach.

        Args:
            point: Point of the vertex that it left, (x, y) [m] in map.
        """
        self.end_here()
        self.vertex = self.left
        self.heading = (self.heading + 2) % 4
        self.queue = [point]

    def order(self) -> TeamOrder | None:
        """Return the order that the robot has not confirmed; None if it has heard everything."""
        if self.report.heard == self._number:
            return None
        first = max(0, self.report.passed - 1)
        points = self.points[first:]
        if self.aim is not None:
            points = [*points, self.stop]
        return TeamOrder(
            robot_id=self.report.robot_id,
            number=self._number,
            first=first,
            points_map=tuple(points[:LONGEST_ORDER]),
        )
