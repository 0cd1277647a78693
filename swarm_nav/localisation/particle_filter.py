"""The particles of Monte Carlo localisation: moved by odometry, weighted by scans, resampled."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from swarm_common.model.records import FloatArray, Pose
from swarm_nav.core.localisation_config import LocalisationConfig
from swarm_nav.localisation import amcl_kernels
from swarm_nav.localisation.likelihood import LikelihoodField
from swarm_nav.planning.distance_kernels import Place

FLOOR, FLOOR_YAW = 0.002, 0.001  # [m], [rad] that each step adds, so that particles stay apart
EFFECTIVE = 0.05  # share of the particles that matter after a scan, at least; fewer starve
BLUR = 0.25  # of the particles' spread, by which those drawn while searching are scattered
STILL = amcl_kernels.Noise(0.0, 0.0, 0.0, 0.0, 0.0)


@dataclass(frozen=True, slots=True)
class Step:
    """Odometry since the last scan that was compared."""

    motion: Pose  # of base_footprint, in its frame at that time
    driven: float  # [m] of way
    turned: float  # [rad] of all turns, in whichever direction
    age: float  # [s] of motion


@dataclass(frozen=True, slots=True)
class Estimate:
    """Estimate of the particles: a pose in map, and the variances [m²], [rad²] around it."""

    pose_map: Pose
    variances: tuple[float, float, float]


class ParticleFilter:
    """Some hundred hypotheses of where the robot is."""

    def __init__(self, config: LocalisationConfig, seed: int, *, is_omni: bool) -> None:
        """Start without particles; `scatter` draws them.

        Args:
            is_omni: Whether the robot drives sideways.
        """
        self._is_omni = is_omni
        self._state = np.array([seed], np.uint64)
        self._particles: FloatArray = np.zeros((1, 3))
        self._guess = np.zeros(6)
        self.configure(config)

    def configure(self, config: LocalisationConfig) -> None:
        """Apply new parameters, effective from the next scan.

        Args:
            config: `localisation.` parameters.
        """
        most = config.max_particles
        self._config = config
        self._drawn, self._weights = np.empty((most, 3)), np.empty(most)
        self._scores = np.empty((most, config.max_beams), np.float32)
        self._particles = self._particles[:most]

    def scatter(self, pose_map: Pose, deviation: tuple[float, float], *, is_wide: bool) -> None:
        """Draw the particles around a pose.

        Args:
            deviation: ([m], [rad]) standard deviations within which it is known.
            is_wide: Whether to draw the largest number of particles instead of the smallest.
        """
        config, (place, yaw) = self._config, deviation
        count = config.max_particles if is_wide else config.min_particles
        self._particles = np.empty((count, 3))
        mean = Place(pose_map.x, pose_map.y, pose_map.yaw)
        spread = amcl_kernels.Spread(place, place, yaw)
        amcl_kernels.scatter(self._particles, mean, spread, self._state)

    def at(self, motion: Pose) -> FloatArray:
        """Return the particles after a motion, without noise.

        Args:
            motion: Motion of base_footprint, in its frame before the motion.

        Returns:
            (k, 3) x, y [m], yaw [rad] in map.
        """
        moved = self._particles.copy()
        step = amcl_kernels.Motion(0.0, motion.x, motion.yaw, motion.y)
        amcl_kernels.move(moved, step, STILL, self._state.copy())
        return moved

    def move(self, step: Step) -> None:
        """Move the particles by odometry and its noise (AMCL's motion model).

        Args:
            step: Odometry since the last call.
        """
        config = self._config
        turns, ways = step.turned**2, step.driven**2
        turning = config.alpha1 * turns + config.alpha2 * ways
        turning += (config.yaw_drift * step.age) ** 2 + FLOOR_YAW**2
        half = math.sqrt(0.5 * turning)  # one half before the way, the other one after it
        driving = math.sqrt(config.alpha3 * ways + config.alpha4 * turns)
        sliding = math.sqrt(config.alpha5 * ways) if self._is_omni else 0.0
        motion = amcl_kernels.Motion(0.0, step.motion.x, step.motion.yaw, step.motion.y)
        noise = amcl_kernels.Noise(half, driving, half, sliding, FLOOR)
        amcl_kernels.move(self._particles, motion, noise, self._state)

    def unweighed(self) -> Estimate:
        """Return the estimate of the particles as they are."""
        count = len(self._particles)
        return self._estimate(np.full(count, 1.0 / count))

    def weigh(
        self, hits: FloatArray, field: LikelihoodField, power: float, *, is_searching: bool
    ) -> tuple[Estimate, FloatArray]:
        """Return the estimate of the particles after a scan, and their weights for `draw`.

        Args:
            hits: Points (k, 2) in base_footprint.
            power: Weight of the scan as a new view, 0 to 1.
            is_searching: Whether most particles may be wrong, so that all hits count.
        """
        config = self._config
        weights = self._weights[: len(self._particles)]
        may_skip = config.do_beamskip and not is_searching
        share = config.beam_skip_threshold if may_skip else 0.0
        skip = amcl_kernels.BeamSkipping(field.agreement, share, config.beam_skip_error_threshold)
        trust = amcl_kernels.Trust(power, EFFECTIVE * len(weights))
        amcl_kernels.weigh(
            self._particles, hits, field.log, field.frame, skip, trust, self._scores, weights
        )
        return self._estimate(weights), weights

    def draw(
        self, weights: NDArray[np.float64], estimate: Estimate, fresh: float, *, is_searching: bool
    ) -> None:
        """Resample the particles by weight.

        Args:
            weights: (n,) of the present ones, as `weigh` returned them.
            fresh: Share of them that is drawn around that instead.
            is_searching: Whether to scatter them, since the right place may be between them.
        """
        config, best = self._config, estimate.pose_map
        count = amcl_kernels.resample(
            self._particles,
            weights,
            amcl_kernels.ParticleCounts(
                config.min_particles, config.max_particles, config.pf_err, config.pf_z
            ),
            amcl_kernels.Fresh(fresh, config.recovery_spread, config.recovery_spread_yaw),
            Place(best.x, best.y, best.yaw),
            self._state,
            self._drawn,
        )
        self._particles = self._drawn[:count].copy()
        if is_searching:
            spread = BLUR * np.sqrt(estimate.variances)
            amcl_kernels.blur(self._particles, spread, self._state)

    def _estimate(self, weights: FloatArray) -> Estimate:
        amcl_kernels.estimate(self._particles, weights, self._guess)
        x, y, yaw, *variances = self._guess.tolist()
        return Estimate(Pose(x, y, yaw), (variances[0], variances[1], variances[2]))
