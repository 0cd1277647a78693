"""A controller that a user brings, behind the face of the built-in one."""

from __future__ import annotations

import math

from swarm_common.model.records import Pose, RobotSpec, Twist
from swarm_common.process.plugins import PluginError
from swarm_nav.control import dwa_kernels
from swarm_nav.control.controller import Controller, length_to, rate_that_stops
from swarm_nav.core.config import ControllerConfig
from swarm_nav.core.plugins import CONTROLLER, Report
from swarm_nav.interfaces import DriveLimits, PathAhead
from swarm_nav.planning.distance_kernels import Place
from swarm_nav.reservation.tube import ARRIVED, TubeView


class PluginController(Controller):
    """Turns on the spot and stops as the built-in controller does; the plug-in follows paths."""

    def __init__(self, spec: RobotSpec, config: ControllerConfig, report: Report) -> None:
        """Make the plug-in that the parameters name.

        Args:
            report: Receives faults of the plug-in; the robot stands meanwhile.

        Raises:
            ConfigError: If it is missing.
        """
        super().__init__(config)
        self._is_omni = spec.is_omni
        self._measured = Twist()
        self._report = report
        self._own = CONTROLLER.guard(config.plugin, spec)

    def configure(self, config: ControllerConfig) -> None:
        """Apply new limits, effective from the next tick."""
        super().configure(config)
        self._limits = DriveLimits(
            config.max_vel_x, config.max_vel_y, config.max_vel_theta,
            config.acc_lim_x, config.acc_lim_y, config.acc_lim_theta,
        )  # fmt: skip

    def course(self, twist: Twist) -> Twist:
        """Receive the measured twist; return it with the speed along the course as vx."""
        self._measured = twist
        return Twist(math.hypot(twist.vx, twist.vy), 0.0, twist.wz) if self._is_omni else twist

    def is_reverse(self, tube: TubeView, pose: Pose, twist: Twist, may_back: bool) -> bool | None:
        """Return whether the path is driven backwards; omnidirectional drives never do."""
        return super().is_reverse(tube, pose, twist, may_back and not self._is_omni)

    def _follow(self, tube: TubeView, pose: Pose, twist: Twist) -> Twist:
        self._is_turning = False
        corner = tube.corner
        self.arc[:] = (pose.x, pose.y, pose.yaw)
        if corner <= tube.near or tube.gap_to(corner, pose) < ARRIVED:
            return Twist()
        acc = self._limits.acc_lim_x
        if self._is_omni:
            acc = min(acc, self._limits.acc_lim_y)
        rest = length_to(tube, min(corner, tube.stop), pose)
        most = math.hypot(self._limits.max_vel_x, self._limits.max_vel_y)
        top_speed = 0.0 if tube.is_at_rest else min(most, rate_that_stops(rest, twist.vx, acc))
        path = PathAhead(tube.points[tube.near : corner + 1].copy(), rest, top_speed)
        seen = self._measured if self._is_omni else twist
        try:
            wanted = self._own.call("follow", path, pose, seen, self._limits)
            if not _is_twist(wanted):
                raise self._own.unusable(f"follow returned {wanted!r}; expected a finite Twist")
        except PluginError as error:
            self._report(CONTROLLER.codes[error.fault], str(error))
            return Twist()
        chosen = self._limited(wanted, top_speed)
        dwa_kernels.predict(Place(pose.x, pose.y, pose.yaw), chosen.vx, chosen.wz, self.arc)
        return chosen

    def _limited(self, twist: Twist, top_speed: float) -> Twist:
        """Return a twist within the limits of the drive, at most as fast along its arc."""
        limits = self._limits
        vx = max(-limits.max_vel_x, min(limits.max_vel_x, float(twist.vx)))
        vy = max(-limits.max_vel_y, min(limits.max_vel_y, float(twist.vy)))
        wz = max(-limits.max_vel_theta, min(limits.max_vel_theta, float(twist.wz)))
        speed = math.hypot(vx, vy)
        if speed <= top_speed:
            return Twist(vx, vy, wz)
        share = top_speed / speed
        return Twist(share * vx, share * vy, share * wz if share > 0.0 else wz)


def _is_twist(value: object) -> bool:
    if not isinstance(value, Twist):
        return False
    try:
        return all(math.isfinite(number) for number in (value.vx, value.vy, value.wz))
    except TypeError:
        return False
