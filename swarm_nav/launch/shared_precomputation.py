"""Results from map and stations that all robots share, computed once before the fork.

It lies in the caches of the modules that use it; processes forked afterwards share its memory.
"""

from __future__ import annotations

import contextlib
from collections.abc import Mapping, Sequence

from swarm_common.model.grid import Grid
from swarm_nav.core.goals import PlanError
from swarm_nav.planning.planner import Planner
from swarm_nav.ros.settings import NodeSettings
from swarm_nav.traffic.conditions import Conditions, Point, conditions
from swarm_nav.traffic.gate import narrow_region
from swarm_nav.traffic.robot_state import initial_state
from swarm_nav.traffic.single_lanes import single_lanes

MANY_PROCESSES = 10  # from here on, ways to all stations cost less than each process's own


def prepare(
    robots: Sequence[NodeSettings],
    grid: Grid,
    processes: int,
    goals: Mapping[str, Sequence[Point]] | None = None,
) -> Conditions:
    """Work out what robots on a map have in common; robots of one model have all of it.

    Args:
        grid: The map that they will most likely get from the world.
        goals: (x, y) [m] in map where a robot will be told to go, by its name; one without any may
            be told to go to every station.

    Returns:
        Room on the map.

    Raises:
        MapError: If the map has too many cells when it is divided into finer ones, or a zone
            lies beside it.
    """
    grid = robots[0].sites.zones.mark(grid.refined())
    seen = set()
    for navigator in robots:
        robot = initial_state(
            navigator.config, navigator.spec, grid, navigator.robot_id, navigator.initial_pose_map
        )
        key = robot.terrain, robot.radius, str(navigator.fixed["sites"])
        if key in seen:
            continue
        seen.add(key)
        stations = tuple((pose.x, pose.y) for pose in navigator.sites.stations.values())
        narrow_region(robot.terrain, stations, robot.usual_radius)
        single_lanes(robot.terrain, robot.usual_radius)
        if processes >= MANY_PROCESSES:
            _find_ways(robot.planner, navigator)
    starts = [(navigator.initial_pose_map.x, navigator.initial_pose_map.y) for navigator in robots]
    places = [
        (goals or {}).get(navigator.name)
        or [(pose.x, pose.y) for pose in navigator.sites.stations.values()]
        or [start]
        for navigator, start in zip(robots, starts, strict=True)
    ]
    return conditions(
        [(navigator.spec, navigator.config) for navigator in robots], grid, starts, places
    )


def _find_ways(planner: Planner, navigator: NodeSettings) -> None:
    most = planner.terrain.most_goals // 2  # the rest is for goals that are not known yet
    for pose in list(navigator.sites.stations.values())[:most]:
        with contextlib.suppress(PlanError):  # no robot can go there, and each will say so
            planner.cost_to_go((pose.x, pose.y), pose.yaw)
