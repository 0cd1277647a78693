"""Caution around people: who stands may be walked up to, who drives may be walked into.

A person stops for nobody, but does not step into a robot that stands. So near anything restless
that neither the map nor the radio explains, the robot goes no faster than standing (the speed and
separation monitoring of ISO/TS 15066): it still gets away from there, but nobody can run into it.
The distance follows from the reaction: age of the scan, a control period and braking, in all of
which a person walks on.
"""

from __future__ import annotations

from swarm_common.records import CONTROL_PERIOD, Twist
from swarm_nav.situation import Situation

CREEP_SPEED = 0.015  # [m/s] at which a robot counts as standing
WALKING_SPEED = 1.0  # [m/s] of people
SCAN_AGE = 0.2  # [s] of what the robot knows, at most
ROOM = 0.05  # [m] beyond all that
TURN_ROOM = 0.03  # [m] from the robot's circle within which it does not turn either


def caution_distance(max_speed: float, acceleration: float) -> float:
    """Return the gap [m] at which a robot must begin to stop for a person who comes at it.

    Args:
        max_speed: [m/s] of the robot.
        acceleration: [m/s²] with which it brakes.
    """
    reaction = SCAN_AGE + CONTROL_PERIOD
    braking = max_speed / acceleration
    own_way = max_speed * (reaction + braking / 2.0)
    return WALKING_SPEED * (reaction + braking) + own_way + ROOM


def limited(situation: Situation, twist: Twist) -> Twist:
    """Return the twist, slowed down if somebody is near; notes that in `is_wary`."""
    s = situation
    config = s.config.controller
    gap = s.obstacles.restless_gap(s.pose.x, s.pose.y, s.tick) - s.body_radius
    s.is_wary = gap < caution_distance(config.max_vel_x, config.acc_lim_x)
    speed = abs(twist.vx)
    if not s.is_wary:
        return twist
    if gap < TURN_ROOM:
        return Twist()
    if speed <= CREEP_SPEED:
        return twist
    share = CREEP_SPEED / speed
    return Twist(twist.vx * share, 0.0, twist.wz * share)
