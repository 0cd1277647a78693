"""Fine positioning: turns and straight moves from where a robot stopped to the exact pose."""

from __future__ import annotations

import math
from typing import NamedTuple

from swarm_common.model.records import Pose, wrap_angle
from swarm_vda5050.messages import NodePosition

FINE = 0.05  # [m] and [rad] off the pose within which a robot stands exactly
AIMED = 0.06  # [rad] off the way within which it drives straight
MOST_MOVES = 10  # of one action


class FineMove(NamedTuple):
    """A turn on the spot, or a straight way."""

    turn: float = 0.0  # [rad]
    distance: float = 0.0  # [m], negative backwards


def next_move(pose_map: Pose, target: NodePosition, *, may_back: bool) -> FineMove | None:
    """Return the next move to a pose; None if the robot stands there.

    Args:
        target: Any heading is right if it has no theta.
        may_back: Whether the robot drives backwards, too.
    """
    dx, dy = target.x - pose_map.x, target.y - pose_map.y
    distance = math.hypot(dx, dy)
    if distance > FINE:
        turn = wrap_angle(math.atan2(dy, dx) - pose_map.yaw)
        is_behind = may_back and abs(turn) > math.pi / 2
        turn = wrap_angle(turn + math.pi) if is_behind else turn
        if abs(turn) > AIMED:
            return FineMove(turn=turn)
        return FineMove(distance=-distance if is_behind else distance)
    turn = 0.0 if target.theta is None else wrap_angle(target.theta - pose_map.yaw)
    return FineMove(turn=turn) if abs(turn) > FINE else None


def rest_of(pose_map: Pose, target: NodePosition) -> str:
    """Return how far off a pose the robot is, for people."""
    away = f"{math.hypot(target.x - pose_map.x, target.y - pose_map.y):.3f} m"
    if target.theta is None:
        return f"{away} off"
    return f"{away} and {abs(wrap_angle(target.theta - pose_map.yaw)):.3f} rad off"
