"""The localisation kernels against their slow twins, and what their random numbers are like."""

import math

import numpy as np
import pytest

from swarm_nav.localisation import amcl_kernels as kernels
from swarm_nav.planning.distance_kernels import Frame, Place
from tests.oracles import amcl as oracle

FRAME = Frame(-1.0, 0.5, 0.05)
WEIGHTS = kernels.HitWeights(0.5, 0.14)


def state(seed=1):
    return np.array([seed], np.uint64)


def field(rng):
    distance = rng.uniform(-0.3, 1.0, (40, 50))
    out = np.empty(distance.shape, np.float32)
    kernels.likelihood(distance, 0.1, WEIGHTS, 0.5, out)
    assert out == pytest.approx(oracle.likelihood(distance, 0.1, WEIGHTS, 0.5), abs=1e-6)
    return out


@pytest.mark.parametrize("seed", range(6))
@pytest.mark.parametrize("skip", [(-9.0, 0.0, 0.9), (-0.7, 0.3, 0.9), (-0.7, 0.6, 0.2)])
def test_weights_equal_those_of_the_slow_twin(seed, skip):
    rng = np.random.default_rng(seed)
    log = field(rng)
    particles = rng.uniform((-0.2, 1.2, -4.0), (0.7, 1.8, 4.0), (12, 3))
    points = rng.uniform(-0.4, 0.4, (9, 2))
    weights = np.empty(12)
    scores = np.empty((12, 9), np.float32)
    kernels.weigh(
        particles,
        points,
        log,
        FRAME,
        kernels.BeamSkipping(*skip),
        kernels.Trust(0.7, 0.0),
        scores,
        weights,
    )
    expected = oracle.weights_of(particles, points, log, FRAME, skip, 0.7)
    assert weights == pytest.approx(expected, rel=1e-3, abs=1e-9)


def test_a_scan_is_trusted_less_where_too_few_particles_would_be_left():
    rng = np.random.default_rng(3)
    particles = rng.uniform((-1.0, 0.5, -4.0), (1.5, 2.5, 4.0), (100, 3))
    weights, scores = np.empty(100), np.empty((100, 40), np.float32)
    points = rng.uniform(-1.0, 1.0, (40, 2))
    skip = (-9.0, 0.0, 0.9)
    kernels.weigh(
        particles,
        points,
        field(rng),
        FRAME,
        kernels.BeamSkipping(*skip),
        kernels.Trust(1.0, 20.0),
        scores,
        weights,
    )
    assert weights.sum() == pytest.approx(1.0)
    assert 1.0 / (weights**2).sum() >= 20.0


@pytest.mark.parametrize("seed", range(8))
def test_beams_equal_those_of_the_slow_twin(seed):
    rng = np.random.default_rng(seed)
    ranges = rng.uniform(0.0, 5.0, 90).astype(np.float32)
    ranges[rng.integers(0, 90, 30)] = rng.choice([np.nan, np.inf, -np.inf], 30)
    beam = kernels.Rays(-0.3, math.tau / 90, 0.12, 3.5)
    lidar, pose = Place(-0.06, 0.02, 0.3), Place(1.0, 2.0, -2.0)
    robots = [(0.0, 2.5, 0.7), (2.0, 1.0, 0.5)]
    places, reach = np.array(robots)[:, :2], np.array(robots)[:, 2]
    out = np.empty((15, 2))
    count = kernels.beams(ranges, beam, seed, lidar, pose, places, reach, out)
    expected = oracle.beams(ranges, beam, seed, lidar, pose, robots, 15)
    assert out[:count] == pytest.approx(expected, abs=1e-5)


def test_random_numbers_are_uniform_and_normal_and_follow_from_the_counter():
    counter = state(7)
    drawn = np.array([kernels.uniform(counter) for _ in range(20_000)])
    normals = np.array([kernels.normal(counter) for _ in range(20_000)])
    assert 0.0 <= drawn.min() <= drawn.max() < 1.0
    assert (drawn.mean(), drawn.std()) == pytest.approx((0.5, 12**-0.5), abs=0.01)
    assert (normals.mean(), normals.std()) == pytest.approx((0.0, 1.0), abs=0.02)
    assert kernels.uniform(state(7)) == drawn[0] != kernels.uniform(state(8))


def test_particles_move_by_odometry_and_its_noise():
    particles = np.zeros((20_000, 3))
    particles[:, 2] = math.pi / 2
    noise = kernels.Noise(0.02, 0.05, 0.03, 0.0, 0.0)
    kernels.move(particles, kernels.Motion(0.1, 1.0, 0.2, 0.0), noise, state())
    ahead = math.pi / 2 + 0.1
    assert particles.mean(axis=0) == pytest.approx(
        (math.cos(ahead), math.sin(ahead), math.pi / 2 + 0.3), abs=0.002
    )
    ways = np.hypot(particles[:, 0], particles[:, 1])
    assert ways.std() == pytest.approx(0.05, rel=0.05)
    assert particles[:, 2].std() == pytest.approx(math.hypot(0.02, 0.03), rel=0.05)


def test_the_estimate_is_the_densest_place_and_the_variances_tell_of_others():
    rng = np.random.default_rng(0)
    near = rng.normal((1.0, 2.0, math.pi - 0.01), 0.02, (300, 3))
    far = rng.normal((3.0, 2.0, 0.0), 0.02, (100, 3))
    out = np.empty(6)
    kernels.estimate(np.vstack([near, far]), np.full(400, 1.0 / 400), out)
    assert out[:2] == pytest.approx((1.0, 2.0), abs=0.01)
    assert abs(kernels.wrap(out[2] - math.pi + 0.01)) < 0.01
    assert out[3] == pytest.approx(0.25 * 2.0**2, rel=0.05)
    assert out[4] < 0.01


def test_few_particles_do_for_a_narrow_cloud_and_many_for_a_wide_one():
    rng = np.random.default_rng(0)
    sizes, fresh = kernels.ParticleCounts(50, 1000, 0.05, 2.33), kernels.Fresh(0.0, 0.0, 0.0)
    center = Place(0.0, 0.0, 0.0)
    counts = []
    for spread in (0.01, 1.0):
        particles = rng.normal(0.05, spread, (400, 3))
        out = np.empty((1000, 3))
        counts.append(
            kernels.resample(particles, np.full(400, 1 / 400), sizes, fresh, center, state(), out)
        )
    assert counts == [50, 1000]
    assert kernels.needed(100, 0.05, 2.33) == pytest.approx(1326, rel=0.02)


def test_heavy_particles_are_drawn_as_often_as_their_weight_says():
    particles = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0]])
    out = np.empty((5000, 3))
    count = kernels.resample(
        particles, np.array([0.2, 0.8]), kernels.ParticleCounts(5000, 5000, 0.05, 2.33),
        kernels.Fresh(0.0, 0.0, 0.0), Place(0.0, 0.0, 0.0), state(), out,
    )  # fmt: skip
    assert count == 5000
    assert out[:, 0].mean() == pytest.approx(0.8, abs=0.02)
