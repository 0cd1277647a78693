"""Stations, robots, goals and people in a random hall, where there is room for them."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from swarm_bench.halls.hall import FLOOR, Hall, draw_walls
from swarm_common.model.errors import ConfigError
from swarm_common.model.grid import Grid
from swarm_common.model.records import FloatArray, Pose
from swarm_describe.worlds.actors import WalkerSpec
from swarm_nav.core.config import CostmapConfig, PlannerConfig
from swarm_nav.planning.distance_kernels import stamp_discs
from swarm_nav.planning.search import SearchSpace
from swarm_nav.planning.search_kernels import WALL
from swarm_nav.planning.terrain import Terrain, terrain_for
from swarm_sim.maps.draw_map import draw_world
from swarm_sim.physics import scripted_paths

MISSIONS = ("random order", "pipeline", "roam", "swap")
TRIES = 60  # of halls, before a seed is given up
PAIRS = (0.6, 1.0)  # [m] between two stations of a pair
START_GAP = 0.75  # [m] between starts
CORNER = (0.35, 0.5)  # [m] from the walls of a station in a corner
DEAD_GAP = 1.0  # [m] that goals keep from a dead robot
PASS_DEAD = 0.1  # [m] beyond both radii by which a dead robot can be passed
LINE_STEP = 0.1  # [m] between the points at which a way of people is looked at


@dataclass(frozen=True, slots=True)
class HallRequest:
    """Requirements of a hall."""

    robots: int  # number, dead ones included
    radius: float  # [m] circumscribed, of the widest
    reach: float  # [m] that the widest keeps from another one's centre
    mission: str = ""  # one of `MISSIONS`; empty to draw one
    dead: int = 0  # number of dead robots
    people: int = 0  # number of people who walk


def make_hall(wish: HallRequest, seed: int) -> tuple[Hall, Grid]:
    """Return the hall of a seed and its map.

    Args:
        seed: Seed of walls, stations, homes, goals and people.

    Raises:
        ConfigError: If no hall for so many robots comes up.
    """
    rng = np.random.default_rng((seed, wish.robots))
    mission = wish.mission or MISSIONS[int(rng.integers(len(MISSIONS)))]
    for _ in range(TRIES):
        hall = draw_walls(rng, wish.robots)
        hall.mission = mission
        grid = draw_world(hall.scene())
        maker = Furnisher(hall, grid, wish, rng)
        if maker.furnish():
            return hall, grid
    raise ConfigError(f"seed {seed} gives no valid hall for {wish.robots} robots")


class Furnisher:
    """Puts stations, robots, goals and people where there is room for them."""

    def __init__(self, hall: Hall, grid: Grid, wish: HallRequest, rng: np.random.Generator) -> None:
        """Find the floor on which the widest robot can be.

        Args:
            hall: Its walls; the rest is written by `furnish`.
            rng: Random numbers; equal states give equal halls.
        """
        self._hall = hall
        self._wish = wish
        self._rng = rng
        self._gap = max(START_GAP, wish.reach + 0.1)  # [m] between starts
        self._terrain: Terrain = terrain_for(grid, PlannerConfig(), CostmapConfig(), wish.radius)
        lattice = self._terrain.lattice
        self._open = lattice.base < WALL
        self._reached = np.zeros_like(self._open)

    def furnish(self) -> bool:
        """Return whether there was room for everything."""
        hall, wish, rng = self._hall, self._wish, self._rng
        lattice = self._terrain.lattice
        self._reached = self._largest_part(np.zeros(lattice.base.shape, np.float32))
        if self._reached.sum() * lattice.step**2 < FLOOR * wish.robots:
            return False
        hall.stations = self._stations(int(rng.integers(4, 9)))
        if len(hall.stations) < 4:
            return False
        starts = self._places(wish.robots, self._gap, hall.stations, 1.0)
        if len(starts) < wish.robots:
            return False
        dead = self._dead(starts, wish.dead)
        if len(dead) < wish.dead:
            return False
        hall.homes, hall.dead = [*starts[: wish.robots - wish.dead], *dead], wish.dead
        hall.goals = self._goals(hall.mission, hall.homes[: wish.robots - wish.dead], dead)
        hall.walkers = self._people(wish.people, hall.homes)
        return bool(hall.goals) and len(hall.walkers) == wish.people

    def _largest_part(self, taken: NDArray[np.float32]) -> NDArray[np.bool_]:
        """Return the nodes of the largest part of the hall that hangs together."""
        lattice = self._terrain.lattice
        left = self._open & (taken == 0.0)
        base = np.where(left, np.float32(1.0), np.float32(WALL))
        flat = np.zeros_like(lattice.lane)
        search = SearchSpace(base, flat, lattice.heading, lattice.step)
        best = np.zeros_like(self._open)
        while left.any():
            node = int(np.flatnonzero(left)[0])
            part = np.isfinite(search.cost_to_go(node)) & left
            part.ravel()[node] = True
            if part.sum() > best.sum():
                best = part
            left &= ~part
        return best

    def _is_reached(self, x: float, y: float) -> bool:
        lattice = self._terrain.lattice
        row = int((y - lattice.origin_y) / lattice.step)
        column = int((x - lattice.origin_x) / lattice.step)
        rows, columns = self._reached.shape
        if not (0 <= row < rows and 0 <= column < columns and self._reached[row, column]):
            return False
        return self._terrain.clearance(x, y) > self._wish.radius + 0.04

    def _points(self) -> FloatArray:
        return self._terrain.lattice.points_of(np.flatnonzero(self._reached))

    def _stations(self, count: int) -> list[Pose]:
        """Return stations in corners and dead ends, at walls, some of them in pairs."""
        points, rng = self._points(), self._rng
        clear = np.array([self._terrain.clearance(x, y) for x, y in points])
        low = self._wish.radius + 0.06
        is_near = (clear > low) & (clear < max(CORNER[1], low + 0.15))
        found: list[Pose] = []
        # in a corner or a dead end there is little floor around
        floor = self._floor_around()
        for _ in range(20 * count):
            if len(found) >= count:
                break
            if found and rng.random() < 0.35:
                angle, gap = rng.uniform(-math.pi, math.pi), rng.uniform(*PAIRS)
                other = found[int(rng.integers(len(found)))]
                x, y = other.x + gap * math.cos(angle), other.y + gap * math.sin(angle)
                fits = self._is_reached(x, y) and all(
                    math.hypot(x - pose.x, y - pose.y) >= PAIRS[0] for pose in found
                )
            else:
                near = np.flatnonzero(is_near)
                if len(near) == 0:
                    break
                chosen = near[rng.integers(len(near), size=6)]
                best = chosen[np.argmin(floor[chosen])] if rng.random() < 0.7 else chosen[0]
                x, y = points[best].tolist()
                fits = self._is_reached(x, y) and all(
                    math.hypot(x - pose.x, y - pose.y) >= 1.5 for pose in found
                )
            if fits:
                yaw = float(rng.integers(4)) * math.pi / 2 if rng.random() < 0.5 else math.nan
                found.append(Pose(round(x, 3), round(y, 3), yaw))
        return found

    def _floor_around(self) -> NDArray[np.int64]:
        """Return the number of nodes within 1 m of each of `_points`, in a square."""
        lattice = self._terrain.lattice
        reach = round(1.0 / lattice.step)
        total = np.pad(self._reached.astype(np.int64), ((reach + 1, reach), (reach + 1, reach)))
        total = total.cumsum(0).cumsum(1)
        side = 2 * reach + 1
        sums = total[side:, side:] - total[:-side, side:] - total[side:, :-side]
        sums = sums + total[:-side, :-side]
        return sums[self._reached]

    def _places(self, count: int, gap: float, away: list[Pose], least: float) -> list[Pose]:
        """Return random places, `gap` apart and `least` from others."""
        points = self._points()
        order = self._rng.permutation(len(points))
        chosen: list[Pose] = []
        kept = np.zeros((0, 2))
        for x, y in points[order].tolist():
            if len(chosen) == count:
                break
            if not self._is_reached(x, y) or any(
                math.hypot(x - p.x, y - p.y) < least for p in away
            ):
                continue
            if len(kept) and np.hypot(*(kept - (x, y)).T).min() < gap:
                continue
            kept = np.vstack((kept, (x, y)))
            chosen.append(Pose(x, y, float(self._rng.uniform(-math.pi, math.pi))))
        return chosen

    def _dead(self, starts: list[Pose], count: int) -> list[Pose]:
        """Return places of dead robots around which everything stays within reach."""
        lattice = self._terrain.lattice
        dead: list[Pose] = []
        keep = [*self._hall.stations, *starts[: len(starts) - count]]
        taken = np.zeros(lattice.base.shape, np.float32)
        for pose in self._places(20 * count, self._gap, keep, DEAD_GAP):
            if len(dead) == count:
                break
            trial = taken.copy()
            block = np.array([[pose.x, pose.y]])
            reach = self._wish.reach + PASS_DEAD
            stamp_discs(trial, lattice.frame, block, 1, reach, np.float32(1.0))
            before, self._reached = self._reached, self._largest_part(trial)
            if all(self._is_reached(p.x, p.y) for p in keep):
                dead.append(pose)
                taken = trial
            else:
                self._reached = before
        return dead

    def _goals(self, mission: str, homes: list[Pose], dead: list[Pose]) -> list[list[Pose]]:
        rng, stations = self._rng, self._hall.stations
        count = min(4, len(stations))
        none: list[list[Pose]] = [[] for _ in dead]
        if mission == "pipeline":
            return [*([*stations[:count]] for _ in homes), *none]
        if mission == "random order":
            orders = [rng.permutation(len(stations))[:count] for _ in homes]
            return [*([*(stations[k] for k in order)] for order in orders), *none]
        if mission == "swap":
            turned = [*homes[1:], homes[0]]
            return [*([there, home] for there, home in zip(turned, homes, strict=True)), *none]
        rounds = [self._places(len(homes), self._gap, dead, DEAD_GAP) for _ in range(3)]
        if any(len(places) < len(homes) for places in rounds):
            return []
        return [*([places[k] for places in rounds] for k in range(len(homes))), *none]

    def _people(self, count: int, homes: Sequence[Pose]) -> tuple[WalkerSpec, ...]:
        """Return people who walk to and fro on straight lines across the floor.

        On each there is a place to begin, which the robots at their homes leave free.
        """
        people: list[WalkerSpec] = []
        points = self._points()
        stand = np.array([(home.x, home.y) for home in homes])
        for _ in range(200 * count):
            if len(people) == count:
                break
            (ax, ay), (bx, by) = points[self._rng.integers(len(points), size=2)].tolist()
            length = math.hypot(bx - ax, by - ay)
            line = np.linspace((ax, ay), (bx, by), max(2, int(length / LINE_STEP)))
            clear = min(self._terrain.clearance(x, y) for x, y in line)
            if 3.0 < length < 10.0 and clear > 0.8:
                path = ((ax, ay), (bx, by))
                person = WalkerSpec(name=f"person_{len(people) + 1}", path=path, speed=0.8)
                free = np.hypot(*(line[:, None] - stand).T).min(0) - self._wish.radius
                if free.max() > person.radius + scripted_paths.START_GAP + LINE_STEP:
                    people.append(person)
        return tuple(people)
