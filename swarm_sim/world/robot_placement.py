"""Whether a robot may be put somewhere while others drive: room to stand, and nobody on the way."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import shapely

from swarm_common.model.errors import WorldError
from swarm_common.model.records import FloatArray, Pose, RobotSpec
from swarm_describe.worlds.scene import GROUND_GAP, Body
from swarm_sim.maps.spawn import wall_distance
from swarm_sim.scene.section import section_between
from swarm_sim.world.changing_world import ChangingWorld

GAP = 0.05  # [m] between the robot's circle and anything
MARGIN = 0.047  # [m] by which a navigator's disc is larger than its body (traffic.safety_margin)


def check_robot_place(
    world: ChangingWorld, spec: RobotSpec, pose: Pose, robot: int | None = None
) -> None:
    """Refuse a place where a robot must not be put now.

    What another robot holds or has requested in its last beacon counts as its space: only there
    can it drive before it hears of the newcomer.

    Args:
        robot: Index, if it is in the world already.

    Raises:
        WorldError: Saying what is in the way.
    """
    if not all(map(math.isfinite, (pose.x, pose.y, pose.yaw))):
        raise WorldError(f"({pose.x}, {pose.y}, {pose.yaw}) is no place")
    where = f"at ({pose.x:.2f}, {pose.y:.2f})"
    _check_bodies(world, spec, pose, where)
    for x, y, radius in world.walkers():
        if math.hypot(x - pose.x, y - pose.y) < radius + spec.circumscribed_radius + GAP:
            raise WorldError(
                f"{where} there is no room: somebody walks at ({x:.2f}, {y:.2f}),"
                f" {math.hypot(x - pose.x, y - pose.y):.2f} m from there"
            )
    for other in world.present:
        if other != robot:
            _check_robot(world, other, spec, pose, where)


def _check_bodies(world: ChangingWorld, spec: RobotSpec, pose: Pose, where: str) -> None:
    point = np.array([[pose.x, pose.y]])
    for body in (*world.scene.fixed, *world.objects()):
        gap = _gap(body, point, spec.height)
        if gap < spec.circumscribed_radius + GAP:
            inside = "inside" if gap <= 0.0 else f"{gap:.2f} m from"
            raise WorldError(
                f"{where} the robot would stand {inside} '{body.name}'; "
                f"a {spec.model} needs {spec.circumscribed_radius + GAP:.2f} m"
            )


def _gap(body: Body, point: FloatArray, height: float) -> float:
    section = section_between([body], GROUND_GAP, height)
    return float(wall_distance(point, section)[0]) if section.names else math.inf


def _check_robot(world: ChangingWorld, other: int, spec: RobotSpec, pose: Pose, where: str) -> None:
    x, y, _ = world.poses[other].tolist()
    name, radius = world.names[other], spec.circumscribed_radius
    gap = math.hypot(x - pose.x, y - pose.y)
    need = world.specs[other].circumscribed_radius + radius + GAP
    if gap < need:
        raise WorldError(
            f"{where} there is no room: {name} stands at ({x:.2f}, {y:.2f}),"
            f" {gap:.2f} m from there; a {spec.model} needs {need:.2f} m"
        )
    if claim_gap(world, other, shapely.Point(pose.x, pose.y)) < radius + MARGIN:
        raise WorldError(
            f"{where} there is no room: {name} is about to drive there, from ({x:.2f}, {y:.2f});"
            " wait, or take another place"
        )


def claim_gap(world: ChangingWorld, robot: int, outline: Any) -> float:
    """Return the distance [m] of a geometry from the space that a robot holds or has requested.

    That space is as in its last beacon.

    Returns:
        Negative where they overlap; inf without a beacon.
    """
    beacon = world.last_beacons[robot]
    if beacon is None:
        return math.inf
    gaps = [
        (shapely.LineString(points) if len(points) > 1 else shapely.Point(points[0])).distance(
            outline
        )
        for part in ("held", "wanted")
        if len(points := beacon[part][: int(beacon[f"{part}_size"])].astype(np.float64))
    ]
    return min(gaps, default=math.inf) - float(beacon["radius"])


def check_height(world: ChangingWorld, spec: RobotSpec) -> None:
    """Refuse a robot that reaches up to something that none of the first ones did.

    Raises:
        WorldError: Naming it.
    """
    tallest = world.heights[1]
    if spec.height <= tallest:
        return
    known = set(section_between(world.scene.fixed, GROUND_GAP, tallest).names)
    for name in section_between(world.scene.fixed, GROUND_GAP, spec.height).names:
        if name not in known:
            raise WorldError(
                f"a {spec.model} is {spec.height:.2f} m high and reaches '{name}', which no robot "
                "did at the start; start one with the swarm"
            )
