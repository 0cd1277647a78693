"""Speed near people: a person may walk into a driving robot, but not into a standing one.

So the nearer a moving body is that neither map nor radio explains, the slower the robot drives
(the speed and separation monitoring of ISO/TS 15066): it can always stand before the person is
there. Where even that is too late it creeps, which counts as standing, so that it still gets away
from there. The gap that a speed needs follows from the reaction: age of the scan, a control period
and braking, in all of which a person walks on.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from swarm_common.model.records import CONTROL_PERIOD, Twist
from swarm_nav.core.config import ControllerConfig
from swarm_nav.traffic.robot_state import RobotView

CREEP_SPEED = 0.015  # [m/s] at which a robot counts as standing
WALKING_SPEED = 1.0  # [m/s] of people
SCAN_AGE = 0.2  # [s] largest age of the data
ROOM = 0.05  # [m] beyond all that
TURN_ROOM = 0.03  # [m] from the robot's circle within which it does not turn either


def caution_distance(max_speed: float, acceleration: float) -> float:
    """Return the gap [m] at which a robot must begin to stop for an approaching person.

    Args:
        max_speed: [m/s] of the robot.
        acceleration: [m/s²] with which it brakes.
    """
    reaction = SCAN_AGE + CONTROL_PERIOD
    braking = max_speed / acceleration
    own_way = max_speed * (reaction + braking / 2.0)
    return WALKING_SPEED * (reaction + braking) + own_way + ROOM


def cautious_speed(gap: float, acceleration: float) -> float:
    """Return the largest speed [m/s] whose `caution_distance` is at most a gap [m]; 0 for none.

    Args:
        gap: [m] to the person.
        acceleration: [m/s²] with which the robot brakes.
    """
    reaction = SCAN_AGE + CONTROL_PERIOD
    spare = gap - WALKING_SPEED * reaction - ROOM
    if spare <= 0.0:
        return 0.0
    half = WALKING_SPEED / acceleration + reaction
    return acceleration * (math.sqrt(half * half + 2.0 * spare / acceleration) - half)


class People(NamedTuple):
    """The nearest moving body that neither map nor radio explains."""

    gap: float  # [m] between its last place and the robot's circle, inf if there is none
    is_near: bool  # whether the robot must not drive at full speed


NOBODY_NEAR = People(math.inf, False)


def people_near(robot: RobotView) -> People:
    """Return how near the nearest person may be."""
    s = robot
    config = s.config.controller
    gap = s.obstacles.restless_gap(s.pose.x, s.pose.y, s.tick) - s.body_radius
    if gap == math.inf:
        return NOBODY_NEAR
    return People(gap, gap < caution_distance(config.max_vel_x, config.acc_lim_x))


def slow_near_people(twist: Twist, people: People, config: ControllerConfig) -> Twist:
    """Return a twist scaled so that the robot stands before a person reaches it."""
    if not people.is_near:
        return twist
    if people.gap < TURN_ROOM:
        return Twist()
    speed = math.hypot(twist.vx, twist.vy) if twist.vy else abs(twist.vx)
    allowed = max(CREEP_SPEED, cautious_speed(people.gap, config.acc_lim_x))
    if speed <= allowed:
        return twist
    share = allowed / speed
    return Twist(twist.vx * share, twist.vy * share, twist.wz * share)
