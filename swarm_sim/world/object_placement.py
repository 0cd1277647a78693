"""Checks of places for objects that are added or moved while robots drive."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import numpy as np
import shapely

from swarm_common.model.errors import WorldError
from swarm_common.model.shapes import Sphere, Transform, transform_from_xyz_rpy
from swarm_describe.worlds.overlaps import points_of
from swarm_describe.worlds.scene import Body
from swarm_sim.scene.section import section_between
from swarm_sim.world.changing_world import ChangingWorld
from swarm_sim.world.robot_placement import claim_gap

GAP = 0.05  # [m] between a thing and a robot's circle, or the space that it holds
DEPTH = 0.01  # [m] by which a thing may reach into something else, or the ground


def check_object_place(world: ChangingWorld, body: Body, index: int | None = None) -> None:
    """Refuse a place where a thing must not be.

    What a robot holds or has requested in its last beacon counts as its space, as for robots
    (`robot_placement`): only there can it drive before it sees the newcomer.

    Args:
        index: Given if it is in the world already.

    Raises:
        WorldError: Saying what is in the way.
    """
    low, high = height_range(body)
    if low < -DEPTH:
        z = body.world_from_body[2, 3] - low
        raise WorldError(
            f"'{body.name}' would reach {-low:.2f} m into the ground; on it, its z is {z:.3f}"
        )
    loose = [thing for i, thing in enumerate(world.objects()) if i != index]
    check_apart(body, (*world.scene.fixed, *loose))
    # A loose object may fall and is in the way at any height; a fixed one only at that of robots.
    outline = outline_of(body, world.heights if body.is_static else (low, high))
    if outline.is_empty:
        return
    for x, y, radius in world.walkers().tolist():
        if shapely.Point(x, y).distance(outline) < radius:
            raise WorldError(f"somebody walks where '{body.name}' is to be")
    for robot in world.present:
        _check_robot(world, robot, body.name, outline)


def check_apart(body: Body, others: Iterable[Body]) -> None:
    """Refuse an object that intersects another one; touching it, or standing on it, is allowed.

    Raises:
        WorldError: Naming the other.
    """
    low, high = height_range(body)
    slab = (low + DEPTH, high - DEPTH) if high - low > 2.0 * DEPTH else (0.5 * (low + high),) * 2
    core = outline_of(body, slab).buffer(-DEPTH)
    for other in others:
        if not core.is_empty and core.intersects(outline_of(other, slab)):
            raise WorldError(f"'{body.name}' would be inside '{other.name}'")


def _check_robot(world: ChangingWorld, robot: int, what: str, outline: Any) -> None:
    x, y, _ = world.poses[robot].tolist()
    name = world.names[robot]
    if shapely.Point(x, y).distance(outline) < world.specs[robot].circumscribed_radius + GAP:
        raise WorldError(f"{name} stands where '{what}' is to be")
    if claim_gap(world, robot, outline) < GAP:
        raise WorldError(
            f"{name} is about to drive where '{what}' is to be; wait, or take another place"
        )


def height_range(body: Body) -> tuple[float, float]:
    """Return the lowest and the highest z [m] of a body in the world."""
    lows, highs = [], []
    for part in body.parts:
        if isinstance(part.shape, Sphere):
            z = float((body.world_from_body @ part.body_from_part)[2, 3])
            heights = np.array([z - part.shape.radius, z + part.shape.radius])
        else:
            heights = points_of(part, body)[:, 2]
        lows.append(float(heights.min()))
        highs.append(float(heights.max()))
    return min(lows), max(highs)


def outline_of(body: Body, heights: tuple[float, float]) -> Any:
    """Return a body between two heights, from above, as a shapely geometry, which may be empty."""
    polygons = section_between([body], *heights).outlines()
    return shapely.union_all([shapely.Polygon(polygon) for polygon in polygons])


def upright(x: float, y: float, z: float, yaw: float) -> Transform:
    """Return the transform of something that stands upright."""
    return transform_from_xyz_rpy(x, y, z, 0.0, 0.0, yaw)
