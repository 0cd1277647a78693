"""A localiser that a user brings, behind the face of the built-in ones."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from swarm_common.model.records import FloatArray, Odometry, Pose, RobotSpec, Scan
from swarm_common.process.plugins import PluginError
from swarm_nav.core.localisation_config import START_DEVIATION, LocalisationConfig
from swarm_nav.core.plugins import LOCALISER, Report
from swarm_nav.localisation.amcl import GROWTH, ORIGIN, is_leap, nudged
from swarm_nav.planning.terrain import Terrain


class PluginLocaliser:
    """Follows the estimates of a plug-in by a little per tick; a large correction waits."""

    def __init__(
        self,
        name: str,
        pose_map: Pose,
        config: LocalisationConfig,
        spec: RobotSpec,
        terrain: Terrain,
        report: Report,
    ) -> None:
        """Make the plug-in.

        Args:
            config: Its margins and `lost_deviation` count.
            terrain: Terrain of the map that counts at the start.
            report: Receives faults; the robot is lost meanwhile.

        Raises:
            ConfigError: If the plug-in is missing.
        """
        self._name, self._spec, self._report = name, spec, report
        self._config = config
        self._grid = terrain.grid
        self._odom = ORIGIN
        self._map_from_odom = pose_map
        self._start: Pose | None = pose_map  # before the first odometry
        self._begin(pose_map, START_DEVIATION)

    def _begin(self, pose_map: Pose, deviation: tuple[float, float]) -> None:
        self._best = pose_map
        self._deviation, self._yaw_deviation = deviation
        self._has_failed = False
        self._own = LOCALISER.guard(self._name, self._spec, self._grid, pose_map)

    def configure(self, config: LocalisationConfig) -> None:
        """Apply new parameters.

        Args:
            config: `localisation.` parameters.
        """
        self._config = config

    def load_map(self, terrain: Terrain) -> None:
        """Replace the map; the pose stays, and the plug-in is created anew.

        Args:
            terrain: Terrain of that map, in the same map frame.
        """
        self._grid = terrain.grid
        self._begin(self.pose_map, (self._deviation, self._yaw_deviation))

    def initialise(self, pose_map: Pose, deviation: tuple[float, float] = START_DEVIATION) -> None:
        """Set the pose for the present odometry; the plug-in is created anew.

        Args:
            deviation: Standard deviations of x and y [m], and of yaw [rad].
        """
        self._map_from_odom = pose_map.compose(self._odom.inverse())
        self._begin(pose_map, deviation)

    @property
    def map_from_odom(self) -> Pose:
        """The transform that the navigator broadcasts."""
        return self._map_from_odom

    @property
    def pose_map(self) -> Pose:
        """Pose of base_footprint in map."""
        return self._map_from_odom.compose(self._odom)

    @property
    def is_lost(self) -> bool:
        """Whether the pose is not good enough to drive by."""
        is_vague = self._deviation > self._config.lost_deviation
        return self._has_failed or is_vague or self.wants_leap

    @property
    def wants_leap(self) -> bool:
        """Whether the pending correction is so large that the robot has to stand for it."""
        return is_leap(self.pose_map, self._best)

    @property
    def margin(self) -> float:
        """Safety margin [m] that tracking and localisation need."""
        config = self._config
        rest = self._best.distance(self.pose_map)
        needed = config.tracking_margin + config.margin_per_sigma * self._deviation + rest + GROWTH
        return min(needed, config.most_margin)

    def leap(self) -> None:
        """Correct the pose at once."""
        self._map_from_odom = self._best.compose(self._odom.inverse())

    def on_odom(self, odom: Odometry) -> None:
        """Receive the newest odometry and the plug-in's estimate."""
        step = self._odom.inverse().compose(odom.pose_odom)
        self._odom = odom.pose_odom
        if self._start is not None:
            self._map_from_odom = self._start.compose(odom.pose_odom.inverse())
            self._start = None
        else:
            self._best = self._best.compose(step)  # where there is no estimate
        try:
            self._best, self._deviation = self._checked(self._own.call("on_odom", odom))
            self._has_failed = False
        except PluginError as error:
            self._fail(error)
        if not self.wants_leap:
            nudged_map = nudged(self.pose_map, self._best) or self._best
            self._map_from_odom = nudged_map.compose(self._odom.inverse())

    def on_scan(self, scan: Scan) -> None:
        """Hand a scan on."""
        try:
            self._own.call("on_scan", scan)
        except PluginError as error:
            self._fail(error)

    def particles(self) -> FloatArray:
        """Return the one hypothesis."""
        pose = self.pose_map
        return np.array(((pose.x, pose.y, pose.yaw),))

    def variances(self) -> tuple[float, float, float]:
        """Return the variances of x, y [m²] and yaw [rad²]."""
        return self._deviation**2, self._deviation**2, self._yaw_deviation**2

    def _fail(self, error: PluginError) -> None:
        self._has_failed = True
        self._report(LOCALISER.codes[error.fault], str(error))

    def _checked(self, estimate: Any) -> tuple[Pose, float]:
        try:
            pose, deviation = estimate
            numbers = [float(value) for value in (pose.x, pose.y, pose.yaw, deviation)]
            if all(map(math.isfinite, numbers)) and numbers[3] >= 0.0:
                return Pose(*numbers[:3]), numbers[3]
        except (TypeError, ValueError, AttributeError):
            pass
        expected = "expected a finite Pose and its deviation [m]"
        raise self._own.unusable(f"on_odom returned {estimate!r}; {expected}")
