"""Shapes that the physics engine has in place of those of a body or a robot."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pybullet
from numpy.typing import NDArray

from swarm_common.model.records import FloatArray, Pose, RobotSpec
from swarm_common.model.shapes import Part
from swarm_describe.robots.description import RobotModel
from swarm_describe.worlds.raw_triangles import cuts, triangles_of_part
from swarm_describe.worlds.scene import Body
from swarm_sim.physics.bullet.object_bodies import add_loose, add_piece, pieces_of
from swarm_sim.physics.bullet.robot_bodies import add_robot, base_and_wheels, touchable
from swarm_sim.physics.bullet.supports import find_supports

BATCH = 10_000  # rays at a time
MOST_RAYS = 40_000  # through a body; of a larger one every so many
LEVELS = 3  # heights at which each part is felt
FAR = 1e3  # [m] above and below all of a robot
ROBOT_REACH = 0.01  # [m] from a robot's triangles within which the engine has to have something


def lacking(body: Body, low: float, high: float, reach: float) -> FloatArray:
    """Return points (k, 3) on a body's triangles where the physics engine has nothing of it.

    Args:
        body: In the world; its planes do not count.
        reach: [m] within which the engine has to have something.
    """
    client = pybullet.connect(pybullet.DIRECT)
    try:
        if body.is_static:
            ids = [one for piece in pieces_of(body) for one in add_piece(client, piece)]
        else:
            ids = [add_loose(client, body)]
        return _missed(client, ids, _rays(body, low, high, reach))
    finally:
        pybullet.disconnect(physicsClientId=client)


def lacking_of_robot(model: RobotModel, spec: RobotSpec) -> tuple[str, FloatArray] | None:
    """Return a link of a robot that the engine lacks a part of, and where; None if all is there.

    The balls that it stands on do not count: nothing but the ground meets them.

    Returns:
        Name of the link, point (3,) [m] in base_footprint.
    """
    base, wheels = base_and_wheels(model, spec)
    supports = find_supports(base, wheels, spec)
    place = np.eye(4)
    place[2, 3] = -supports.level
    client = pybullet.connect(pybullet.DIRECT)
    try:
        ids = [add_robot(client, model, spec, Pose(0.0, 0.0, 0.0)).body]
        for shape, base_from_part in touchable(supports, wheels):
            body = Body(spec.model, place, (Part(shape, base_from_part),))
            missed = _missed(client, ids, _rays(body, -FAR, FAR, ROBOT_REACH))
            if len(missed):
                links = [
                    link
                    for group in model.groups
                    for part, link in zip(group.parts, group.links, strict=True)
                    if part.shape is shape
                ]
                return links[0], missed[len(missed) // 2] - place[:3, 3]
        return None
    finally:
        pybullet.disconnect(physicsClientId=client)


def _rays(body: Body, low: float, high: float, reach: float) -> FloatArray:
    """Return short level rays (n, 2, 3) through the middles of what levels cut of triangles."""
    found = [np.zeros((0, 2, 3))]
    for part in body.parts:
        triangles = triangles_of_part(part, body)
        heights = triangles[:, :, 2]
        bottom, top = heights.min(initial=high), heights.max(initial=low)
        bottom, top = max(low, bottom), min(high, top)
        for level in np.linspace(bottom, top, LEVELS + 2)[1:-1] if bottom < top else ():
            segments = cuts(triangles, float(level))
            along = segments[:, 1] - segments[:, 0]
            length = np.hypot(*along.T)
            segments, along = segments[length > 1e-6], along[length > 1e-6]
            middles = segments.mean(axis=1)
            across = np.column_stack([-along[:, 1], along[:, 0]]) / np.hypot(*along.T)[:, None]
            ends = [middles - reach * across, middles + reach * across]
            level_column = np.full((len(middles), 1), level)
            found.append(np.stack([np.hstack([end, level_column]) for end in ends], axis=1))
    rays = np.concatenate(found)
    return rays[:: max(1, len(rays) // MOST_RAYS)]


def _missed(client: int, ids: Sequence[int], rays: FloatArray) -> FloatArray:
    """Return the middles (k, 3) of rays that meet none of some bodies, cast from either end.

    The engine does not report a convex shape that a ray starts in, but does from the other end.
    """
    for identifier in ids:  # rays are in no group of ours
        pybullet.setCollisionFilterGroupMask(identifier, -1, 1, -1, physicsClientId=client)
    hits: NDArray[np.bool_] = np.zeros(len(rays), np.bool_)
    for first in range(0, len(rays), BATCH):
        some = rays[first : first + BATCH]
        for start, end in ((0, 1), (1, 0)):
            found = pybullet.rayTestBatch(
                some[:, start].tolist(), some[:, end].tolist(), physicsClientId=client
            )
            hits[first : first + BATCH] |= [hit[0] >= 0 for hit in found]
    missed: FloatArray = rays[~hits].mean(axis=1)
    return missed
