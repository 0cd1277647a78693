"""The state of a robot for its operator, as bytes: a Python message takes longer than a tick."""

from __future__ import annotations

import math
import struct

from swarm_common.middleware.cdr import LITTLE_ENDIAN, encode_string
from swarm_common.middleware.cdr_layout import STAMP, aligned
from swarm_common.model.records import Pose, stamp_from_tick
from swarm_nav.core.goals import Status

_POSES = struct.Struct("<6d")
_NUMBERS = struct.Struct("<I2fiI2f7If")
_NOWHERE = Pose(math.nan, math.nan, math.nan)


class StatusWriter:
    """Encodes swarm_interfaces/RobotStatus of one robot."""

    def __init__(self, robot: str) -> None:
        self._robot = encode_string(robot)

    def encode(self, tick: int, status: Status) -> bytes:
        """Return the message of one tick in CDR, as it goes over the wire.

        Args:
            status: Without a goal, the goal's pose becomes NaN.
        """
        data = bytearray(LITTLE_ENDIAN + STAMP.pack(*stamp_from_tick(tick)) + self._robot)
        for text in (status.state, status.detail):
            data += bytes(aligned(len(data), 4) - len(data)) + encode_string(text)
        pose, goal = status.pose_map or _NOWHERE, status.goal_map or _NOWHERE
        data += bytes(aligned(len(data), 8) - len(data))
        data += _POSES.pack(pose.x, pose.y, pose.yaw, goal.x, goal.y, goal.yaw)
        data += encode_string(status.station)
        data += bytes(aligned(len(data), 4) - len(data))
        data += _NUMBERS.pack(
            status.queue_place,
            status.distance_remaining,
            status.estimated_time_remaining,
            *stamp_from_tick(status.holding_since_tick),
            status.hold_time,
            status.wait_time,
            status.number_of_recoveries,
            status.goals_reached,
            status.goals_failed,
            status.pushes,
            status.retreats,
            status.deadlocks_resolved,
            status.replans,
            status.battery,
        )
        return bytes(data)
