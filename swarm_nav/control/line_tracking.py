"""Local controller of long robots: in a slot the line is tracked, elsewhere it is DWA.

The dynamic window may swing by a few degrees about a path: nothing for a disc, too much for a
nose of half a metre between two walls.
"""

from __future__ import annotations

import math

from swarm_common.model.records import CONTROL_PERIOD, Pose, Twist, wrap_angle
from swarm_nav.control import dwa_kernels
from swarm_nav.control.controller import (
    LOOKAHEAD,
    TUBE_TOLERANCE,
    WINDOW,
    Controller,
    length_to,
    rate_that_stops,
)
from swarm_nav.planning.distance_kernels import Place
from swarm_nav.reservation.tube import TubeView

HEADING_GAIN = 1.5  # [1/s] turning rate per heading error
OFFSET_GAIN = 1.2  # [rad/m] heading towards the line per offset from it
MOST_HEADING = 0.08  # [rad] of that
MOST_RATE = 0.4  # [rad/s]
SLOW_ERROR = 0.15  # [rad] heading error at which the robot does not drive on


class StraightController(Controller):
    """Turns a tube into a twist; calm where the way is narrow."""

    def _drive(self, tube: TubeView, pose: Pose, twist: Twist, end: int, corner: int) -> Twist:
        ahead = tube.points[tube.near : min(corner, tube.near + WINDOW) + 1]
        if tube.slots is None or len(ahead) < 2 or not tube.slots.is_slot(ahead).any():
            return super()._drive(tube, pose, twist, end, corner)
        config = self.config
        step = ahead[min(LOOKAHEAD, len(ahead) - 1)] - ahead[0]  # past a hook of a point or two
        way = math.atan2(step[1], step[0])
        offset = (pose.y - ahead[0, 1]) * math.cos(way) - (pose.x - ahead[0, 0]) * math.sin(way)
        towards = max(-MOST_HEADING, min(MOST_HEADING, -OFFSET_GAIN * offset))
        error = wrap_angle(way + towards - pose.yaw)
        change = config.acc_lim_theta * CONTROL_PERIOD
        rate = max(-MOST_RATE, min(MOST_RATE, HEADING_GAIN * error))
        rate = max(twist.wz - change, min(twist.wz + change, rate))
        speed = rate_that_stops(length_to(tube, end, pose), twist.vx, config.acc_lim_x)
        speed = min(speed, config.max_vel_x * max(0.0, 1.0 - abs(error) / SLOW_ERROR))
        speed = min(speed, twist.vx + config.acc_lim_x * CONTROL_PERIOD)
        held = tube.points[tube.near : tube.stop + 1]
        place = Place(pose.x, pose.y, pose.yaw)
        gap = dwa_kernels.held_gap(held, len(held) - 1, pose.x, pose.y)
        if not dwa_kernels.stops_inside(
            place, twist.vx, speed, rate, config.acc_lim_x, held, len(held) - 1,
            max(TUBE_TOLERANCE, dwa_kernels.RETURN * gap),
        ):  # fmt: skip
            speed = 0.0
        dwa_kernels.predict(place, speed, rate, self.arc)
        return Twist(float(speed), 0.0, float(rate))
