"""Numba kernels of the LiDAR: rays against segments and discs in the plane, and range noise.

Each obstacle is tested only against the rays inside the angle that its part within range spans as
seen from the sensor, so a scan costs about as much as it has hits, not rays times obstacles.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from swarm_common.model.records import FloatArray, IntArray
from swarm_common.process.numba_compat import njit
from swarm_sim.sensing.radio_kernels import mixed

TWO_PI = 2.0 * math.pi
UNKNOWN = 2.0  # in place of a cosine
TOUCHING = 1e-3  # [m] of a segment from a sensor, which then looks along it


class Shapes(NamedTuple):
    """Segments or discs, and whose they are."""

    shapes: FloatArray  # (s, 4) [m] ends x0, y0, x1, y1; or (d, 3) [m] x, y, radius
    owners: IntArray  # (s,) index of the robot, -1 for the world


class Fan(NamedTuple):
    """Directions and reach of rays."""

    angle_min: float  # [rad] of ray 0, in the sensor's frame
    increment: float  # [rad]
    range_max: float  # [m]


@njit(cache=True)
def carry(poses: FloatArray, owners: IntArray, base: FloatArray, out: FloatArray) -> None:
    """Write shapes that robots carry where these are.

    Args:
        poses: (n, 3): x, y [m], yaw [rad] in map.
        owners: (s,) robot of each shape.
        base: (s, 4) segments or (s, 3) discs, see `Shapes`, in base_footprint.
        out: The same in map; of discs the radius is left alone.
    """
    for s in range(base.shape[0]):
        x, y, yaw = poses[owners[s], 0], poses[owners[s], 1], poses[owners[s], 2]
        cos, sin = math.cos(yaw), math.sin(yaw)
        for k in range(0, base.shape[1] - 1, 2):
            out[s, k] = x + cos * base[s, k] - sin * base[s, k + 1]
            out[s, k + 1] = y + sin * base[s, k] + cos * base[s, k + 1]


@njit(cache=True)
def ray_segment(dx: float, dy: float, ax: float, ay: float, bx: float, by: float) -> float:
    """Return the range along a unit ray from the origin to the segment a-b; inf if it misses.

    Solves t d = a + u (b - a) for t ≥ 0 and 0 ≤ u ≤ 1.

    Args:
        dx: Component of the ray's unit vector along x.
        dy: Component of the ray's unit vector along y.
        ax: [m] of one end.
        ay: [m] of one end.
        bx: [m] of the other end.
        by: [m] of the other end.
    """
    ex, ey = bx - ax, by - ay
    denominator = dx * ey - dy * ex
    if denominator == 0.0:
        return math.inf
    along = (ax * ey - ay * ex) / denominator
    share = (ax * dy - ay * dx) / denominator
    if along < 0.0 or share < 0.0 or share > 1.0:
        return math.inf
    return along


@njit(cache=True)
def ray_disc(dx: float, dy: float, cx: float, cy: float, radius: float) -> float:
    """Return the range along a unit ray from the origin to a circle; inf if it misses.

    Solves |t d - c| = r for the smallest t ≥ 0.

    Args:
        dx: Component of the ray's unit vector along x.
        dy: Component of the ray's unit vector along y.
        cx: [m] of the centre.
        cy: [m] of the centre.
        radius: [m]
    """
    middle = cx * dx + cy * dy
    aside = cx * dy - cy * dx
    squared = radius * radius - aside * aside
    if squared < 0.0:
        return math.inf
    half = math.sqrt(squared)
    if middle - half >= 0.0:
        return middle - half
    return middle + half if middle + half >= 0.0 else math.inf


@njit(cache=True)
def segment_gap(ax: float, ay: float, bx: float, by: float) -> float:
    """Return the distance of the origin from the segment a-b.

    Args:
        ax: [m] of one end.
        ay: [m] of one end.
        bx: [m] of the other end.
        by: [m] of the other end.
    """
    ex, ey = bx - ax, by - ay
    length = ex * ex + ey * ey
    share = 0.0
    if length > 0.0:
        share = min(1.0, max(0.0, -(ax * ex + ay * ey) / length))
    return math.hypot(ax + share * ex, ay + share * ey)


@njit(cache=True)
def within(
    ax: float, ay: float, bx: float, by: float, reach: float
) -> tuple[float, float, float, float]:
    """Return the ends of the part of the segment a-b that is within reach of the origin.

    Args:
        ax: [m] of one end.
        ay: [m] of one end.
        bx: [m] of the other end.
        by: [m] of the other end.
        reach: [m]
    """
    ex, ey = bx - ax, by - ay
    length = ex * ex + ey * ey
    if max(ax * ax + ay * ay, bx * bx + by * by) <= reach * reach or length == 0.0:
        return ax, ay, bx, by
    middle = -(ax * ex + ay * ey) / length
    fx, fy = ax + middle * ex, ay + middle * ey
    half = math.sqrt(max(0.0, reach * reach - fx * fx - fy * fy) / length)
    first, last = max(0.0, middle - half), min(1.0, middle + half)
    return ax + first * ex, ay + first * ey, ax + last * ex, ay + last * ey


@njit(cache=True)
def ray_window(
    start: float, width: float, turn: int, increment: float, rays: int
) -> tuple[int, int]:
    """Return first and last ray (inclusive) that an angle may contain.

    Args:
        start: Lower bound of the angle, counted from ray 0; any multiple of 2π.
        width: Width [rad] of the interval of the angle.
        turn: 0 for the part above zero, 1 for the part that wrapped around.
        increment: Between rays.
        rays: Number of rays.
    """
    low = start % TWO_PI - TWO_PI * turn
    first = max(0, math.floor(low / increment) - 1)
    last = min(rays - 1, math.ceil((low + width) / increment) + 1)
    return first, last


@njit(cache=True)
def cast(
    sensors: FloatArray,
    owners: IntArray,
    segments: tuple[FloatArray, IntArray],
    discs: tuple[FloatArray, IntArray],
    fan: tuple[float, float, float],
    out: FloatArray,
) -> None:
    """Write the true range [m] of each ray, inf beyond the fan's.

    Args:
        sensors: (n, 3): x, y [m], yaw [rad] in map.
        owners: (n,) robot that carries the sensor; it does not see itself.
        segments: Fields of `Shapes`; plain, since numba's dispatcher takes plain tuples faster.
        discs: The same.
        fan: Fields of `Fan`.
        out: (n, rays) receives the ranges.
    """
    lines, circles, view = Shapes(*segments), Shapes(*discs), Fan(*fan)
    rays = out.shape[1]
    directions = np.empty((rays, 2))
    for i in range(sensors.shape[0]):
        x, y, yaw = sensors[i, 0], sensors[i, 1], sensors[i, 2]
        zero = yaw + view.angle_min
        directions[:, 0] = UNKNOWN
        out[i] = math.inf
        for s in range(lines.shapes.shape[0]):
            if lines.owners[s] == owners[i]:
                continue
            ax, ay = lines.shapes[s, 0] - x, lines.shapes[s, 1] - y
            bx, by = lines.shapes[s, 2] - x, lines.shapes[s, 3] - y
            gap = segment_gap(ax, ay, bx, by)
            if gap > view.range_max:
                continue
            px, py, qx, qy = ax, ay, bx, by
            if gap > TOUCHING:
                px, py, qx, qy = within(ax, ay, bx, by, view.range_max + TOUCHING)
            start = math.atan2(py, px)
            width = math.atan2(qy, qx) - start
            width -= TWO_PI * math.floor(width / TWO_PI)  # to [0, 2π)
            if width > math.pi:
                start, width = start + width, TWO_PI - width
            for turn in range(2):
                first, last = ray_window(start - zero, width, turn, view.increment, rays)
                for k in range(first, last + 1):
                    if directions[k, 0] == UNKNOWN:
                        directions[k, 0] = math.cos(zero + k * view.increment)
                        directions[k, 1] = math.sin(zero + k * view.increment)
                    hit = ray_segment(directions[k, 0], directions[k, 1], ax, ay, bx, by)
                    if hit <= view.range_max and hit < out[i, k]:
                        out[i, k] = hit
        for d in range(circles.shapes.shape[0]):
            if circles.owners[d] == owners[i]:
                continue
            cx, cy = circles.shapes[d, 0] - x, circles.shapes[d, 1] - y
            radius = circles.shapes[d, 2]
            gap = math.hypot(cx, cy)
            if gap - radius > view.range_max:
                continue
            half = math.pi if gap <= radius else math.asin(radius / gap)
            start = math.atan2(cy, cx) - half
            for turn in range(2):
                first, last = ray_window(start - zero, 2.0 * half, turn, view.increment, rays)
                for k in range(first, last + 1):
                    if directions[k, 0] == UNKNOWN:
                        directions[k, 0] = math.cos(zero + k * view.increment)
                        directions[k, 1] = math.sin(zero + k * view.increment)
                    hit = ray_disc(directions[k, 0], directions[k, 1], cx, cy, radius)
                    if hit <= view.range_max and hit < out[i, k]:
                        out[i, k] = hit


@njit(cache=True)
def draw(seed: int, tick: int, members: IntArray, words: NDArray[np.uint64]) -> None:
    """Write a random word for each ray (n, rays): `hash_words` of seed, tick, member and ray.

    Args:
        seed: Seed of everything random.
        tick: Tick of the scan.
        members: (n,) indices of the robots.
        words: (n, rays) receives the words.
    """
    head = mixed(mixed(np.uint64(0), np.uint64(seed)), np.uint64(tick))
    for i in range(words.shape[0]):
        word = mixed(head, np.uint64(members[i]))
        for k in range(words.shape[1]):
            words[i, k] = mixed(word, np.uint64(k))


@njit(cache=True)
def add_noise(
    ranges: FloatArray,
    words: NDArray[np.uint64],
    sigma: float,
    range_min: float,
    range_max: float,
    out: NDArray[np.float32],
) -> None:
    """Write measured ranges: true ones plus normal noise, outside the limits ±inf (REP 117).

    Args:
        ranges: True ranges (n, rays).
        words: Random words (n, rays); each gives one normal number (Box and Muller).
        sigma: [m] standard deviation.
        range_min: [m] below it a measurement becomes -inf.
        range_max: [m] above it a measurement becomes inf.
        out: (n, rays).
    """
    low_half = np.uint64(0xFFFFFFFF)
    for i in range(ranges.shape[0]):
        for k in range(ranges.shape[1]):
            value = ranges[i, k]
            if sigma > 0.0 and value < math.inf:
                first = (float(words[i, k] >> np.uint64(32)) + 1.0) * 2.0**-32
                second = float(words[i, k] & low_half) * 2.0**-32
                spread = math.sqrt(-2.0 * math.log(first))
                value += sigma * spread * math.cos(TWO_PI * second)
            if value > range_max:
                value = math.inf
            elif value < range_min:
                value = -math.inf
            out[i, k] = value
