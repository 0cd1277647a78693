"""Local controller of drives that move in any direction: DWA with a speed sideways.

What the other parts of a navigator take for the speed ahead is here the speed along the course:
a disc has no front, and the held space is made of discs.
"""

from __future__ import annotations

import math

import numpy as np

from swarm_common.model.records import Pose, RobotSpec, Twist
from swarm_nav.control import omni_kernels
from swarm_nav.control.controller import (
    LOOKAHEAD,
    TUBE_TOLERANCE,
    Controller,
    StraightController,
    length_to,
    rate_that_stops,
    scored_window,
)
from swarm_nav.control.plugin_controller import PluginController
from swarm_nav.core.config import ControllerConfig
from swarm_nav.core.plugins import CONTROLLER, Report, ignore
from swarm_nav.reservation.tube import TubeView

TURN_SAMPLES = 5  # of the turning rate at most: the course does not depend on it


def make_controller(
    spec: RobotSpec, config: ControllerConfig, report: Report = ignore
) -> Controller:
    """Return the controller for a robot's drive and shape, or the plug-in that is named.

    Args:
        config: Limits of the drive, samples and critics.
        report: Receives faults of a plug-in.

    Raises:
        ConfigError: If the plug-in is missing.
    """
    if CONTROLLER.is_own(config.plugin):
        return PluginController(spec, config, report)
    if spec.is_omni:
        return OmniController(config)
    return StraightController(config) if spec.is_oblong else Controller(config)


class OmniController(Controller):
    """Turns a tube into a twist with a speed sideways."""

    def __init__(self, config: ControllerConfig) -> None:
        """Start as a robot that stands.

        Args:
            config: Limits of the drive, samples and critics.
        """
        super().__init__(config)
        self._velocity = (0.0, 0.0, 0.0)

    def course(self, twist: Twist) -> Twist:
        """Receive the measured twist; return the speed along the course in place of vx, vy."""
        self._velocity = (twist.vx, twist.vy, twist.wz)
        return Twist(math.hypot(twist.vx, twist.vy), 0.0, twist.wz)

    def is_reverse(self, tube: TubeView, pose: Pose, twist: Twist, may_back: bool) -> bool | None:
        """Never drive backwards: the robot need not turn to make way."""
        return False

    def follow(self, tube: TubeView, pose: Pose, twist: Twist) -> Twist:
        """Return the twist that follows the tube, at most to its held end.

        Args:
            tube: Path and held part, with the robot's index on it.
            twist: The twist that `course` returned.
        """
        self._is_turning = False
        corner = tube.corner
        end = min(corner, tube.stop)
        first, window = scored_window(tube, corner)
        if len(window) < 2 or tube.is_at_rest:
            return self.stop(twist)
        config = self.config
        limit = rate_that_stops(
            length_to(tube, end, pose), twist.vx, min(config.acc_lim_x, config.acc_lim_y)
        )
        aim = tube.points[min(tube.near + LOOKAHEAD, corner)]
        vx, vy, w = omni_kernels.choose_velocity(
            (pose.x, pose.y, pose.yaw),
            self._velocity,
            np.ascontiguousarray(window),
            (limit, max(0, end - first), TUBE_TOLERANCE, float(aim[0]), float(aim[1])),
            (
                config.max_vel_x,
                config.max_vel_y,
                config.max_vel_theta,
                config.acc_lim_x,
                config.acc_lim_y,
                config.acc_lim_theta,
            ),
            (
                config.vx_samples,
                config.vy_samples,
                min(config.vtheta_samples, TURN_SAMPLES),
                config.sim_time,
            ),
            (
                config.path_distance_scale,
                config.goal_distance_scale,
                config.path_align_scale,
                config.oscillation_scale,
                math.pi if tube.is_reverse else 0.0,
            ),
            self.arc,
        )
        return Twist(float(vx), float(vy), float(w))
