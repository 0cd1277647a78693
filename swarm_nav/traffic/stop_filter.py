"""The stop filter: the last thing before a command leaves, whoever made it.

It scales a twist until the robot, if it brakes after one control period of it, stays within the
space that it holds, and off walls and LiDAR hits. So safety does not depend on the controller. A
standstill always passes: the twist before was admitted, so braking leads where it was checked.
"""

from __future__ import annotations

import math

from swarm_common.model.records import CONTROL_PERIOD, Twist
from swarm_nav.core.config import ControllerConfig
from swarm_nav.reservation.stop_filter_kernels import release_and_admit
from swarm_nav.reservation.tube import TOLERANCE
from swarm_nav.traffic.robot_state import RobotView

ROUNDING = 1e-9  # [m/s], [rad/s] by which a controller may exceed the limits of the drive
STANDING = 0.02  # [m/s] below which a robot brakes within a fraction of a millimetre
STANDSTILL = Twist()


def clip_to_held_space(robot: RobotView, wish: Twist) -> tuple[Twist, int]:
    """Return the largest scaling of a twist from which the robot stops in its own space.

    Args:
        wish: Twist in base_footprint; with a number that is not finite it counts as a standstill.

    Returns:
        The twist to drive, within the limits of the drive, and the index of the first path point
        that stays held: what is behind is not needed any more.
    """
    tail = robot.tube.tail
    if not math.isfinite(wish.vx + wish.vy + wish.wz):
        return STANDSTILL, tail
    limits = robot.config.controller
    twist = _within_limits(wish, limits)
    is_turn = twist.vx == 0.0 == twist.vy and robot.speed < STANDING
    if not is_turn:  # a disc that turns on the spot needs no space
        twist, tail = _in_held_space(robot, twist, limits)
    if robot.oblong is None:
        return twist, tail
    straight = robot.oblong.admitted(
        (robot.terrain.distance, robot.terrain.frame),
        robot.obstacle_points(),
        robot.pose,
        robot.twist,
        twist,
        (limits.acc_lim_x, limits.acc_lim_theta),
    )
    return straight, tail


def _in_held_space(robot: RobotView, wish: Twist, limits: ControllerConfig) -> tuple[Twist, int]:
    tube, terrain, pose, now = robot.tube, robot.terrain, robot.pose, robot.velocity
    tail, share = release_and_admit(
        (pose.x, pose.y, pose.yaw),
        (now.vx, now.vy, now.wz),
        (wish.vx, wish.vy, wish.wz),
        (limits.acc_lim_x, limits.acc_lim_y, limits.acc_lim_theta, CONTROL_PERIOD),
        (tube.points, tube.tail, tube.near, tube.stop, TOLERANCE),
        (
            terrain.distance,
            terrain.frame,
            robot.obstacle_points(),
            robot.config.costmap.footprint_padding,
            robot.body_radius if robot.oblong is None else -math.inf,
        ),
    )
    if share == 1.0:
        return wish, tail
    part = Twist(share * wish.vx, share * wish.vy, share * wish.wz) if share else STANDSTILL
    return part, tail


def _within_limits(wish: Twist, limits: ControllerConfig) -> Twist:
    most_x, most_y, most_turn = limits.max_vel_x, limits.max_vel_y, limits.max_vel_theta
    if (
        abs(wish.vx) <= most_x + ROUNDING
        and abs(wish.vy) <= most_y + ROUNDING
        and abs(wish.wz) <= most_turn + ROUNDING
    ):
        return wish
    return Twist(
        max(-most_x, min(most_x, wish.vx)),
        max(-most_y, min(most_y, wish.vy)),
        max(-most_turn, min(most_turn, wish.wz)),
    )
