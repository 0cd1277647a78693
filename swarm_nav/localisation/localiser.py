"""Localisation in the map: dead reckoning, or Monte Carlo localisation (`amcl`)."""

from __future__ import annotations

from typing import TYPE_CHECKING, TypeAlias

import numpy as np

from swarm_common.model.records import FloatArray, Odometry, Pose, RobotSpec, Scan
from swarm_nav.core.localisation_config import AMCL, START_DEVIATION, LocalisationConfig
from swarm_nav.core.plugins import LOCALISER, Report, ignore
from swarm_nav.perception.neighbor_table import NeighborTable
from swarm_nav.planning.terrain import Terrain

if TYPE_CHECKING:
    from swarm_nav.localisation.amcl import AmclLocaliser
    from swarm_nav.localisation.plugin_localiser import PluginLocaliser

DRIFT = (0.002, 0.001)  # [m] and [rad] by which odometry is off per metre driven


class OdometryLocaliser:
    """Dead reckoning from a known pose; `initialise` corrects it."""

    margin = 0.0
    is_lost = False
    wants_leap = False

    def __init__(self, pose_map: Pose) -> None:
        """Start at a known pose; the odometry frame is tied to it by the first message."""
        self._pending: Pose | None = pose_map
        self._pose_odom = Pose(0.0, 0.0, 0.0)
        self._map_from_odom = pose_map
        self._deviation = START_DEVIATION
        self._driven = 0.0  # [m] since a pose was given

    @property
    def map_from_odom(self) -> Pose:
        """The transform that the navigator broadcasts."""
        return self._map_from_odom

    @property
    def pose_map(self) -> Pose:
        """Pose of base_footprint in map."""
        return self._map_from_odom.compose(self._pose_odom)

    def leap(self) -> None:
        """Nothing is found out here."""

    def configure(self, config: LocalisationConfig) -> None:
        """There are no parameters."""

    def load_map(self, terrain: Terrain) -> None:
        """Maps do not enter dead reckoning."""

    def initialise(self, pose_map: Pose, deviation: tuple[float, float] = START_DEVIATION) -> None:
        """Set the pose for the present odometry.

        Args:
            deviation: Standard deviations of x and y [m], and of yaw [rad].
        """
        self._deviation = deviation
        self._map_from_odom = pose_map.compose(self._pose_odom.inverse())
        self._driven = 0.0

    def on_odom(self, odom: Odometry) -> None:
        """Receive the newest odometry."""
        self._driven += self._pose_odom.distance(odom.pose_odom)
        self._pose_odom = odom.pose_odom
        if self._pending is not None:
            self.initialise(self._pending)
            self._pending = None

    def on_scan(self, scan: Scan) -> None:
        """Scans do not enter dead reckoning."""

    def particles(self) -> FloatArray:
        """Return the one hypothesis."""
        pose = self.pose_map
        return np.array(((pose.x, pose.y, pose.yaw),))

    def variances(self) -> tuple[float, float, float]:
        """Return the variances of x, y [m²] and yaw [rad²]; they grow with the way driven."""
        place, yaw = (
            start**2 + (rate * self._driven) ** 2
            for start, rate in zip(self._deviation, DRIFT, strict=True)
        )
        return place, place, yaw


Localiser: TypeAlias = "OdometryLocaliser | AmclLocaliser | PluginLocaliser"


def make_localiser(
    pose_map: Pose,
    config: LocalisationConfig,
    spec: RobotSpec,
    terrain: Terrain,
    neighbors: NeighborTable,
    robot_id: int,
    plugin: str = "by_type",
    report: Report = ignore,
) -> Localiser:
    """Return the localiser that the parameters ask for.

    Args:
        config: `localisation.` parameters.
        plugin: `localiser.plugin`.
        report: Receives faults of a plug-in.

    Raises:
        ConfigError: If the plug-in is missing.
    """
    if LOCALISER.is_own(plugin):
        from swarm_nav.localisation.plugin_localiser import PluginLocaliser

        return PluginLocaliser(plugin, pose_map, config, spec, terrain, report)
    if config.type == AMCL:
        # its kernels are loaded only where they are needed
        from swarm_nav.localisation.amcl import AmclLocaliser

        return AmclLocaliser(pose_map, config, spec, terrain, neighbors, robot_id)
    return OdometryLocaliser(pose_map)
