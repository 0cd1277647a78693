"""What the physics engine has where a body should be."""

from __future__ import annotations

import numpy as np
import pybullet
from numpy.typing import NDArray

from swarm_common.model.records import FloatArray
from swarm_sim.physics.bullet.object_bodies import add_piece, pieces_of
from swarm_sim.scene.scene import Body

BATCH = 10_000  # rays at a time


def feel(body: Body, rays: FloatArray) -> NDArray[np.bool_]:
    """Return which rays (n, 2, 3) meet a body, cast from either end.

    The engine does not report a convex shape that a ray starts in, but does from the other end.

    Args:
        body: In the world; its planes do not count.
        rays: Both ends of each [m], in the map frame.

    Returns:
        Hits (n,), bool.
    """
    client = pybullet.connect(pybullet.DIRECT)
    try:
        for piece in pieces_of(body):
            for identifier in add_piece(client, piece):  # rays are in no group of ours
                pybullet.setCollisionFilterGroupMask(identifier, -1, 1, -1, physicsClientId=client)
        hits = np.zeros(len(rays), np.bool_)
        for first in range(0, len(rays), BATCH):
            some = rays[first : first + BATCH]
            for start, end in ((0, 1), (1, 0)):
                found = pybullet.rayTestBatch(
                    some[:, start].tolist(), some[:, end].tolist(), physicsClientId=client
                )
                hits[first : first + BATCH] |= [hit[0] >= 0 for hit in found]
        return hits
    finally:
        pybullet.disconnect(physicsClientId=client)
