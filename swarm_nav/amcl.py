"""Adaptive Monte Carlo localisation (Fox 2003; Thrun, Burgard, Fox 2005) on a likelihood field.

Between two comparisons with the map the robot goes by its odometry. What a comparison finds
enters the pose bit by bit, so that the robot does not leap out of the space that it holds; a
large correction waits until the robot stands.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from swarm_common.records import (
    CONTROL_PERIOD,
    FloatArray,
    Odometry,
    Pose,
    RobotSpec,
    Scan,
    wrap_angle,
)
from swarm_nav import amcl_kernels
from swarm_nav.likelihood import LikelihoodField, field_for
from swarm_nav.localisation import START_DEVIATION
from swarm_nav.localisation_config import LocalisationConfig
from swarm_nav.neighborhood import Neighborhood
from swarm_nav.obstacles import BODY_REACH, TRAVEL_PER_TICK
from swarm_nav.terrain import Terrain

FIRST_SCANS = 8  # after a pose was given, that count in full though the robot stands
EFFECTIVE = 0.05  # share of the particles that matter after a scan, at least; fewer starve
BLUR = 0.25  # of the particles' spread, by which those drawn while searching are scattered
LEAST_POWER = 0.05  # of a scan from a place where others were compared before
FEWEST_BEAMS = 8  # hits of mapped walls below which a scan tells nothing
STEP, TURN = 0.005, 0.01  # [m] and [rad] by which a tick may correct the pose
LEAP, SPIN = 0.10, 0.25  # [m] and [rad] beyond which a correction waits for a standstill
FLOOR = 0.003  # [m] and [rad] of noise that each comparison adds, so that particles stay apart
GROWTH = 0.005  # [m] of margin announced ahead, so that all know it before it is needed
EXPECTED_FIT = 0.9  # of a scan at the right place
DEADBAND = 0.1  # of the ratio of both means of the fit, within which nothing is drawn anew
MOST_FRESH = 0.5  # share of the particles that is drawn anew at most


class AmclLocaliser:
    """Particles in map, the pose that they stand for, and whether it can be trusted."""

    def __init__(
        self,
        pose_map: Pose,
        config: LocalisationConfig,
        spec: RobotSpec,
        terrain: Terrain,
        hood: Neighborhood,
        robot_id: int,
    ) -> None:
        """Start at a pose that is known about as well as `START_DEVIATION` says.

        Args:
            pose_map: Of base_footprint.
            config: Parameters.
            spec: Its LiDAR and drive count.
            terrain: Of the map.
            hood: Whose robots explain hits.
            robot_id: For random numbers of its own.
        """
        lidar = spec.lidar
        self._spec = spec
        self._lidar = (lidar.x, lidar.y, lidar.yaw)
        self._hood = hood
        self._terrain = terrain
        self._state = np.array([config.random_seed * 1_000_003 + robot_id], np.uint64)
        self._scores = np.empty((1, 1), np.float32)
        self._guess = np.zeros(6)  # x, y, yaw and their variances at the last comparison
        self._pose_odom: Pose | None = None  # None before the first odometry
        self._last_odom = Pose(0.0, 0.0, 0.0)
        self._tick = self._last_tick = 0
        self._map_from_odom = self._target = self._start = pose_map
        self.configure(config)
        self._begin(pose_map, START_DEVIATION)

    def configure(self, config: LocalisationConfig) -> None:
        """Take new parameters, effective from the next scan."""
        self._config = config
        self._hits = np.empty((min(config.max_beams, self._spec.lidar.rays), 2))
        self._other = np.empty((config.max_particles, 3))
        self._weights = np.empty(config.max_particles)
        self._field: LikelihoodField | None = None

    def load_map(self, terrain: Terrain) -> None:
        """Take another map; the pose stays."""
        self._terrain, self._field = terrain, None

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
        config = self._config
        is_unfit = self._fast_fit < config.lost_fit
        return is_unfit or self._raw_margin > config.lost_margin or self.wants_leap

    @property
    def wants_leap(self) -> bool:
        """Whether the pose is to be corrected by so much that the robot has to stand for it."""
        best, now = self._best, self.pose_map
        return best.distance(now) > LEAP or abs(wrap_angle(best.yaw - now.yaw)) > SPIN

    @property
    def margin(self) -> float:
        """Safety margin [m] that tracking and localisation need."""
        return min(self._raw_margin, self._config.lost_margin)

    @property
    def _raw_margin(self) -> float:
        config = self._config
        x, y, _ = self.variances()
        sigma = math.sqrt(max(x, y))
        rest = self._best.distance(self.pose_map)
        return config.tracking_margin + config.margin_per_sigma * sigma + rest + GROWTH

    @property
    def _odom(self) -> Pose:
        return self._pose_odom or Pose(0.0, 0.0, 0.0)

    @property
    def _best(self) -> Pose:
        """What the last comparison says about the present pose."""
        return self._target.compose(self._odom)

    def initialise(self, pose_map: Pose, deviation: tuple[float, float] = START_DEVIATION) -> None:
        """Take a pose in map for the present odometry, known to within `deviation` [m], [rad]."""
        self._map_from_odom = self._target = pose_map.compose(self._odom.inverse())
        self._begin(pose_map, deviation)

    def leap(self) -> None:
        """Correct the pose at once."""
        self._map_from_odom = self._target

    def particles(self) -> FloatArray:
        """Return hypotheses (k, 3): x, y, yaw in map."""
        return self._moved(self._particles, noise=False)

    def variances(self) -> tuple[float, float, float]:
        """Return the variances of x, y [m²] and yaw [rad²], grown since the last comparison."""
        config, way = self._config, self._way
        cell = self._terrain.grid.resolution**2 / 12.0  # the map is no better than its cells
        spread_yaw = config.alpha2 * way * way + (config.yaw_drift * self._age) ** 2
        turn = config.alpha1 * self._turned**2
        yaw = float(self._guess[5]) + spread_yaw + turn
        place = cell + config.alpha3 * way * way + config.alpha4 * self._turned**2
        place += yaw * way * way
        return float(self._guess[3]) + place, float(self._guess[4]) + place, yaw

    def on_odom(self, odom: Odometry) -> None:
        """Take the newest odometry, and correct the pose by a little."""
        if self._pose_odom is None:
            self._pose_odom = self._last_odom = odom.pose_odom
            self._map_from_odom = self._target = self._start.compose(odom.pose_odom.inverse())
            self._tick = self._last_tick = odom.tick
            return
        before = self._pose_odom
        self._way += before.distance(odom.pose_odom)
        self._turned += abs(wrap_angle(odom.pose_odom.yaw - before.yaw))
        self._pose_odom = odom.pose_odom
        self._tick = odom.tick
        self._correct()

    def on_scan(self, scan: Scan) -> None:
        """Compare the newest scan with the map, if it is time to."""
        if self._pose_odom is None or not self._is_due:
            return
        config, terrain = self._config, self._terrain
        if self._field is None:
            self._field = field_for(terrain, config, self._spec.lidar.range_max)
        hits = self._select(scan)
        self._particles = self._moved(self._particles, noise=True)
        power, is_searching = self._power, self._is_searching
        self._first_scans = max(0, self._first_scans - 1)
        self._note_step()
        weights = self._weights[: len(self._particles)]
        if len(hits) < FEWEST_BEAMS:
            weights[:] = 1.0 / len(weights)
            amcl_kernels.estimate(self._particles, weights, self._guess)
            return
        self._compare(hits, weights, self._field, power)
        if is_searching:
            spread = BLUR * np.sqrt(self._guess[3:])
            amcl_kernels.blur(self._particles, spread, self._state)

    @property
    def _is_due(self) -> bool:
        config = self._config
        turned = abs(wrap_angle(self._odom.yaw - self._last_odom.yaw))
        return (
            self._is_searching
            or self._odom.distance(self._last_odom) >= config.update_min_d
            or max(turned, 0.5 * self._turned) >= config.update_min_a
            or self._age >= config.update_period
        )

    @property
    def _is_searching(self) -> bool:
        """Whether a pose was given just now, or scans do not fit the map."""
        return self._first_scans > 0 or self._is_doubtful

    @property
    def _is_doubtful(self) -> bool:
        """Whether scans do not fit the map."""
        return min(self._fit, self._fast_fit) < self._config.lost_fit

    @property
    def _age(self) -> float:
        """Time [s] since the last comparison."""
        return (self._tick - self._last_tick) * CONTROL_PERIOD

    def _begin(self, pose_map: Pose, deviation: tuple[float, float]) -> None:
        """Draw the particles around a pose."""
        config = self._config
        place, yaw = deviation
        wide = place > 2.0 * START_DEVIATION[0] or yaw > 2.0 * START_DEVIATION[1]
        count = config.max_particles if wide else config.min_particles
        self._particles = np.empty((count, 3))
        mean = (pose_map.x, pose_map.y, pose_map.yaw)
        amcl_kernels.scatter(self._particles, mean, (place, place, yaw), self._state)
        self._guess[:3] = mean
        self._guess[3:] = place**2, place**2, yaw**2
        self._slow_fit = self._fast_fit = self._fit = EXPECTED_FIT
        self._note_step()
        self._first_scans = FIRST_SCANS

    def _note_step(self) -> None:
        """Begin to count from here."""
        self._last_odom, self._last_tick = self._odom, self._tick
        self._way = self._turned = 0.0

    def _correct(self) -> None:
        """Move the pose a little towards the best one."""
        now, best = self.pose_map, self._best
        gap, turn = now.distance(best), wrap_angle(best.yaw - now.yaw)
        if gap > LEAP or abs(turn) > SPIN or (gap == 0.0 and turn == 0.0):
            return
        share = 1.0 if gap <= STEP else STEP / gap
        corrected = Pose(
            now.x + share * (best.x - now.x),
            now.y + share * (best.y - now.y),
            wrap_angle(now.yaw + min(TURN, max(-TURN, turn))),
        )
        self._map_from_odom = corrected.compose(self._odom.inverse())

    def _select(self, scan: Scan) -> FloatArray:
        """Return the hits (k, 2) in base_footprint that no known robot explains."""
        hood = self._hood
        robots = hood.beacons["pose"][:, :2].astype(np.float64)
        reach = hood.beacons["radius"] + BODY_REACH + TRAVEL_PER_TICK * np.minimum(hood.ages, 20)
        best = self._best
        count = amcl_kernels.beams(
            np.array(scan.ranges, np.float32),
            (scan.angle_min, scan.angle_increment, scan.range_min, scan.range_max),
            scan.tick,
            self._lidar,
            (best.x, best.y, best.yaw),
            robots,
            reach,
            self._hits,
        )
        return self._hits[:count]

    def _moved(self, particles: FloatArray, *, noise: bool) -> FloatArray:
        """Return particles moved by the odometry since the last comparison."""
        config = self._config
        step = self._last_odom.inverse().compose(self._odom)
        way = math.hypot(step.x, step.y)
        moved = particles.copy()
        if not noise:
            first, second, aside, forwards = 0.0, step.yaw, step.y, step.x
            amcl_kernels.move(
                moved, (first, forwards, second, aside), (0.0,) * 5, self._state.copy()
            )
            return moved
        turned, driven = max(abs(step.yaw), self._turned), max(way, self._way)
        turn_variance = config.alpha1 * turned**2 + config.alpha2 * driven**2
        turn_variance += (config.yaw_drift * self._age) ** 2 + FLOOR**2
        way_deviation = math.sqrt(config.alpha3 * driven**2 + config.alpha4 * turned**2)
        aside = math.sqrt(config.alpha5) * driven if self._spec.is_omni else 0.0
        turn = math.sqrt(0.5 * turn_variance)
        deviations = (turn, way_deviation, turn, aside, FLOOR)
        amcl_kernels.move(moved, (0.0, step.x, step.yaw, step.y), deviations, self._state)
        return moved

    @property
    def _power(self) -> float:
        """How much of a new view the next scan is: scans from one place share their errors."""
        if self._is_searching:
            return 1.0
        config = self._config
        moved = self._way / config.update_min_d
        return min(1.0, max(LEAST_POWER, moved, self._turned / config.update_min_a))

    def _compare(
        self, hits: FloatArray, weights: FloatArray, field: LikelihoodField, power: float
    ) -> None:
        """Weigh the particles by a scan, take over the estimate, and draw them anew."""
        config = self._config
        if self._scores.shape != (config.max_particles, len(self._hits)):
            self._scores = np.empty((config.max_particles, len(self._hits)), np.float32)
        share = config.beam_skip_threshold if config.do_beamskip else 0.0
        skip = (field.agreement, share, config.beam_skip_error_threshold)
        trust = (power, EFFECTIVE * len(weights))
        amcl_kernels.weigh(
            self._particles, hits, field.log, field.frame, skip, trust, self._scores, weights
        )
        amcl_kernels.estimate(self._particles, weights, self._guess)
        best = Pose(*self._guess[:3].tolist())
        self._target = best.compose(self._odom.inverse())
        self._note_fit(hits, best, field)
        self._particles = self._drawn(weights, best)

    def _note_fit(self, hits: FloatArray, best: Pose, field: LikelihoodField) -> None:
        pose = (best.x, best.y, best.yaw)
        self._fit = fit = amcl_kernels.fit(pose, hits, field.log, field.frame, field.weights)
        config = self._config
        self._slow_fit += config.recovery_alpha_slow * (fit - self._slow_fit)
        self._fast_fit += config.recovery_alpha_fast * (fit - self._fast_fit)

    def _drawn(self, weights: FloatArray, best: Pose) -> FloatArray:
        """Return particles drawn by weight, some of them anew if scans no longer fit."""
        config = self._config
        share = max(0.0, 1.0 - self._fast_fit / self._slow_fit - DEADBAND)
        fresh = (min(share, MOST_FRESH), config.recovery_spread, config.recovery_spread_yaw)
        sizes = (config.min_particles, config.max_particles, config.pf_err, config.pf_z)
        count = amcl_kernels.resample(
            self._particles,
            weights,
            sizes,
            fresh,
            (best.x, best.y, best.yaw),
            self._state,
            self._other,
        )
        drawn: NDArray[np.float64] = self._other[:count].copy()
        return drawn
