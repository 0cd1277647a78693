"""How a correction of the pose enters it: bit by bit, so that the robot does not leap."""

from __future__ import annotations

from swarm_common.model.records import Pose, wrap_angle

STEP, TURN = 0.005, 0.01  # [m] and [rad] by which a tick may correct the pose
LEAP, SPIN = 0.10, 0.25  # [m] and [rad] beyond which a correction waits for a standstill


def is_leap(now: Pose, best: Pose) -> bool:
    """Whether a correction is too large to drive on meanwhile.

    Args:
        now: The pose in use, in map.
        best: The better one.
    """
    return best.distance(now) > LEAP or abs(wrap_angle(best.yaw - now.yaw)) > SPIN


def nudged(now: Pose, best: Pose) -> Pose | None:
    """Return a pose moved towards a better one by as much as one tick may correct.

    Args:
        now: The pose in use, in map.
        best: The better one.

    Returns:
        The moved pose; None if the better one is within reach of this tick.
    """
    gap, turn = now.distance(best), wrap_angle(best.yaw - now.yaw)
    if gap <= STEP and abs(turn) <= TURN:
        return None
    share = min(1.0, STEP / max(gap, STEP))
    return Pose(
        now.x + share * (best.x - now.x),
        now.y + share * (best.y - now.y),
        wrap_angle(now.yaw + min(TURN, max(-TURN, turn))),
    )
