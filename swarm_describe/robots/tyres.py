"""Contact of a wheel with the ground: the radius of its tyre, and where on its axle that is.

A wheel's link has more shapes than its tyre (hub, rim, motor), and its joint need not be in the
middle of the tyre.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from swarm_common.model.outline import bounds
from swarm_common.model.shapes import Cylinder, FloatArray, Part, Sphere, Transform
from swarm_describe.robots.description import RigidGroup, RobotModel

ON_AXLE = 1e-3  # [m] between a round shape's middle and the axle on which it turns
ALONG = 0.999  # cosine between the axis of a cylinder and the axle
WIDE = 0.95  # of the largest radius, from which a shape is part of the tyre
SAME = 1e-4  # [m] by which the tyre's middle is off the joint all the same


@dataclass(frozen=True, slots=True)
class Tyre:
    """Part of a turning group that rolls on the ground."""

    radius: float  # [m]
    offset: (
        FloatArray  # (3,) [m] of its middle from the joint, along the axle, in the group's frame
    )
    is_round: bool  # by its shape: a cylinder or a sphere; of others the radius is that of a box


@dataclass(frozen=True, slots=True)
class _Ring:
    radius: float
    low: float  # [m] along the axle
    high: float
    is_round: bool


def tyre_of(group: RigidGroup, more: Sequence[Part] = ()) -> Tyre | None:
    """Return the tyre of a turning group, None without a collision shape.

    Args:
        more: Shapes of what it carries on further joints, such as rollers, in its frame.
    """
    parts = [*group.parts, *more]
    rings = [ring for part in parts if (ring := _round(part, group.axis)) is not None]
    others = [part for part in parts if _round(part, group.axis) is None]
    if others and len(low_high := _extent(others, group.axis)):
        rings.append(_Ring(*low_high, False))
    if not rings:
        return None
    widest = max(rings, key=lambda ring: (ring.radius, ring.is_round))
    tread = [ring for ring in rings if ring.radius >= WIDE * widest.radius]
    middle = (min(ring.low for ring in tread) + max(ring.high for ring in tread)) / 2.0
    middle = middle if abs(middle) > SAME else 0.0
    return Tyre(widest.radius, middle * group.axis, widest.is_round)


def carried(model: RobotModel, index: int) -> tuple[list[Part], int]:
    """Return the shapes on the joints of a turning group, and how many of these joints turn."""
    places: dict[int, Transform] = {index: np.eye(4)}
    parts: list[Part] = []
    turning = 0
    for number, group in enumerate(model.groups):
        if group.parent in places and number not in places:
            places[number] = places[group.parent] @ group.parent_from_group
            parts += [Part(p.shape, places[number] @ p.body_from_part) for p in group.parts]
            turning += group.kind == "continuous"
    return parts, turning


def _round(part: Part, axis: FloatArray) -> _Ring | None:
    """Return a shape that is round about the axle."""
    if not isinstance(part.shape, Cylinder | Sphere):
        return None
    place = part.body_from_part[:3, 3]
    middle = float(place @ axis)
    if float(np.linalg.norm(place - middle * axis)) > ON_AXLE:
        return None
    if isinstance(part.shape, Sphere):
        return _Ring(part.shape.radius, middle, middle, True)
    if abs(float(part.body_from_part[:3, 2] @ axis)) < ALONG:
        return None
    half = part.shape.length / 2.0
    return _Ring(part.shape.radius, middle - half, middle + half, True)


def _extent(parts: Sequence[Part], axis: FloatArray) -> tuple[float, float, float]:
    """Return the radius of other shapes as that of the box around them, and their ends."""
    low, high = bounds(parts)
    main = int(np.argmax(np.abs(axis)))
    across = np.delete(high - low, main)
    ends = sorted((float(low[main]) * np.sign(axis[main]), float(high[main]) * np.sign(axis[main])))
    return float(across.max() / 2.0), float(ends[0]), float(ends[1])
