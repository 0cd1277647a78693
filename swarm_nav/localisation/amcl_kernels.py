"""Bare numba kernels of Monte Carlo localisation; the checked face is in amcl.py.

Particles are rows x, y, yaw in map. Random numbers come from a counter (SplitMix64) that each
robot has for itself, so that robots in one process do not disturb each other's.
Args of more than one kernel:
    field: (h, w) log likelihood, see `likelihood`.
    particles: (n, 3) x, y [m], yaw [rad]; changed.
    points: Hits (b, 2) [m] in base_footprint.
    state: (1,) counter of the random numbers; changed.
    weights: (n,), their sum is 1.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from swarm_common.process.numba_compat import njit
from swarm_nav.planning.distance_kernels import Floats, Frame, Place, sample

GOLDEN = np.uint64(0x9E3779B97F4A7C15)
FIRST = np.uint64(0xBF58476D1CE4E5B9)
SECOND = np.uint64(0x94D049BB133111EB)
BIN = 0.2  # [m] of KLD sampling's cells, and
YAW_BIN = math.radians(10.0)  # [rad]
TABLE = 8192  # slots of its hash table
REACH = 0.3  # [m] and [rad] around the heaviest place that the estimate is the mean of
ROUNDS = 4  # in which that place is moved to the mean
CANDIDATES = 20  # particles, drawn evenly by weight, around which the heaviest place is looked for


class Motion(NamedTuple):
    """A motion in four parts: turn, drive, turn, slide; [rad] and [m]."""

    first: float
    way: float
    second: float
    aside: float


class Noise(NamedTuple):
    """Standard deviations of the parts of a motion, and of the place after it."""

    first: float  # [rad]
    way: float  # [m]
    second: float  # [rad]
    aside: float  # [m]
    place: float  # [m]


class Spread(NamedTuple):
    """Standard deviations, [m] and [rad]."""

    x: float
    y: float
    yaw: float


class HitWeights(NamedTuple):
    """Shares of a beam's likelihood (Thrun, Burgard, Fox 2005, ch. 6)."""

    hit: float  # z_hit
    other: float  # z_rand / range_max


class Rays(NamedTuple):
    """Directions and range of a LiDAR."""

    angle_min: float  # [rad] of the first ray, in the LiDAR's frame
    angle_increment: float  # [rad]
    range_min: float  # [m]
    range_max: float  # [m]


class BeamSkipping(NamedTuple):
    """Hits that are left out."""

    agreement: float  # log likelihood from which a particle agrees with a hit
    share: float  # of particles that must agree
    error: float  # share of hits left out from which all count again


class Trust(NamedTuple):
    """Trust in a scan."""

    power: float  # how much of a new view the scan is, 0 to 1
    fewest: float  # particles that are to matter in effect; else the power is reduced


class ParticleCounts(NamedTuple):
    """Size of the set of particles (KLD sampling, Fox 2003)."""

    fewest: int
    most: int
    error: float
    z: float  # quantile of the confidence


class Fresh(NamedTuple):
    """Particles that are drawn around a pose instead."""

    share: float
    spread: float  # [m]
    spread_yaw: float  # [rad]


@njit(cache=True)
def uniform(state: NDArray[np.uint64]) -> float:
    """Return a random number in [0, 1).

    Args:
        state: (1,) uint64 counter, advanced by one step.
    """
    state[0] = state[0] + GOLDEN
    word = state[0]
    word = (word ^ (word >> np.uint64(30))) * FIRST
    word = (word ^ (word >> np.uint64(27))) * SECOND
    word = word ^ (word >> np.uint64(31))
    return float(word >> np.uint64(11)) * 2.0**-53


@njit(cache=True)
def normal(state: NDArray[np.uint64]) -> float:
    """Return a standard normal random number (Box and Muller).

    Args:
        state: See `uniform`.
    """
    first = 1.0 - uniform(state)
    return math.sqrt(-2.0 * math.log(first)) * math.cos(2.0 * math.pi * uniform(state))


@njit(cache=True)
def wrap(angle: float) -> float:
    """Return an angle [rad] in [-π, π).

    Args:
        angle: [rad].
    """
    return (angle + math.pi) % (2.0 * math.pi) - math.pi


@njit(cache=True)
def scatter(particles: Floats, mean: Place, spread: Spread, state: NDArray[np.uint64]) -> None:
    """Draw all particles (n, 3) around a pose in map.

    Args:
        particles: (n, 3) x, y [m], yaw [rad]; written.
    """
    for k in range(particles.shape[0]):
        for axis in range(3):
            particles[k, axis] = mean[axis] + spread[axis] * normal(state)


@njit(cache=True)
def blur(particles: Floats, spread: Floats, state: NDArray[np.uint64]) -> None:
    """Add normal noise to particles.

    Args:
        spread: (3,) standard deviations of these.
    """
    for k in range(particles.shape[0]):
        for axis in range(3):
            particles[k, axis] += spread[axis] * normal(state)


@njit(cache=True)
def move(particles: Floats, step: Motion, noise: Noise, state: NDArray[np.uint64]) -> None:
    """Move particles (n, 3) by an odometry step with noise.

    Thrun, Burgard, Fox 2005, table 5.6. The way lies in the direction after the first turn.
    """
    for k in range(particles.shape[0]):
        first = step.first + noise.first * normal(state)
        way = step.way + noise.way * normal(state)
        second = step.second + noise.second * normal(state)
        aside = step.aside + noise.aside * normal(state)
        heading = particles[k, 2] + first
        cos, sin = math.cos(heading), math.sin(heading)
        particles[k, 0] += way * cos - aside * sin + noise.place * normal(state)
        particles[k, 1] += way * sin + aside * cos + noise.place * normal(state)
        particles[k, 2] = wrap(heading + second)


@njit(cache=True)
def likelihood(
    distance: Floats, sigma: float, weights: HitWeights, most: float, out: NDArray[np.float32]
) -> None:
    """Write the logarithm of each cell's likelihood of a hit, 0 on a wall.

    log((hit exp(-d² / 2σ²) + other) / (hit + other)) with the distance d from the nearest wall.

    Args:
        distance: (h, w) [m] from the nearest wall, negative inside.
        sigma: [m].
        most: [m] up to which distances count.
        out: (h, w) to fill.
    """
    hit, other = weights.hit, weights.other
    for r in range(distance.shape[0]):
        for c in range(distance.shape[1]):
            d = min(abs(distance[r, c]), most)
            p = hit * math.exp(-0.5 * d * d / (sigma * sigma)) + other
            out[r, c] = math.log(p / (hit + other))


@njit(cache=True)
def beams(
    ranges: NDArray[np.float32],
    beam: Rays,
    offset: int,
    lidar: Place,
    pose: Place,
    robots: Floats,
    reach: Floats,
    out: Floats,
) -> int:
    """Write the hits to compare with the map; return their number.

    One ray of each of len(out) equal sectors: the first that hit something which no known robot
    explains.

    Args:
        ranges: (n,) [m].
        offset: Index of the first ray in its sector.
        robots: Centres (m, 2) [m] in map of discs.
        reach: Radii (m,) [m] of these.
        out: Receives points (k, 2) [m] in base_footprint.
    """
    rays, sectors = ranges.shape[0], out.shape[0]
    cos, sin = math.cos(pose.yaw), math.sin(pose.yaw)
    count = 0
    for sector in range(sectors):
        begin, end = sector * rays // sectors, (sector + 1) * rays // sectors
        for i in range(end - begin):
            k = begin + (i + offset) % (end - begin)
            r = ranges[k]
            if not (beam.range_min <= r < beam.range_max):
                continue
            angle = lidar.yaw + beam.angle_min + k * beam.angle_increment
            x = lidar.x + r * math.cos(angle)
            y = lidar.y + r * math.sin(angle)
            x_map = pose.x + cos * x - sin * y
            y_map = pose.y + sin * x + cos * y
            is_robot = False
            for j in range(robots.shape[0]):
                dx, dy = x_map - robots[j, 0], y_map - robots[j, 1]
                if dx * dx + dy * dy < reach[j] * reach[j]:
                    is_robot = True
                    break
            if not is_robot:
                out[count, 0] = x
                out[count, 1] = y
                count += 1
                break
    return count


@njit(cache=True)
def weigh(
    particles: Floats,
    points: Floats,
    field: NDArray[np.float32],
    frame: Frame,
    skip: BeamSkipping,
    trust: Trust,
    scores: Floats,
    weights: Floats,
) -> float:
    """Write the normalised weights of particles; return the share of hits left out.

    Args:
        particles: Poses (n, 3) in map.
        scores: Scratch (n, b).
        weights: (n,) to fill.
    """
    n, b = particles.shape[0], points.shape[0]
    power, fewest = trust.power, trust.fewest
    left_out = 0
    use = np.ones(b, np.bool_)
    agreeing = np.zeros(b, np.int64)
    for k in range(n):
        cos, sin = math.cos(particles[k, 2]), math.sin(particles[k, 2])
        for i in range(b):
            x = particles[k, 0] + cos * points[i, 0] - sin * points[i, 1]
            y = particles[k, 1] + sin * points[i, 0] + cos * points[i, 1]
            scores[k, i] = sample(field, frame, x, y)
            if scores[k, i] >= skip.agreement:
                agreeing[i] += 1
    for i in range(b):
        if agreeing[i] < skip.share * n:
            use[i] = False
            left_out += 1
    if left_out > skip.error * b:
        use[:] = True
    best = -1e30
    for k in range(n):
        total = 0.0
        for i in range(b):
            if use[i]:
                total += scores[k, i]
        weights[k] = total
        best = max(best, total)
    for k in range(n):
        weights[k] -= best
    while True:
        total, squares = 0.0, 0.0
        for k in range(n):
            weight = math.exp(power * weights[k])
            total += weight
            squares += weight * weight
        if total * total >= fewest * squares:
            break
        power *= 0.7
    for k in range(n):
        weights[k] = math.exp(power * weights[k]) / total
    return left_out / max(1, b)


@njit(cache=True)
def estimate(particles: Floats, weights: Floats, out: Floats) -> None:
    """Write the densest place of the particles, and the variances of all around it.

    The place is the mean of the particles near the one with the heaviest neighbourhood, moved to
    that mean a few times.

    Args:
        particles: (n, 3) x, y [m], yaw [rad] in map.
        out: (6,) receives x, y, yaw, and the variances of x, y [m²], yaw [rad²].
    """
    x, y, yaw = 0.0, 0.0, 0.0
    heaviest, passed, candidate = -1.0, 0.0, 0
    for k in range(weights.shape[0]):
        passed += weights[k]
        if passed * CANDIDATES < candidate + 0.5:
            continue
        candidate = math.floor(passed * CANDIDATES + 0.5)
        mass = 0.0
        for j in range(weights.shape[0]):
            ex, ey = particles[j, 0] - particles[k, 0], particles[j, 1] - particles[k, 1]
            turn = wrap(particles[j, 2] - particles[k, 2])
            if ex * ex + ey * ey < REACH * REACH and abs(turn) < REACH:
                mass += weights[j]
        if mass > heaviest:
            heaviest, x, y, yaw = mass, particles[k, 0], particles[k, 1], particles[k, 2]
    for _ in range(ROUNDS):
        total, dx, dy, dyaw = 0.0, 0.0, 0.0, 0.0
        for k in range(weights.shape[0]):
            ex, ey = particles[k, 0] - x, particles[k, 1] - y
            turn = wrap(particles[k, 2] - yaw)
            if ex * ex + ey * ey < REACH * REACH and abs(turn) < REACH:
                total += weights[k]
                dx += weights[k] * ex
                dy += weights[k] * ey
                dyaw += weights[k] * turn
        if total > 0.0:
            x, y, yaw = x + dx / total, y + dy / total, wrap(yaw + dyaw / total)
    out[0], out[1], out[2] = x, y, yaw
    out[3:] = 0.0
    for k in range(weights.shape[0]):
        out[3] += weights[k] * (particles[k, 0] - x) ** 2
        out[4] += weights[k] * (particles[k, 1] - y) ** 2
        out[5] += weights[k] * wrap(particles[k, 2] - yaw) ** 2


@njit(cache=True)
def fit(
    pose: Place, points: Floats, field: NDArray[np.float32], frame: Frame, weights: HitWeights
) -> float:
    """Return the mean over hits of exp(-d² / 2σ²) at a pose: 1 if all lie on mapped walls."""
    hit, other = weights.hit, weights.other
    cos, sin = math.cos(pose.yaw), math.sin(pose.yaw)
    total = 0.0
    for i in range(points.shape[0]):
        x = pose.x + cos * points[i, 0] - sin * points[i, 1]
        y = pose.y + sin * points[i, 0] + cos * points[i, 1]
        p = (hit + other) * math.exp(sample(field, frame, x, y)) - other
        total += p / hit
    return total / max(1, points.shape[0])


@njit(cache=True)
def needed(bins: int, error: float, z: float) -> int:
    """Number of particles for an error with a confidence (KLD sampling: Fox 2003, equation 7).

    Args:
        bins: Cells of the histogram that hold a particle.
        error: Largest Kullback-Leibler distance.
        z: Quantile of the normal distribution for the confidence.
    """
    if bins <= 1:
        return 1
    part = 2.0 / (9.0 * (bins - 1))
    return math.ceil((bins - 1) / (2.0 * error) * (1.0 - part + math.sqrt(part) * z) ** 3)


@njit(cache=True)
def is_new_bin(pose: Floats, table: NDArray[np.int64]) -> bool:
    """Enter the histogram cell of a pose into a hash table; return whether it was not there.

    Args:
        pose: (3,): x, y [m] and yaw [rad].
        table: (TABLE,) int64 keys, 0 where free.
    """
    column = np.int64(math.floor(pose[0] / BIN))
    row = np.int64(math.floor(pose[1] / BIN))
    turn = np.int64(math.floor(pose[2] / YAW_BIN))
    key = (((column & 0xFFFFF) << 28) | ((row & 0xFFFFF) << 8) | (turn & 0xFF)) + 1
    slot = (key * 2654435761) % table.shape[0]
    while table[slot] != 0:
        if table[slot] == key:
            return False
        slot = (slot + 1) % table.shape[0]
    table[slot] = key
    return True


@njit(cache=True)
def resample(
    particles: Floats,
    weights: Floats,
    sizes: ParticleCounts,
    fresh: Fresh,
    center: Place,
    state: NDArray[np.uint64],
    out: Floats,
) -> int:
    """Draw particles by weight, as many as KLD sampling needs; return their number.

    Args:
        particles: Poses (n, 3) in map.
        state: State (1,) of the random numbers, changed; see `uniform`.
        out: Receives poses (k, 3).
    """
    fewest, most, error, z = sizes.fewest, sizes.most, sizes.error, sizes.z
    share, spread, spread_yaw = fresh.share, fresh.spread, fresh.spread_yaw
    table = np.zeros(TABLE, np.int64)
    sums = np.cumsum(weights)
    count, bins, enough = 0, 0, fewest
    while count < most and count < max(fewest, enough):
        if uniform(state) < share:
            out[count, 0] = center.x + spread * normal(state)
            out[count, 1] = center.y + spread * normal(state)
            out[count, 2] = wrap(center.yaw + spread_yaw * normal(state))
        else:
            k = np.searchsorted(sums, uniform(state) * sums[-1], side="right")
            out[count] = particles[min(k, particles.shape[0] - 1)]
        if bins < TABLE // 2 and is_new_bin(out[count], table):
            bins += 1
            enough = needed(bins, error, z)
        count += 1
    return count
