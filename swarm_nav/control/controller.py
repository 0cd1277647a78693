"""Local controller: rotation shim and DWA along the held tube, in the manner of Nav2.

Like Nav2's RotationShimController over DWB: a large heading error is turned away on the spot
(the held disc is circumscribed, so this needs no space), otherwise the dynamic window is sampled
and scored. The speed never exceeds what stops inside the tube.
"""

from __future__ import annotations

import math

import numpy as np

from swarm_common.model.records import CONTROL_PERIOD, FloatArray, Pose, Twist, wrap_angle
from swarm_nav.control import dwa_kernels
from swarm_nav.core.config import ControllerConfig
from swarm_nav.planning.distance_kernels import Place
from swarm_nav.reservation.tube import ARRIVED, TubeView

LOOKAHEAD = 3  # path points to the one that the heading error is measured to
WINDOW = 12  # path points that the rollouts are scored on
TUBE_TOLERANCE = 0.035  # [m] from the held polyline within which braking must end
ALIGNED = 0.05  # [rad] heading error at which turning on the spot ends
ALIGNED_RATE = 0.4  # [rad/s] at which it may end
SETTLED = 0.02  # [rad] within which the drive is not asked for corrections that it overshoots
STANDING = 0.02  # [m/s]
BACKWARDS = 1.9  # [rad] heading error from which a robot that makes way rather drives backwards
FORWARDS = 1.3  # [rad] below which it drives forwards again
BESIDE = 0.02  # [m] from the path, from where a way across a bend may lead out of the held space
BACK_ON = 0.01  # [m] from the path
# of long robots in narrow places
HEADING_GAIN = 1.5  # [1/s] turning rate per heading error
OFFSET_GAIN = 1.2  # [rad/m] heading towards the line per offset from it
MOST_HEADING = 0.08  # [rad] of that
MOST_RATE = 0.4  # [rad/s]
SLOW_ERROR = 0.15  # [rad] heading error at which the robot does not drive on


class Controller:
    """Turns a tube into a twist, tick by tick."""

    def __init__(self, config: ControllerConfig) -> None:
        """Start as a robot that is not turning.

        Args:
            config: Limits of the drive, samples and critics.
        """
        self.configure(config)
        self._is_turning = False
        self._returns = False  # to the path, since it found no way across a bend

    def configure(self, config: ControllerConfig) -> None:
        """Apply new parameters, effective from the next tick.

        Args:
            config: Limits of the drive, samples and critics.
        """
        self.config = config
        self._settings = (
            (config.max_vel_x, config.max_vel_theta, config.acc_lim_x, config.acc_lim_theta),
            (config.vx_samples, config.vtheta_samples, config.sim_time),
            (
                config.path_distance_scale,
                config.goal_distance_scale,
                config.path_align_scale,
                config.oscillation_scale,
            ),
        )
        self.arc: FloatArray = np.zeros((max(1, round(config.sim_time / dwa_kernels.STEP)), 3))

    def course(self, twist: Twist) -> Twist:
        """Receive the measured twist; return it in the form that the other parts use."""
        return twist

    def stop(self, twist: Twist) -> Twist:
        """Return the twist that brakes as hard as the drive can."""
        self._is_turning = False
        self.arc[:] = 0.0
        return Twist()

    def turn_to(self, yaw: float, pose: Pose, twist: Twist) -> Twist:
        """Return the twist that stops the robot and turns it on the spot.

        Args:
            yaw: [rad] in map, to turn to.
        """
        return self._turn(wrap_angle(yaw - pose.yaw), pose, twist)

    def is_reverse(self, tube: TubeView, pose: Pose, twist: Twist, may_back: bool) -> bool | None:
        """Return whether the path is driven backwards; decided anew at standstill.

        A robot that makes way turns twice if it drives forwards: away, and back again.

        Args:
            may_back: Whether driving backwards is allowed.

        Returns:
            None while the robot still drives backwards although it may not any longer.
        """
        if abs(twist.vx) > STANDING:
            return tube.is_reverse if may_back or not tube.is_reverse else None
        if not may_back:
            return False
        ahead = _direction(tube, pose, tube.next_corner())
        if ahead is None:
            return tube.is_reverse
        error = abs(wrap_angle(ahead - pose.yaw))
        return error > (FORWARDS if tube.is_reverse else BACKWARDS)

    def follow(self, tube: TubeView, pose: Pose, twist: Twist) -> Twist:
        """Return the twist that follows the tube, at most to its held end.

        Args:
            tube: Path and held part, with the robot's index on it.
        """
        if tube.is_reverse:
            flipped = Pose(pose.x, pose.y, wrap_angle(pose.yaw + math.pi))
            forward = self._follow(tube, flipped, Twist(-twist.vx, 0.0, twist.wz))
            return Twist(-forward.vx, 0.0, forward.wz)
        return self._follow(tube, pose, twist)

    def _follow(self, tube: TubeView, pose: Pose, twist: Twist) -> Twist:
        corner = tube.corner
        self._returns = self._returns and tube.gap(pose) > BACK_ON
        ahead = _direction(tube, pose, corner, 1 if self._returns else LOOKAHEAD)
        if ahead is None:
            return self._turn(0.0, pose, twist) if self._is_turning else Twist()
        error = wrap_angle(ahead - pose.yaw)
        threshold = self.config.rotate_to_heading_angle
        if self._is_turning and (abs(error) > ALIGNED or abs(twist.wz) > ALIGNED_RATE):
            threshold = 0.0
        if abs(error) > threshold:
            return self._turn(error, pose, twist)
        self._is_turning = False
        if tube.is_at_rest:
            return Twist()
        return self._drive(tube, pose, twist, min(corner, tube.stop), corner)

    def _turn(self, error: float, pose: Pose, twist: Twist) -> Twist:
        self._is_turning = True
        self.arc[:] = (pose.x, pose.y, pose.yaw)
        if abs(twist.vx) > STANDING or abs(error) < SETTLED:
            return Twist()
        rate = math.copysign(1.0, error) * twist.wz
        rate = rate_that_stops(abs(error), rate, self.config.acc_lim_theta)
        rate = min(rate, self.config.max_vel_theta)
        return Twist(0.0, 0.0, math.copysign(rate, error))

    def _drive(self, tube: TubeView, pose: Pose, twist: Twist, end: int, corner: int) -> Twist:
        config = self.config
        rest = length_to(tube, end, pose)
        acc = config.acc_lim_x
        v_limit = rate_that_stops(rest, twist.vx, acc)
        first, window = scored_window(tube, corner)
        if len(window) < 2:
            return Twist()
        v, w, _ = dwa_kernels.choose_twist(
            (pose.x, pose.y, pose.yaw),
            (max(0.0, twist.vx), twist.wz),
            window,
            (v_limit, max(0, end - first), TUBE_TOLERANCE),
            *self._settings,
            self.arc,
        )
        if v_limit < twist.vx - acc * CONTROL_PERIOD:  # as when acc_lim_x was lowered on the way
            v = 0.0  # as hard as the drive can
        if v == 0.0 < v_limit and abs(twist.vx) < STANDING and tube.gap(pose) > BESIDE:
            self._returns = True
        return Twist(float(v), 0.0, float(w))


class StraightController(Controller):
    """For long robots: in a slot the line is tracked, elsewhere it is DWA.

    The dynamic window may swing by a few degrees about a path: nothing for a disc, too much for a
    nose of half a metre between two walls.
    """

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


def scored_window(tube: TubeView, corner: int) -> tuple[int, FloatArray]:
    """Return the points that rollouts are scored on.

    They begin one behind the robot, but not before a bend.

    Args:
        tube: The path, with the robot's index on it.
        corner: Index of the next corner, the last point that may be scored on.

    Returns:
        The index of the first of the points, and the points (n, 2) [m] in map.
    """
    first = tube.near if tube.near in tube.corners else max(0, tube.near - 1)
    return first, tube.points[first : min(corner, tube.near + WINDOW) + 1]


def rate_that_stops(rest: float, rate: float, acceleration: float) -> float:
    """Return the largest rate after this period from which a stop in time is possible.

    Solves (rate + r) / 2 * T + r² / (2 a) = rest for r: the drive ramps during the period.

    Args:
        rest: [m] or [rad] to the place of the stop.
        rate: [m/s] or [rad/s] now.
        acceleration: [m/s²] or [rad/s²] of the drive.
    """
    half = CONTROL_PERIOD / 2
    room = half * half + 2.0 * (rest - rate * half) / acceleration
    return acceleration * (math.sqrt(room) - half) if room > half * half else 0.0


def _direction(tube: TubeView, pose: Pose, corner: int, points: int = LOOKAHEAD) -> float | None:
    """Return the yaw towards the path so many points ahead, None where there is none."""
    k = min(tube.near + points, corner)
    if k > tube.near and tube.gap_to(k, pose) > ARRIVED:
        return math.atan2(tube.points[k, 1] - pose.y, tube.points[k, 0] - pose.x)
    if k + 1 < len(tube.points):
        step = tube.points[min(k + 2, len(tube.points) - 1)] - tube.points[k]
        return math.atan2(step[1], step[0])
    return None


def length_to(tube: TubeView, end: int, pose: Pose) -> float:
    """Return the path length [m] from the robot to a point of the tube.

    Args:
        tube: The path, with the robot's index on it.
    """
    if end <= tube.near:
        return _signed_rest(tube, end, pose)
    return float(dwa_kernels.length_between(tube.points, tube.near, end, pose.x, pose.y))


def _signed_rest(tube: TubeView, end: int, pose: Pose) -> float:
    """Return how far the robot is before point `end` along the path's last direction."""
    if end == 0:
        return 0.0
    (x0, y0), (x, y) = tube.points[end - 1 : end + 1].tolist()
    length = max(1e-9, math.hypot(x - x0, y - y0))
    # no `@`: the last bit of a BLAS product depends on the processor
    rest = (x - x0) / length * (x - pose.x) + (y - y0) / length * (y - pose.y)
    return max(0.0, float(rest))
