"""Bare numba kernels of Monte Carlo localisation; the checked face is in amcl.py.

Particles are rows x, y, yaw in map. Random numbers come from a counter (SplitMix64) that each
robot has for itself, so that robots in one process do not disturb each other's.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from swarm_nav.planning.distance_kernels import sample

GOLDEN = np.uint64(0x9E3779B97F4A7C15)
FIRST = np.uint64(0xBF58476D1CE4E5B9)
SECOND = np.uint64(0x94D049BB133111EB)
BIN = 0.2  # [m] of KLD sampling's cells, and
YAW_BIN = math.radians(10.0)  # [rad]
TABLE = 8192  # slots of its hash table
REACH = 0.3  # [m] and [rad] around the heaviest place that the estimate is the mean of
ROUNDS = 4  # in which that place is moved to the mean
CANDIDATES = 20  # particles, drawn evenly by weight, around which the heaviest place is looked for


@njit(cache=True)
def uniform(state):
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
def normal(state):
    """Return a standard normal random number (Box and Muller).

    Args:
        state: See `uniform`.
    """
    first = 1.0 - uniform(state)
    return math.sqrt(-2.0 * math.log(first)) * math.cos(2.0 * math.pi * uniform(state))


@njit(cache=True)
def wrap(angle):
    """Return an angle [rad] in [-π, π).

    Args:
        angle: [rad].
    """
    return (angle + math.pi) % (2.0 * math.pi) - math.pi


@njit(cache=True)
def scatter(particles, mean, spread, state):
    """Draw all particles around a pose.

    Args:
        particles: (n, 3) x, y [m], yaw [rad] in map, written.
        mean: (x, y, yaw).
        spread: (x, y, yaw) standard deviations.
        state: See `uniform`.
    """
    for k in range(particles.shape[0]):
        for axis in range(3):
            particles[k, axis] = mean[axis] + spread[axis] * normal(state)


@njit(cache=True)
def blur(particles, spread, state):
    """Add noise to particles.

    Args:
        particles: (n, 3), changed in place.
        spread: (x, y, yaw) standard deviations.
        state: See `uniform`.
    """
    for k in range(particles.shape[0]):
        for axis in range(3):
            particles[k, axis] += spread[axis] * normal(state)


@njit(cache=True)
def move(particles, step, deviations, state):
    """Move particles by an odometry step with noise (Thrun, Burgard, Fox 2005, table 5.6).

    Args:
        particles: (n, 3) x, y [m], yaw [rad] in map, changed in place.
        step: (first turn [rad], way [m], second turn [rad], way sideways [m]); the ways lie in the
            direction after the first turn.
        deviations: Standard deviations of these four and, last, that of the position [m] in any
            direction.
        state: See `uniform`.
    """
    for k in range(particles.shape[0]):
        first = step[0] + deviations[0] * normal(state)
        way = step[1] + deviations[1] * normal(state)
        second = step[2] + deviations[2] * normal(state)
        aside = step[3] + deviations[3] * normal(state)
        heading = particles[k, 2] + first
        cos, sin = math.cos(heading), math.sin(heading)
        particles[k, 0] += way * cos - aside * sin + deviations[4] * normal(state)
        particles[k, 1] += way * sin + aside * cos + deviations[4] * normal(state)
        particles[k, 2] = wrap(heading + second)


@njit(cache=True)
def likelihood(distance, sigma, weights, most, out):
    """Write the logarithm of each cell's likelihood of a hit, 0 on a wall.

    log((z_hit exp(-d² / 2σ²) + z_rand / range_max) / (z_hit + z_rand / range_max)).

    Args:
        distance: (h, w) [m] to the nearest wall.
        sigma: [m] of a hit about a wall.
        weights: (z_hit, z_rand / range_max).
        most: [m] beyond which the distance does not count.
        out: (h, w), written.
    """
    hit, other = weights
    for r in range(distance.shape[0]):
        for c in range(distance.shape[1]):
            d = min(abs(distance[r, c]), most)
            p = hit * math.exp(-0.5 * d * d / (sigma * sigma)) + other
            out[r, c] = math.log(p / (hit + other))


@njit(cache=True)
def beams(ranges, beam, offset, lidar, pose, robots, reach, out):
    """Write the hits to compare with the map: the first usable ray of each of equal sectors.

    A ray is usable if it hit something that no known robot explains.

    Args:
        ranges: (rays,) [m].
        beam: (angle_min [rad], angle_increment [rad], range_min [m], range_max [m]).
        offset: Of the first ray that is tried in each sector.
        lidar: (x, y, yaw) of the LiDAR in base_footprint.
        pose: (x, y, yaw) of the robot in map.
        robots: (m, 2) [m] in map, centres of discs that hold robots.
        reach: (m,) [m] radii of these discs.
        out: (sectors, 2) receives hits in base_footprint.

    Returns:
        The number of hits.
    """
    rays, sectors = ranges.shape[0], out.shape[0]
    cos, sin = math.cos(pose[2]), math.sin(pose[2])
    count = 0
    for sector in range(sectors):
        begin, end = sector * rays // sectors, (sector + 1) * rays // sectors
        for i in range(end - begin):
            k = begin + (i + offset) % (end - begin)
            r = ranges[k]
            if not (beam[2] <= r < beam[3]):
                continue
            angle = lidar[2] + beam[0] + k * beam[1]
            x = lidar[0] + r * math.cos(angle)
            y = lidar[1] + r * math.sin(angle)
            x_map = pose[0] + cos * x - sin * y
            y_map = pose[1] + sin * x + cos * y
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
def weigh(particles, points, field, frame, skip, trust, scores, weights):
    """Write the normalised weights of particles after a scan.

    Args:
        particles: (n, 3) x, y [m], yaw [rad] in map.
        points: (b, 2) [m] hits in base_footprint.
        field: (h, w) log likelihoods, see `likelihood`.
        frame: (origin_x, origin_y, resolution) [m] of the field.
        skip: (log likelihood from which a particle agrees with a hit, share of particles that must
            agree, share of hits left out from which all count again).
        trust: (share of a new view that the scan is, 0 to 1; number of particles that must matter
            in effect): the scan is trusted less if fewer matter.
        scores: (n, b), scratch.
        weights: (n,), written.

    Returns:
        The share of hits left out.
    """
    n, b = particles.shape[0], points.shape[0]
    power, fewest = trust
    left_out = 0
    use = np.ones(b, np.bool_)
    agreeing = np.zeros(b, np.int64)
    for k in range(n):
        cos, sin = math.cos(particles[k, 2]), math.sin(particles[k, 2])
        for i in range(b):
            x = particles[k, 0] + cos * points[i, 0] - sin * points[i, 1]
            y = particles[k, 1] + sin * points[i, 0] + cos * points[i, 1]
            scores[k, i] = sample(field, frame, x, y)
            if scores[k, i] >= skip[0]:
                agreeing[i] += 1
    for i in range(b):
        if agreeing[i] < skip[1] * n:
            use[i] = False
            left_out += 1
    if left_out > skip[2] * b:
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
def estimate(particles, weights, out):
    """Write the densest place of the particles, and the variances of all around it.

    The place is the mean of the particles near the one with the heaviest neighbourhood, moved to
    that mean a few times.

    Args:
        particles: (n, 3) x, y [m], yaw [rad] in map.
        weights: (n,), their sum is 1.
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
def fit(pose, points, field, frame, weights):
    """Return the mean over hits of exp(-d² / 2σ²) at a pose: 1 if all lie on mapped walls.

    Args:
        pose: (x, y, yaw) of the robot in map.
        points: (b, 2) [m] hits in base_footprint.
        field: (h, w) log likelihoods, see `likelihood`.
        frame: (origin_x, origin_y, resolution) [m] of the field.
        weights: (z_hit, z_rand / range_max), with which the field was made.
    """
    hit, other = weights
    cos, sin = math.cos(pose[2]), math.sin(pose[2])
    total = 0.0
    for i in range(points.shape[0]):
        x = pose[0] + cos * points[i, 0] - sin * points[i, 1]
        y = pose[1] + sin * points[i, 0] + cos * points[i, 1]
        p = (hit + other) * math.exp(sample(field, frame, x, y)) - other
        total += p / hit
    return total / max(1, points.shape[0])


@njit(cache=True)
def needed(bins, error, z):
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
def is_new_bin(pose, table):
    """Enter the histogram cell of a pose into a hash table; return whether it was not there.

    Args:
        pose: (x [m], y [m], yaw [rad]).
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
def resample(particles, weights, sizes, fresh, center, state, out):
    """Draw particles by weight, as many as KLD sampling needs.

    Args:
        particles: (n, 3) x, y [m], yaw [rad] in map.
        weights: (n,).
        sizes: (fewest, most, error, z), see `needed`.
        fresh: (share that is drawn around `center` instead, its spread [m], [rad]).
        center: (x, y, yaw) in map.
        state: See `uniform`.
        out: (most, 3) receives the particles.

    Returns:
        The number of particles drawn.
    """
    fewest, most, error, z = sizes
    share, spread, spread_yaw = fresh
    table = np.zeros(TABLE, np.int64)
    sums = np.cumsum(weights)
    count, bins, enough = 0, 0, fewest
    while count < most and count < max(fewest, enough):
        if uniform(state) < share:
            out[count, 0] = center[0] + spread * normal(state)
            out[count, 1] = center[1] + spread * normal(state)
            out[count, 2] = wrap(center[2] + spread_yaw * normal(state))
        else:
            k = np.searchsorted(sums, uniform(state) * sums[-1], side="right")
            out[count] = particles[min(k, particles.shape[0] - 1)]
        if bins < TABLE // 2 and is_new_bin(out[count], table):
            bins += 1
            enough = needed(bins, error, z)
        count += 1
    return count
