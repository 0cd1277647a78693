"""Robots that the LiDARs of others hardly see: a LiDAR cuts all bodies at one height."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence

import shapely

from swarm_common.model.records import RobotSpec
from swarm_describe.robots.description import RobotModel
from swarm_sim.scene.section import Section, section_between


def overlooked(
    seers: Sequence[RobotSpec],
    others: Sequence[RobotSpec],
    models: Mapping[str, RobotModel],
    margin: float,
) -> Iterator[str]:
    """Yield a sentence on each model of which another one's LiDAR sees nothing, or too little."""
    bodies = {other: models[other.model].bodies() for other in dict.fromkeys(others)}
    for seer in dict.fromkeys(seers):
        for other, parts in bodies.items():
            height = seer.lidar.z
            hidden = _reach_beyond(section_between(parts, height, height), other)
            lidar = f"the LiDAR of a {seer.model}, {height:.2f} m above the ground,"
            if math.isinf(hidden):
                yield f"{lidar} does not meet a {other.model}"
            elif hidden > margin:
                enough = math.ceil(hidden * 100) / 100
                yield (
                    f"{lidar} meets a {other.model} {hidden:.2f} m inside of its outline only "
                    f"(unless costmap.unknown_body_margin is {enough:g} or more)"
                )


def _reach_beyond(section: Section, robot: RobotSpec) -> float:
    """Return the distance [m] from a section to the corner farthest from it, inf if it is empty."""
    seen = shapely.union_all([shapely.Polygon(outline) for outline in section.outlines()])
    if seen.is_empty:
        return math.inf
    return float(shapely.distance(seen, shapely.points(robot.footprint)).max())
