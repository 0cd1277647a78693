"""Adaptive Monte Carlo localisation (Fox 2003; Thrun, Burgard, Fox 2005) on a likelihood field.

Between two comparisons with the map the robot uses its odometry. A correction found by a
comparison enters the pose gradually, so that the pose does not jump out of the space that the
robot holds; a large correction waits until the robot stands.
"""

from __future__ import annotations

import math

import numpy as np

from swarm_common.model.records import (
    CONTROL_PERIOD,
    FloatArray,
    Odometry,
    Pose,
    RobotSpec,
    Scan,
    wrap_angle,
)
from swarm_nav.core.localisation_config import START_DEVIATION, LocalisationConfig
from swarm_nav.localisation import amcl_kernels
from swarm_nav.localisation.likelihood import field_for
from swarm_nav.localisation.particle_filter import Estimate, ParticleFilter, Step
from swarm_nav.perception.neighbor_table import NeighborTable
from swarm_nav.planning.distance_kernels import Place
from swarm_nav.planning.terrain import Terrain

ORIGIN = Pose(0.0, 0.0, 0.0)
STILL_SPEED, STILL_RATE = 0.004, 0.01  # [m/s] and [rad/s] below which the wheels stand still
FIRST_SCANS = 8  # after a pose was given, which count in full although the robot stands
LEAST_POWER = 0.02  # least weight of a scan from a place where others were compared before
FEWEST_BEAMS = 8  # on mapped walls, below which a scan tells nothing
LOOKING_SCANS = 50  # that tell nothing, after which only driving brings something new into view
JUDGING_SHARE = 3  # one in so many beams must hit mapped walls to judge whether the pose is wrong
GROWTH = 0.005  # [m] of margin announced ahead, so that all know it before it is needed
EXPECTED_FIT = 0.9  # of a scan at the right place
MOST_FRESH = 0.5  # largest share of the particles that is redrawn
STEP, TURN = 0.005, 0.01  # [m] and [rad] by which a tick may correct the pose
LEAP, SPIN = 0.10, 0.25  # [m] and [rad] beyond which a correction waits for a standstill


class AmclLocaliser:
    """Estimates the pose from odometry, scans and map, and whether the estimate can be trusted."""

    def __init__(
        self,
        pose_map: Pose,
        config: LocalisationConfig,
        spec: RobotSpec,
        terrain: Terrain,
        neighbors: NeighborTable,
        robot_id: int,
    ) -> None:
        """Start at a pose that is known with the deviation `START_DEVIATION`."""
        self._lidar = spec.lidar
        self._neighbors = neighbors
        self._terrain = terrain
        seed = config.random_seed * 1_000_003 + robot_id
        self._filter = ParticleFilter(config, seed, is_omni=spec.is_omni)
        self._pose_odom: Pose | None = None  # before the first odometry
        self._last_odom, self._moving_ticks = ORIGIN, 0
        self._fit = self._fast_fit = self._slow_fit = EXPECTED_FIT
        self._first_scans, self._vague_scans = FIRST_SCANS, 0
        self._map_from_odom = self._target = self._start = pose_map
        self.configure(config)
        self._begin(pose_map, START_DEVIATION)

    def configure(self, config: LocalisationConfig) -> None:
        """Apply new parameters, effective from the next scan.

        Args:
            config: `localisation.` parameters.
        """
        self._config = config
        self._filter.configure(config)
        self._hits = np.empty((min(config.max_beams, self._lidar.rays), 2))

    def load_map(self, terrain: Terrain) -> None:
        """Replace the map; the pose stays.

        Args:
            terrain: Terrain of that map, in the same map frame.
        """
        self._terrain = terrain

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
        """Whether the pose is not good enough to drive by.

        A robot that has looked around for long, and has seen nothing that shows its place or
        contradicts the map, is no longer lost: only driving brings something new into view.
        """
        config = self._config
        is_unfit = self._fast_fit < config.lost_fit
        if self._deviation <= config.lost_deviation:
            return is_unfit or self.wants_leap
        return is_unfit or self.wants_leap or self._vague_scans < LOOKING_SCANS

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

    @property
    def _deviation(self) -> float:
        """Return the standard deviation [m] of the position in its least certain direction."""
        x, y, _ = self.variances()
        return math.sqrt(max(x, y))

    def initialise(self, pose_map: Pose, deviation: tuple[float, float] = START_DEVIATION) -> None:
        """Set the pose for the present odometry, and draw the particles around it.

        Args:
            deviation: Standard deviations of x and y [m], and of yaw [rad].
        """
        self._map_from_odom = self._target = pose_map.compose(self._odom.inverse())
        self._begin(pose_map, deviation)

    def leap(self) -> None:
        """Correct the pose at once."""
        self._map_from_odom = self._target

    def particles(self) -> FloatArray:
        """Return hypotheses (k, 3): x, y, yaw in map."""
        return self._filter.at(self._step.motion)

    def variances(self) -> tuple[float, float, float]:
        """Return the variances of x, y [m²] and yaw [rad²], grown since the last comparison."""
        config, ways, turns = self._config, self._driven**2, self._turned**2
        cell = self._terrain.grid.resolution**2 / 12.0  # the map is not more accurate than that
        x, y, yaw = self._estimate.variances
        yaw += config.alpha1 * turns + config.alpha2 * ways + (config.yaw_drift * self._age) ** 2
        place = cell + config.alpha3 * ways + config.alpha4 * turns + yaw * ways
        return x + place, y + place, yaw

    def on_odom(self, odom: Odometry) -> None:
        """Receive the newest odometry, and correct the pose by a little.

        Args:
            odom: Pose in odom, and twist. The first one ties odom to the pose of the start.
        """
        before, self._pose_odom = self._pose_odom, odom.pose_odom
        if before is None:
            self._map_from_odom = self._target = self._start.compose(odom.pose_odom.inverse())
            self._record_comparison()
            return
        if abs(odom.twist.vx) < STILL_SPEED and abs(odom.twist.wz) < STILL_RATE:
            self._ignore(before, odom.pose_odom)
            self._correct()
            return
        self._moving_ticks += 1
        self._driven += before.distance(odom.pose_odom)
        self._turned += abs(wrap_angle(odom.pose_odom.yaw - before.yaw))
        self._correct()

    def _ignore(self, before: Pose, after: Pose) -> None:
        """Count a change of odometry as drift of the gyro, since the robot stands."""
        drift = before.compose(after.inverse())  # odom before from odom after
        self._map_from_odom = self._map_from_odom.compose(drift)
        self._target = self._target.compose(drift)
        self._last_odom = drift.inverse().compose(self._last_odom)

    def on_scan(self, scan: Scan) -> None:
        """Compare the newest scan with the map, if it is time to."""
        is_vague = self._deviation > self._config.lost_deviation
        self._vague_scans = self._vague_scans + 1 if is_vague else 0
        if self._pose_odom is None or not self._is_due:
            return
        hits = self._select(scan)
        has_hits = len(hits) >= FEWEST_BEAMS
        if not has_hits and self._driven < self._config.update_min_d:
            return
        power, is_searching = self._power, self._is_searching
        self._filter.move(self._step)
        self._record_comparison()
        if has_hits:
            self._first_scans = max(0, self._first_scans - 1)
            self._compare(hits, power, is_searching=is_searching)
        else:
            self._estimate = self._filter.unweighed()

    def _compare(self, hits: FloatArray, power: float, *, is_searching: bool) -> None:
        """Adopt the estimate of the particles after a scan, and resample them."""
        config = self._config
        field = field_for(self._terrain, config, self._lidar.range_max)
        self._estimate, weights = self._filter.weigh(hits, field, power, is_searching=is_searching)
        best = self._estimate.pose_map
        self._target = best.compose(self._odom.inverse())
        self._judge(hits, best)
        fresh = 0.0  # elsewhere new particles would only blur the estimate
        if self._fast_fit < config.lost_fit:
            fresh = min(MOST_FRESH, max(0.0, 1.0 - self._fast_fit / self._slow_fit))
        self._filter.draw(weights, self._estimate, fresh, is_searching=is_searching)

    def _judge(self, hits: FloatArray, best: Pose) -> None:
        """Record how well a scan fits the map at the best pose."""
        config = self._config
        if len(hits) * JUDGING_SHARE < len(self._hits):
            return  # it may as well be people or robots
        field = field_for(self._terrain, config, self._lidar.range_max)
        at = Place(best.x, best.y, best.yaw)
        self._fit = amcl_kernels.fit(at, hits, field.log, field.frame, field.weights)
        self._slow_fit += config.recovery_alpha_slow * (self._fit - self._slow_fit)
        self._fast_fit += config.recovery_alpha_fast * (self._fit - self._fast_fit)

    @property
    def _odom(self) -> Pose:
        return self._pose_odom or ORIGIN

    @property
    def _best(self) -> Pose:
        """Estimate of the last comparison for the present pose."""
        return self._target.compose(self._odom)

    @property
    def _step(self) -> Step:
        motion = self._last_odom.inverse().compose(self._odom)
        return Step(motion, self._driven, self._turned, self._age)

    @property
    def _age(self) -> float:
        """Time [s] of motion since the last comparison."""
        return self._moving_ticks * CONTROL_PERIOD

    @property
    def _is_searching(self) -> bool:
        """Report whether a pose was given just now, or scans do not fit the map."""
        return self._first_scans > 0 or self._fast_fit < self._config.lost_fit

    @property
    def _is_due(self) -> bool:
        config = self._config
        return (
            self._is_searching
            or self._fit < config.lost_fit
            or self._driven >= config.update_min_d
            or self._turned >= config.update_min_a
            or self._age >= config.update_period
        )

    @property
    def _power(self) -> float:
        """Return by how much the next scan is a new view: scans from one place share errors."""
        if self._is_searching:
            return 1.0
        moved = self._odom.distance(self._last_odom) / self._config.update_min_d
        return min(1.0, max(LEAST_POWER, moved))

    def _begin(self, pose_map: Pose, deviation: tuple[float, float]) -> None:
        """Draw the particles around a pose."""
        place, yaw = deviation
        is_wide = place > 2.0 * START_DEVIATION[0] or yaw > 2.0 * START_DEVIATION[1]
        self._filter.scatter(pose_map, deviation, is_wide=is_wide)
        self._estimate = Estimate(pose_map, (place**2, place**2, yaw**2))
        self._slow_fit = self._fast_fit = self._fit = EXPECTED_FIT
        self._first_scans, self._vague_scans = FIRST_SCANS, 0
        self._record_comparison()

    def _record_comparison(self) -> None:
        """Count way, turns and time from here."""
        self._last_odom, self._moving_ticks = self._odom, 0
        self._driven = self._turned = 0.0

    def _correct(self) -> None:
        """Move the pose a little towards the best one."""
        if self.wants_leap or self._map_from_odom == self._target:
            return
        nudged_map = nudged(self.pose_map, self._best)
        if nudged_map is None:
            self._map_from_odom = self._target
        else:
            self._map_from_odom = nudged_map.compose(self._odom.inverse())

    def _select(self, scan: Scan) -> FloatArray:
        """Return the hits (k, 2) in base_footprint that no known robot explains."""
        best = self._best
        count = amcl_kernels.beams(
            np.array(scan.ranges, np.float32),  # a message's buffer may be read-only
            amcl_kernels.Rays(scan.angle_min, scan.angle_increment, scan.range_min, scan.range_max),
            scan.tick,
            Place(self._lidar.x, self._lidar.y, self._lidar.yaw),
            Place(best.x, best.y, best.yaw),
            *self._neighbors.bodies(),
            self._hits,
        )
        return self._hits[:count]


def is_leap(now: Pose, best: Pose) -> bool:
    """Whether a correction is too large to drive on meanwhile."""
    return best.distance(now) > LEAP or abs(wrap_angle(best.yaw - now.yaw)) > SPIN


def nudged(now: Pose, best: Pose) -> Pose | None:
    """Return a pose moved towards a better one by as much as one tick may correct.

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
