"""Clearances, keep-right lanes and parking places, which a robot derives once from the shared map.

Lanes follow from the map's distance transform D alone: in passages the preferred direction h is
the one with the nearer wall on the right, h = (g_y, -g_x) / |g| with g = grad D, so that any map
gets two-way passages and one sense of circulation around islands without hand-drawn lanes.
"""

from __future__ import annotations

import contextlib
import copy
import dataclasses
import functools
import math
from collections.abc import Iterator
from dataclasses import dataclass, field
from weakref import WeakValueDictionary

import numpy as np
from numpy.typing import NDArray

from swarm_common.model.grid import KEEPOUT, OCCUPIED, UNKNOWN, Grid
from swarm_common.model.records import FloatArray
from swarm_common.model.zones import DirectedZone
from swarm_common.process.libm import exp
from swarm_nav.core.config import CostmapConfig, PlannerConfig
from swarm_nav.planning import distance_kernels, search_kernels
from swarm_nav.planning.cells import window_max
from swarm_nav.planning.directed import Directions
from swarm_nav.planning.distance_kernels import Field, Frame
from swarm_nav.planning.oblong import SLOT_COST, Oblong, Slots
from swarm_nav.planning.search import SearchSpace

HALL_DISTANCE = 2.0  # [m] from any wall: open floor, no lanes and free for parking
PASSAGE_REACH = 0.95  # [m] within which the widest clearance of a passage is looked for
STRIP_WIDTH = 0.26  # [m] next to the ridge of a passage that separates its lanes
PARKING_HALF_WIDTH = 1.35  # [m] of a passage whose median strip may hold a parked robot
NODE_MARGIN = 0.04  # [m] beyond the robot's circumscribed radius at which nodes end
APPROACH_RADIUS = 0.7  # [m] around a goal in which the way leads in the goal's direction
SECTOR_ANGLE = math.pi / 8  # [rad] to which that direction is rounded
ANY_SECTOR = -1
WALL_COST = 0.6  # extra cost per metre right beside a wall
GOALS_MEMORY = 64_000_000  # [bytes] of costs to go that a process keeps per terrain
KEEPOUT_COST = (
    4.0  # extra cost per metre of the keepout mask's value 99: Nav2's NavFn, 0.8 * 252 / 50
)
STANDING_ROOM = 0.1  # [m] more than the wall clearance from where no wall cost applies


def wall_clearance(costmap: CostmapConfig, radius: float) -> float:
    """Return the clearance [m] that the centre of a robot keeps from walls where it can.

    Args:
        radius: [m] circumscribed radius of the robot.
    """
    return max(costmap.wall_clearance, radius + NODE_MARGIN)


def sector_of(yaw: float) -> int:
    """Return the sector of a direction for `Terrain.approach`.

    Args:
        yaw: [rad] in map; NaN for any direction.

    Returns:
        0 to 15, or `ANY_SECTOR`.
    """
    return ANY_SECTOR if math.isnan(yaw) else round(yaw / SECTOR_ANGLE) % 16


@dataclass(frozen=True, slots=True)
class Lattice:
    """Planning lattice; arrays are (height, width), cells of `step` from (origin_x, origin_y)."""

    step: float
    origin_x: float
    origin_y: float
    clearance: FloatArray  # [m] to the nearest wall
    # cost factor of a metre, `search_kernels.WALL` where the robot does not fit
    base: NDArray[np.float32]
    lane: NDArray[np.float32]  # extra cost factor of driving against `heading`
    # (height, width, 2) unit direction with the nearer wall on the right
    heading: NDArray[np.float32]
    parking: NDArray[np.uint8]  # 1 where a waiting robot stands out of the lanes
    slots: Slots | None = None  # where a long robot only drives straight through; None for others
    frame: Frame = field(init=False)  # where the nodes lie

    def __post_init__(self) -> None:
        """Put the frame together once: every tick of every robot asks for it."""
        object.__setattr__(self, "frame", Frame(self.origin_x, self.origin_y, self.step))

    def node_of(self, x: float, y: float, extra: NDArray[np.float32] | None = None) -> int | None:
        """Return the open node nearest to a point within two cells.

        Args:
            x: [m] in map.
            y: [m] in map.
            extra: (h, w); nodes that it closes are chosen only if there is no other. None: no
                node is closed.

        Returns:
            The flat index; None if there is no open node.
        """
        closed = self.base if extra is None else extra
        node = search_kernels.nearest_open(self.base, closed, self.frame, x, y)
        return node if node >= 0 else None

    def point_of(self, node: int) -> tuple[float, float]:
        """Return the centre of a node.

        Returns:
            (x, y) [m] in map.
        """
        row, column = divmod(node, self.base.shape[1])
        return (self.origin_x + (column + 0.5) * self.step, self.origin_y + (row + 0.5) * self.step)

    def points_of(self, nodes: NDArray[np.integer]) -> FloatArray:
        """Return the centres of nodes.

        Args:
            nodes: (n,) flat indices.

        Returns:
            (n, 2) [m] in map.
        """
        rows, columns = np.divmod(nodes, self.base.shape[1])
        return np.column_stack(
            (self.origin_x + (columns + 0.5) * self.step, self.origin_y + (rows + 0.5) * self.step)
        )


def as_large_as(terrain: Terrain, radius: float) -> Terrain:
    """Return a terrain with the lattice of another, but with a larger radius; results are kept.

    Args:
        terrain: For the robot's own size; it is returned itself if the other robot is no larger.
        radius: [m] circumscribed radius of the other robot.
    """
    is_larger = round(radius - terrain.radius, 3) > 0.0  # in mm: beacons are of single precision
    return _enlarged(terrain, radius) if is_larger else terrain


@functools.lru_cache(maxsize=4)
def _enlarged(terrain: Terrain, radius: float) -> Terrain:
    other = copy.copy(terrain)
    other.radius = radius
    return other


@functools.lru_cache(maxsize=4)
def _directed(terrain: Terrain, zones: tuple[DirectedZone, ...]) -> Terrain:
    other = copy.copy(terrain)
    other._begin_searches(Directions(zones, terrain.lattice.frame))
    return other


class Terrain:
    """Static knowledge of one map for one size of robot.

    Attributes:
        field: Distances to where the robot must not be: mapped walls and keepout zones.
        walls: Distances to mapped walls, which the LiDAR sees.
        wall_clearance: [m] that smooth paths keep from walls where they can.
        most_goals: Number of goals to which the costs of driving are kept.
    """

    def __init__(
        self,
        grid: Grid,
        planner: PlannerConfig,
        costmap: CostmapConfig,
        radius: float,
        oblong: Oblong | None = None,
    ) -> None:
        """Derive everything from the map.

        Args:
            radius: [m] circumscribed radius of the robot.
            oblong: Outline of a long robot, else None.
        """
        self.grid = grid
        self._made_of = planner, costmap, radius, oblong
        self.radius = radius
        self.wall_clearance = wall_clearance(costmap, radius)
        occupied = grid.cells == OCCUPIED
        if not planner.allow_unknown:
            occupied |= grid.cells == UNKNOWN
        self.frame = Frame(grid.origin_x, grid.origin_y, grid.resolution)
        self.walls = self.field = _distances(occupied, self.frame)
        if grid.keepout is not None:
            self.field = _distances(occupied | (grid.keepout == KEEPOUT), self.frame)
        self.distance: FloatArray = self.field.distance
        self.lattice = _lattice(self.field, grid, planner, costmap, radius)
        if oblong is not None:
            self.lattice = _with_slots(self.lattice, oblong, self.field)
        self._begin_searches(None)
        self._approach_weight = 2.0 * planner.lane_weight

    def _begin_searches(self, directions: Directions | None) -> None:
        """Begin to search the lattice, and to keep the costs of driving to goals."""
        lattice = self.lattice
        layers = lattice.base, lattice.lane, lattice.heading
        self.search = SearchSpace(*layers, lattice.step, lattice.slots, directions)
        self.most_goals = GOALS_MEMORY // self.lattice.base.nbytes + 1
        self._in_use: WeakValueDictionary[tuple[int, int], NDArray[np.float32]] = (
            WeakValueDictionary()
        )
        self._cost_to_go = functools.lru_cache(self.most_goals)(self._find_cost_to_go)
        self._costs_in_order = functools.lru_cache(self.most_goals)(self._sort_costs)

    def directed(self, zones: tuple[DirectedZone, ...]) -> Terrain:
        """Return the terrain for ways that heed directed zones; results are kept."""
        return _directed(self, zones) if zones else self

    def clearance(self, x: float, y: float) -> float:
        """Return the distance [m] to the nearest mapped wall or keepout zone.

        Args:
            x: [m] in map.
            y: [m] in map.
        """
        return float(distance_kernels.sample(self.distance, self.frame, x, y))

    def clearances(self, path: FloatArray, room: float) -> FloatArray:
        """Return the `clearance` (n,) along a path; walls alone count where it leaves a zone.

        A robot that was put into a keepout zone, or is too near to one, may drive out of it.

        Args:
            path: (n, 2) [m] in map.
            room: [m] that the robot needs.
        """
        clear = np.array([self.clearance(x, y) for x, y in path.tolist()])
        x, y = path[0].tolist()
        if not self.is_in_keepout(x, y, room):
            return clear
        walls = np.array([distance_kernels.sample(*self.walls, x, y) for x, y in path.tolist()])
        out = np.flatnonzero(clear >= np.minimum(walls, room))
        leaving = np.arange(len(path)) < (out[0] if len(out) else len(path))
        leaving &= clear >= clear[0] - 1e-6  # not deeper into it
        clear[leaving] = walls[leaving]
        return clear

    def is_keepout(self, x: float, y: float) -> bool:
        """Whether a point on the map lies in a keepout zone.

        Args:
            x: [m] in map.
            y: [m] in map.
        """
        zones = self.grid.keepout
        return zones is not None and bool(zones[self.grid.cell_of(x, y)] == KEEPOUT)

    def is_in_keepout(self, x: float, y: float, room: float) -> bool:
        """Whether a keepout zone is nearer to a point than any wall, and than a robot needs.

        Args:
            x: [m] in map.
            y: [m] in map.
            room: [m] that the robot needs.
        """
        if self.grid.keepout is None:
            return False
        clear = self.clearance(x, y)
        return clear < min(room, float(distance_kernels.sample(*self.walls, x, y)) - 1e-6)

    @functools.cached_property
    def without_keepout(self) -> Terrain:
        """The terrain on which a robot leaves a keepout zone: walls alone count."""
        if self.grid.keepout is None:
            return self
        return Terrain(dataclasses.replace(self.grid, keepout=None), *self._made_of)

    def cost_to_go(self, node: int, sector: int = ANY_SECTOR) -> NDArray[np.float32]:
        """Return the cost of driving from every node to one of them, without other robots.

        Args:
            sector: Direction of the last metre, see `sector_of`.

        Returns:
            (h, w) [m], kept for the next calls, as long as somebody holds it; inf where the goal
            cannot be reached from.
        """
        return self._cost_to_go(node, sector)

    def costs_in_order(self, node: int) -> NDArray[np.float32]:
        """Return the finite costs of driving to a node, in rising order.

        Returns:
            (n,) [m], kept for the next call.
        """
        return self._costs_in_order(node)

    def _sort_costs(self, node: int) -> NDArray[np.float32]:
        costs = self.cost_to_go(node)
        return np.sort(costs[np.isfinite(costs)])

    def _find_cost_to_go(self, node: int, sector: int) -> NDArray[np.float32]:
        costs = self._in_use.get((node, sector))
        if costs is None:
            with self.approach(node, sector):
                costs = self._in_use[node, sector] = self.search.cost_to_go(node)
        return costs

    @contextlib.contextmanager
    def approach(self, node: int, sector: int) -> Iterator[None]:
        """Within it, the last metre to a node is a lane in the goal's direction.

        So robots arrive at a station one behind the other, with the heading that is asked for,
        and leave it ahead, instead of meeting head-on in front of it.

        Args:
            sector: The direction, see `sector_of`; `ANY_SECTOR` changes nothing.
        """
        if sector == ANY_SECTOR:
            yield
            return
        lattice = self.lattice
        row, column = divmod(node, lattice.base.shape[1])
        reach = round(APPROACH_RADIUS / lattice.step)
        box = (
            slice(max(0, row - reach), row + reach + 1),
            slice(max(0, column - reach), column + reach + 1),
        )
        lane, heading = lattice.lane[box].copy(), lattice.heading[box].copy()
        try:
            yaw = sector * SECTOR_ANGLE
            np.maximum(lane, self._approach_weight, out=lattice.lane[box])
            lattice.heading[box] = (math.cos(yaw), math.sin(yaw))
            yield
        finally:
            lattice.lane[box], lattice.heading[box] = lane, heading


@functools.lru_cache(maxsize=4)
def _shared(
    key: bytes,
    keepout: bytes,
    resolution: float,
    origin: tuple[float, float, int, int],
    planner: PlannerConfig,
    costmap: CostmapConfig,
    radius: float,
    oblong: Oblong | None,
) -> Terrain:
    shape = origin[2], origin[3]
    zones = np.frombuffer(keepout, np.int8).reshape(shape) if keepout else None
    cells = np.frombuffer(key, np.int8).reshape(shape)
    grid = Grid(cells, resolution, origin[0], origin[1], keepout=zones)
    return Terrain(grid, planner, costmap, radius, oblong)


def terrain_for(
    grid: Grid,
    planner: PlannerConfig,
    costmap: CostmapConfig,
    radius: float,
    oblong: Oblong | None = None,
) -> Terrain:
    """Return the terrain of a map; equal arguments in one process share one object.

    Args:
        grid: The map; coarse cells are divided into finer ones.
        radius: [m] circumscribed radius of the robot.
        oblong: Outline of a long robot, else None.

    Raises:
        MapError: If the finer map would have too many cells.
    """
    grid = grid.refined()
    origin = (grid.origin_x, grid.origin_y, grid.height, grid.width)
    keepout = b"" if grid.keepout is None else grid.keepout.tobytes()
    return _shared(
        grid.cells.tobytes(), keepout, grid.resolution, origin, planner, costmap, radius, oblong
    )


def _lattice(
    field: Field, grid: Grid, planner: PlannerConfig, costmap: CostmapConfig, radius: float
) -> Lattice:
    step = max(planner.resolution, grid.resolution)
    height = max(2, int(grid.height * grid.resolution / step))
    width = max(2, int(grid.width * grid.resolution / step))
    clear = np.empty((height, width))
    distance_kernels.sample_lattice(field.distance, field.frame, clear, step)
    widest = window_max(clear, round(PASSAGE_REACH / step))
    gradient_y, gradient_x = np.gradient(clear, step)
    slope = np.hypot(gradient_x, gradient_y)
    safe = np.maximum(slope, 1e-6)
    heading = np.stack((gradient_y / safe, -gradient_x / safe), axis=-1).astype(np.float32)
    lane = (
        planner.lane_weight
        * np.clip((planner.lane_width - clear) / 1.0, 0.0, 1.0)
        * np.minimum(slope, 1.0) ** 2
    )
    is_passage = widest < HALL_DISTANCE
    strip = is_passage & (clear > widest - STRIP_WIDTH)
    base = 1.0 + strip + WALL_COST * _wall_share(clear, costmap, radius)
    if grid.keepout is not None:
        base += KEEPOUT_COST / (KEEPOUT - 1) * _on_lattice(grid.keepout, grid, step, base.shape)
    base[clear < radius + NODE_MARGIN] = search_kernels.WALL
    parking = (clear > HALL_DISTANCE) | (
        is_passage & (widest >= PARKING_HALF_WIDTH) & (clear > widest - 0.6 * STRIP_WIDTH)
    )
    return Lattice(
        step,
        grid.origin_x,
        grid.origin_y,
        clear,
        base.astype(np.float32),
        lane.astype(np.float32),
        heading,
        parking.astype(np.uint8),
    )


def _on_lattice(
    layer: NDArray[np.int8], grid: Grid, step: float, shape: tuple[int, ...]
) -> NDArray[np.int8]:
    rows, columns = (
        np.minimum(((np.arange(n) + 0.5) * step / grid.resolution).astype(np.int64), most - 1)
        for n, most in zip(shape, layer.shape, strict=True)
    )
    return layer[np.ix_(rows, columns)]


def _distances(occupied: NDArray[np.bool_], frame: Frame) -> Field:
    return Field(distance_kernels.face_distance(occupied) * frame.step, frame)


def _with_slots(lattice: Lattice, oblong: Oblong, field: Field) -> Lattice:
    room = oblong.radius + NODE_MARGIN
    slots = Slots(oblong, field, lattice.clearance, lattice.frame, room)
    base = np.where(slots.axes >= 0, np.float32(SLOT_COST), lattice.base)
    return dataclasses.replace(lattice, base=base, slots=slots)


def _wall_share(clear: FloatArray, costmap: CostmapConfig, radius: float) -> FloatArray:
    """Return 0..1: Nav2's inflation cost, scaled to vanish at the wall clearance plus room."""
    inflated = exp(-costmap.cost_scaling_factor * np.maximum(clear - radius, 0.0))
    free = math.exp(
        -costmap.cost_scaling_factor * (wall_clearance(costmap, radius) + STANDING_ROOM - radius)
    )
    return np.clip((inflated - free) / (1.0 - free), 0.0, 1.0)
