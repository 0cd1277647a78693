"""Slow twins of the localisation kernels: one particle and one hit at a time."""

import math

import numpy as np
from numpy.typing import NDArray

from tests.oracles.fields import sample

FloatArray = NDArray[np.float64]
Frame = tuple[float, float, float]


def in_map(pose: FloatArray, point: FloatArray) -> tuple[float, float]:
    """Return a point of the robot's frame in map."""
    cos, sin = math.cos(pose[2]), math.sin(pose[2])
    return (pose[0] + cos * point[0] - sin * point[1], pose[1] + sin * point[0] + cos * point[1])


def likelihood(
    distance: FloatArray, sigma: float, weights: tuple[float, float], most: float
) -> FloatArray:
    """Return the logarithm of z_hit * exp(-d² / 2σ²) + z_rand / range_max, 0 at most."""
    near = np.minimum(np.abs(distance), most)
    p = weights[0] * np.exp(-(near**2) / (2.0 * sigma**2)) + weights[1]
    result: FloatArray = np.log(p / sum(weights))
    return result


def weights_of(
    particles: FloatArray,
    points: FloatArray,
    field: FloatArray,
    frame: Frame,
    skip: tuple[float, float, float],
    power: float,
) -> FloatArray:
    """Return the normalised weights of particles, hits that few agree with left out."""
    scores = np.array(
        [[sample(field, frame, *in_map(pose, point)) for point in points] for pose in particles]
    )
    use = (scores >= skip[0]).mean(axis=0) >= skip[1]
    if (~use).sum() > skip[2] * len(points):
        use[:] = True
    total = scores[:, use].sum(axis=1)
    weights: FloatArray = np.exp(power * (total - total.max()))
    return weights / weights.sum()


def beams(
    ranges: FloatArray,
    beam: tuple[float, float, float, float],
    offset: int,
    lidar: tuple[float, float, float],
    pose: tuple[float, float, float],
    robots: list[tuple[float, float, float]],
    sectors: int,
) -> FloatArray:
    """Return the first hit of each sector that no robot (x, y, reach) explains."""
    found = []
    for rays in np.array_split(np.arange(len(ranges)), sectors):
        for k in np.roll(rays, -(offset % len(rays))):
            if not beam[2] <= ranges[k] < beam[3]:
                continue
            angle = lidar[2] + beam[0] + k * beam[1]
            point = np.array(lidar[:2]) + ranges[k] * np.array([math.cos(angle), math.sin(angle)])
            x, y = in_map(np.array(pose), point)
            if all(math.hypot(x - a, y - b) >= reach for a, b, reach in robots):
                found.append(point)
                break
    return np.array(found).reshape(-1, 2)
