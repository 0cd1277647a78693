"""Supports of a robot in the rigid-body engine: its driven wheels, and balls without friction.

The driven wheels define the ground. Casters of real robots hang on springs, or the axle does, and
descriptions show them relaxed: a millimetre or two lower or higher than the wheels. A rigid ball
down there would lift the wheels into the air. So every caster is put where its spring would hold
it, on the plane on which the driven wheels stand, and these carry their share of the weight.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from swarm_common.model.outline import placed_corners
from swarm_common.model.records import FloatArray, RobotSpec
from swarm_common.model.shapes import Part, Sphere, Transform
from swarm_describe.robots.description import RigidGroup
from swarm_describe.robots.tyres import tyre_of

Ball = tuple[FloatArray, float]  # centre in base_footprint, radius [m]

ON_GROUND = 0.002  # [m] above the wheels' plane down to which a ball of the body is a caster
SPRING = 0.02  # [m] below that plane that springs take up; what reaches deeper is an error
SAG = 0.005  # [m] by which the tyres of single wheels may be off that plane
SAME = 1e-9  # [m] that rounding leaves
PROP_REACH = 0.01  # [m] by which a robot's feet reach beyond its centre of mass
PROP_RADIUS = 0.01  # [m] of a ball that stands for a caster


@dataclass(frozen=True, slots=True)
class Supports:
    """Wheels and balls that carry a robot; lengths in metres, in base_footprint."""

    level: float  # height of the plane on which the driven wheels stand
    wheels: FloatArray  # (n, 3) centres of the balls that stand for the driven wheels
    balls: list[Ball]  # centre and radius of each caster, or of what stands for it
    hull: list[tuple[Any, Transform]]  # shapes of the base that do not carry it


def find_supports(base: RigidGroup, wheels: Sequence[RigidGroup], spec: RobotSpec) -> Supports:
    """Return the supports of a robot."""
    level, centers = _wheel_balls(wheels, spec.wheel_radius)
    casters, hull = _split_base(base, level, spec.wheel_radius)
    return Supports(level, centers, casters + _props(base, wheels, casters, spec, level), hull)


def depths(base: RigidGroup, level: float) -> list[tuple[str, float]]:
    """Return the links that reach below the wheels' plane, and by how much [m], deepest first."""
    found: dict[str, float] = {}
    for part, link in zip(base.parts, base.links, strict=True):
        low = _lowest(part)
        found[link] = max(found.get(link, 0.0), level - low)
    return sorted(((k, v) for k, v in found.items() if v > 0.0), key=lambda item: -item[1])


def heights(wheels: Sequence[RigidGroup], radius: float) -> FloatArray:
    """Return by how much (n,) [m] the tyre of each driven wheel ends above the lowest one.

    Args:
        radius: [m] of a wheel whose shape does not tell it.
    """
    ends = [w.parent_from_group[2, 3] - tyre_radius(w, radius) for w in wheels]
    return np.array(ends) - min(ends, default=0.0)


def tyre_radius(wheel: RigidGroup, otherwise: float) -> float:
    """Return the radius [m] of a wheel's tyre.

    Args:
        otherwise: [m] for one whose shape does not tell it.
    """
    tyre = tyre_of(wheel)
    return otherwise if tyre is None else tyre.radius


def _wheel_balls(wheels: Sequence[RigidGroup], radius: float) -> tuple[float, FloatArray]:
    """Return the height of the wheels' plane, and the balls' centres, which touch it."""
    if not wheels:
        return 0.0, np.zeros((0, 3))
    centers = np.array([_tyre_middle(wheel) for wheel in wheels])
    ends = centers[:, 2] - [tyre_radius(wheel, radius) for wheel in wheels]
    level = float(np.median(centers[:, 2])) - radius
    level = 0.0 if abs(level) < SAME else level
    off = ends - np.median(ends)
    heights = level + radius + np.where(np.abs(off) <= SAG, 0.0, off)
    is_off = np.abs(heights - centers[:, 2]) > SAME
    centers[is_off, 2] = heights[is_off]
    return level, centers


def _tyre_middle(wheel: RigidGroup) -> FloatArray:
    """Return the middle of a wheel's tyre, which need not be that of its joint."""
    place, tyre = wheel.parent_from_group, tyre_of(wheel)
    middle: FloatArray = place[:3, 3].copy()
    return middle if tyre is None else middle + place[:3, :3] @ tyre.offset


def _split_base(
    base: RigidGroup, level: float, wheel_radius: float
) -> tuple[list[Ball], list[tuple[Any, Transform]]]:
    """Return balls on which the base slides, and its other shapes."""
    casters: list[Ball] = []
    hull: list[tuple[Any, Transform]] = []
    for part in base.parts:
        is_caster = isinstance(part.shape, Sphere) and _lowest(part) < level + ON_GROUND
        if isinstance(part.shape, Sphere) and is_caster:
            casters.append((_sprung(part, level), part.shape.radius))
        if not is_caster or (isinstance(part.shape, Sphere) and part.shape.radius > wheel_radius):
            hull.append((part.shape, part.body_from_part))  # a large ball can be run into, too
    return _merged(casters), hull


def _sprung(part: Part, level: float) -> FloatArray:
    """Return the centre of a caster's ball at which a spring would hold it."""
    center = np.array(part.body_from_part[:3, 3])
    if isinstance(part.shape, Sphere) and abs(_lowest(part) - level) > SAME:
        center[2] = level + part.shape.radius
    return center


def _merged(casters: Sequence[Ball]) -> list[Ball]:
    """Return one ball for the casters behind the axle and one for those ahead of it.

    Two wheels and one ball carry a robot as well as two wheels and two balls, at 3/4 of the cost.
    """
    merged = []
    for is_ahead in (False, True):
        balls = [ball for ball in casters if (ball[0][0] > 0.0) == is_ahead]
        if balls:
            center = np.mean([center for center, _ in balls], axis=0)
            merged.append((center, float(np.mean([radius for _, radius in balls]))))
    return merged


def _props(
    base: RigidGroup,
    wheels: Sequence[RigidGroup],
    casters: Sequence[Ball],
    spec: RobotSpec,
    level: float,
) -> list[Ball]:
    """Return balls that keep a body from tipping over whose casters are not balls, or missing."""
    props: list[Ball] = []
    for axis in (0, 1) if not wheels else (0,):
        middle = base.center[axis]
        feet = [w.parent_from_group[axis, 3] for w in wheels]
        feet += [center[axis] for center, _ in casters]
        for direction in (-1.0, 1.0):
            if any(direction * (foot - middle) >= PROP_REACH for foot in feet):
                continue
            reach = max(direction * (corner[axis] - middle) for corner in spec.footprint)
            center = np.array([base.center[0], base.center[1], level + PROP_RADIUS])
            center[axis] = middle + direction * max(PROP_REACH, reach - PROP_RADIUS)
            props.append((center, PROP_RADIUS))
    return props


def _lowest(part: Part) -> float:
    if isinstance(part.shape, Sphere):
        return float(part.body_from_part[2, 3]) - part.shape.radius
    corners = placed_corners([part])
    return float(corners[:, 2].min()) if len(corners) else np.inf
