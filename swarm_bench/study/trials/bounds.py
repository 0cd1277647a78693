"""The least time that a run can take: no robot is faster than alone on its shortest way."""

from __future__ import annotations

import math

from scipy.sparse.csgraph import dijkstra

from swarm_bench.runs.episode import Episode, RunOptions, nav_config
from swarm_common.model.records import CONTROL_PERIOD, FloatArray
from swarm_mission.way_table import way_graph
from swarm_nav.planning.terrain import Terrain, terrain_for

DETOUR = 1.0 / math.cos(math.pi / 8)  # most by which a way over 8 neighbours is longer


def least_makespan(options: RunOptions, episode: Episode) -> float:
    """Return a time [s] that no method can beat.

    Each leg may begin and end a goal tolerance away from its stops; turns, acceleration and other
    robots take no time. Pauses count.

    Args:
        episode: Homes and stops of all robots.
    """
    setup = episode.setup
    specs = setup.specs
    inscribed = min(spec.inscribed_radius for spec in specs)
    config = nav_config(options, specs[0])
    terrain = terrain_for(setup.grid, config.planner, config.costmap, specs[0].circumscribed_radius)
    ways = _Ways(terrain, inscribed)
    slack = 2.0 * (config.goal_checker.xy_goal_tolerance + terrain.lattice.step)
    longest = 0.0
    for index, (home, route) in enumerate(zip(setup.starts, episode.stops, strict=True)):
        place, time = (home.x, home.y), 0.0
        for number, stop in enumerate(route):
            goal = (stop.pose_map.x, stop.pose_map.y)
            time += max(0.0, ways.length(place, goal) - slack) / specs[index].max_vel_x
            time += stop.pause_ticks * CONTROL_PERIOD if number < len(route) - 1 else 0.0
            place = goal
        longest = max(longest, time)
    return longest


class _Ways:
    """Lengths of shortest ways on a fine lattice, never longer than they are."""

    def __init__(self, terrain: Terrain, room: float) -> None:
        self._lattice = terrain.lattice
        free = self._lattice.clearance >= room - self._lattice.step
        self._graph = way_graph(free, self._lattice.step)
        self._shape = len(free), len(free[0])
        self._known: dict[int, FloatArray] = {}

    def length(self, start: tuple[float, float], goal: tuple[float, float]) -> float:
        """Return a length [m] that no way is shorter than; 0 where none is known."""
        node, other = self._node(goal), self._node(start)
        if node not in self._known:
            self._known[node] = dijkstra(self._graph, directed=False, indices=node)
        found = float(self._known[node][other]) / DETOUR
        return max(math.dist(start, goal), found) if math.isfinite(found) else 0.0

    def _node(self, place: tuple[float, float]) -> int:
        frame = self._lattice.frame
        height, width = self._shape
        row = int((place[1] - frame.origin_y) / frame.step)
        column = int((place[0] - frame.origin_x) / frame.step)
        return min(height - 1, max(0, row)) * width + min(width - 1, max(0, column))
