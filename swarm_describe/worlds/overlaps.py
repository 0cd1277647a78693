"""Models that lie inside others: a mistake of the world's author."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from swarm_common.model.records import FloatArray
from swarm_common.model.shapes import Box, Cylinder, Hull, Mesh, Part, Plane, Shape, Sphere
from swarm_describe.worlds.scene import Body

INSET = 0.001  # [m] by which a body must be inside sideways
RIM = 12  # points that stand for a round rim


def overlaps(bodies: Sequence[Body]) -> dict[str, str]:
    """Return a sentence by name of each model with a body inside a shape of another one."""
    found: dict[str, str] = {}
    far = np.full((1, 3), np.inf)  # what a ground plane has for points
    clouds = [np.vstack([points_of(p, body) for p in body.parts] or [far]) for body in bodies]
    boxes = np.array([[c.min(axis=0), c.max(axis=0)] for c in clouds]).reshape(-1, 2, 3)
    for outer in bodies:
        for part in outer.parts:
            shape = part.shape
            if not isinstance(shape, Box | Cylinder | Sphere):
                continue
            around = points_of(part, outer)
            low, high = around.min(axis=0) - 1e-6, around.max(axis=0) + 1e-6
            for index in np.flatnonzero(((boxes[:, 0] >= low) & (boxes[:, 1] <= high)).all(axis=1)):
                inner = bodies[int(index)]
                if _model(inner) != _model(outer) and _holds(part, outer, clouds[int(index)]):
                    x, y = clouds[int(index)][:, :2].mean(axis=0)
                    found.setdefault(
                        _model(inner),
                        f"model '{_model(inner)}' at ({x:.2f}, {y:.2f}) lies inside "
                        f"'{outer.name}'; move it, or leave it out",
                    )
    return found


def _model(body: Body) -> str:
    return body.name.partition("::")[0]


def _holds(part: Part, body: Body, points: FloatArray) -> bool:
    """Return whether all points (n, 3) of the world are inside a part."""
    shape = part.shape
    inverse = np.linalg.inv(body.world_from_body @ part.body_from_part)
    local = points @ inverse[:3, :3].T + inverse[:3, 3]
    x, y, z = np.abs(local).T
    if isinstance(shape, Box):
        half = np.array(shape.size) / 2.0
        inside = (x < half[0] - INSET) & (y < half[1] - INSET) & (z < half[2] + 1e-6)
    elif isinstance(shape, Cylinder):
        inside = (np.hypot(x, y) < shape.radius - INSET) & (z < shape.length / 2.0 + 1e-6)
    elif isinstance(shape, Sphere):
        inside = np.linalg.norm(local, axis=1) < shape.radius - INSET
    else:
        return False
    return bool(inside.all())


def points_of(part: Part, body: Body) -> FloatArray:
    """Return points (n, 3) of the world whose hull is around a part; infinite for a plane."""
    world_from_part = body.world_from_body @ part.body_from_part
    points: FloatArray = (
        _corners(part.shape) @ world_from_part[:3, :3].T + world_from_part[:3, 3]
        if not isinstance(part.shape, Plane)
        else np.full((1, 3), np.inf)
    )
    return points


def _corners(shape: Shape) -> FloatArray:
    signs = np.array([[i, j, k] for i in (-1, 1) for j in (-1, 1) for k in (-1, 1)], np.float64)
    if isinstance(shape, Box):
        half: FloatArray = signs * np.array(shape.size) / 2.0
        return half
    if isinstance(shape, Mesh | Hull):
        return np.array(shape.vertices)
    if isinstance(shape, Sphere):
        around: FloatArray = signs * shape.radius
        return around
    if isinstance(shape, Cylinder):
        angles = 2.0 * math.pi * np.arange(RIM) / RIM
        rim = shape.radius * np.column_stack([np.cos(angles), np.sin(angles)])
        end = np.full((RIM, 1), shape.length / 2.0)
        return np.vstack([np.hstack([rim, -end]), np.hstack([rim, end])])
    return np.full((1, 3), np.inf)
