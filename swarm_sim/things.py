"""Room for things that can be pushed, when they are put elsewhere."""

from __future__ import annotations

import math

import numpy as np

from swarm_common.errors import WorldError
from swarm_common.shapes import Transform, transform_from_xyz_rpy
from swarm_sim.changing_world import ChangingWorld
from swarm_sim.section import section_between


def check_room_for(world: ChangingWorld, index: int, place: Transform) -> None:
    """Refuse a place where a robot stands.

    Args:
        world: With all that is in it.
        index: Of the thing among `world.loose`.
        place: Its transform in the map frame.

    Raises:
        WorldError: Naming the robot.
    """
    body = world.loose[index]
    if not np.isfinite(place).all():
        raise WorldError(f"the pose for '{body.name}' is not finite")
    x, y, _ = place[:3, 3].tolist()
    reach = thing_radius(world, index)
    for robot in world.present:
        gap = math.hypot(*(world.poses[robot, :2] - (x, y)).tolist())
        if gap < world.specs[robot].circumscribed_radius + reach:
            raise WorldError(f"{world.names[robot]} stands where '{body.name}' is to be")


def thing_radius(world: ChangingWorld, index: int) -> float:
    """Return the radius [m] of a circle around the origin of something loose that holds it all."""
    body = world.loose[index]
    x, y, _ = body.world_from_body[:3, 3].tolist()
    outlines = section_between([body], *world.heights).outlines()
    points = [outline - (x, y) for outline in outlines]
    return float(max((np.hypot(*p.T).max() for p in points), default=0.0))


def upright(x: float, y: float, z: float, yaw: float) -> Transform:
    """Return the transform of something that stands upright."""
    return transform_from_xyz_rpy(x, y, z, 0.0, 0.0, yaw)
