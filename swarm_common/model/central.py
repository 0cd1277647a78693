"""Who coordinates the traffic, and messages between robots and a centre that decides for them."""

from __future__ import annotations

import itertools
import math
import struct
from dataclasses import dataclass
from enum import StrEnum

import numpy as np

from swarm_common.model.records import FloatArray, Pose

# On the graph places have 8 bytes a number, so that robots and centre decide as in the bench.
REPORT = struct.Struct("<HIdddIIIddB")  # the fields of `RobotReport`; what it has seen follows
ORDER = struct.Struct("<HIIB")  # robot, number, first, number of points
POINT = struct.Struct("<dd")
# On the air 4 suffice, to less than a millimetre: this is what is counted.
REPORT_SIZE = struct.calcsize("<HIfffIIIffB")
POINT_SIZE = struct.calcsize("<ff")
FARTHEST = 10_000.0  # [m] of a robot or goal from the origin of the map
LONGEST = 100_000.0  # [m] of an order's way, from the origin on
MOST_SEEN = 16  # things in a report
SEEN_STEP = 0.25  # [m] from one of them to the next
SERIAL_BITS = 20  # of an order's number; those above count the commands that a robot came under


@dataclass(frozen=True, slots=True, kw_only=True)
class RobotReport:
    """A robot's message to the centre, once per tick."""

    robot_id: int
    tick: int  # of the pose
    pose_map: Pose
    passed: int  # number of points of its orders that the robot has left behind
    heard: int  # number of the newest order that arrived; 0 before the first
    goal_id: int  # of the current goal; 0 without one
    goal_map: tuple[float, float]  # [m]; NaN without a goal
    has_arrived: bool  # whether the robot turns or is served at its goal
    # [m] places of things that its LiDAR has seen, and neither map nor beacons explain
    seen_map: tuple[tuple[float, float], ...] = ()

    @property
    def size(self) -> int:
        """Bytes on the air."""
        return REPORT_SIZE + len(self.seen_map) * POINT_SIZE

    def packed(self) -> bytes:
        """Return the message."""
        pose = self.pose_map
        return REPORT.pack(
            self.robot_id,
            self.tick,
            pose.x,
            pose.y,
            pose.yaw,
            self.passed,
            self.heard,
            self.goal_id,
            *self.goal_map,
            self.has_arrived,
        ) + b"".join(POINT.pack(*place) for place in self.seen_map)


def places_seen(marks_map: FloatArray, pose_map: Pose) -> tuple[tuple[float, float], ...]:
    """Return what a robot reports of the marks of its LiDAR: the nearest, `SEEN_STEP` apart.

    Args:
        marks_map: (n, 2) [m].
        pose_map: Place of the robot, from which near is near.
    """
    if len(marks_map) == 0:
        return ()
    cells = np.unique(np.round(marks_map / SEEN_STEP), axis=0) * SEEN_STEP
    near = np.argsort(np.hypot(*(cells - (pose_map.x, pose_map.y)).T), kind="stable")[:MOST_SEEN]
    return tuple((x, y) for x, y in cells[near].tolist())


def unpack_report(data: bytes) -> RobotReport:
    """Return the report in a message.

    Raises:
        ValueError: If it has another size, or names no place.
    """
    head, body = data[: REPORT.size], data[REPORT.size :]
    if len(head) < REPORT.size or len(body) % POINT.size or len(body) > MOST_SEEN * POINT.size:
        raise ValueError(f"{len(data)} bytes are no report")
    robot_id, tick, x, y, yaw, passed, heard, goal_id, *goal, arrived = REPORT.unpack(head)
    seen = tuple(POINT.iter_unpack(body))
    places = (x, y, yaw, *(() if all(map(math.isnan, goal)) else goal), *itertools.chain(*seen))
    if not all(abs(value) <= FARTHEST for value in places):
        raise ValueError(f"a report of ({x:g}, {y:g}, {yaw:g}) with the goal {goal} and {seen}")
    return RobotReport(
        robot_id=robot_id,
        tick=tick,
        pose_map=Pose(x, y, yaw),
        passed=passed,
        heard=heard,
        goal_id=goal_id,
        goal_map=(goal[0], goal[1]),
        has_arrived=bool(arrived),
        seen_map=seen,
    )


@dataclass(frozen=True, slots=True, kw_only=True)
class TeamOrder:
    """The centre's message to a robot: drive along straight lines, and stop at the last point.

    An order never takes back space that an older one gave, so a lost one costs time only. One
    without points says that the centre is there.
    """

    robot_id: int
    number: int  # grows with each change
    first: int  # index of the first point among all points that the robot has been given
    points_map: tuple[tuple[float, float], ...]  # [m]

    @property
    def size(self) -> int:
        """Bytes on the air."""
        return ORDER.size + len(self.points_map) * POINT_SIZE

    def packed(self) -> bytes:
        """Return the message."""
        points = b"".join(POINT.pack(*point) for point in self.points_map)
        return ORDER.pack(self.robot_id, self.number, self.first, len(self.points_map)) + points


def unpack_order(data: bytes) -> TeamOrder:
    """Return the order in a message.

    Raises:
        ValueError: If its size is none of an order, or its points are no way.
    """
    head, body = data[: ORDER.size], data[ORDER.size :]
    if len(head) < ORDER.size or len(body) != head[-1] * POINT.size:
        raise ValueError(f"{len(data)} bytes are no order")
    robot_id, number, first, _ = ORDER.unpack(head)
    points = tuple(POINT.iter_unpack(body))
    length = sum(math.dist(*ends) for ends in itertools.pairwise(((0.0, 0.0), *points)))
    if not length <= LONGEST:
        raise ValueError(f"{length:g} m of way")
    return TeamOrder(robot_id=robot_id, number=number, first=first, points_map=points)


class Coordination(StrEnum):
    """Party that decides which robot waits or goes first; stop filters guard in any case."""

    DECENTRAL = "decentral"  # the robots among themselves
    CENTRAL = "central"  # one process for all robots
    CENTRAL_WITH_FALLBACK = "central-with-fallback"  # the robots while it is silent
    FLEET = "fleet"  # a fleet control, by base and horizon alone

    @property
    def has_centre(self) -> bool:
        """Whether one process of ours decides for all robots."""
        return self in (Coordination.CENTRAL, Coordination.CENTRAL_WITH_FALLBACK)
