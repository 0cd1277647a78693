"""Keepout zones and speed limits on a map, as Nav2's costmap filters have them.

Zones are polygons, or filter masks: the values of a map file, 0 to 100 and unknown. Both are for
the robots alone: no LiDAR sees them. Where a cell of the map lies in several, the strictest counts.
"""

from __future__ import annotations

import functools
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from swarm_common.model.errors import MapError
from swarm_common.model.grid import KEEPOUT, OCCUPIED, Grid

if TYPE_CHECKING:
    import shapely

Points = tuple[tuple[float, float], ...]
Geometry = tuple[float, float, float, int, int]  # origin x, y, resolution, height, width
INSET = 1e-3  # of a cell: cells that only touch do not overlap


@dataclass(frozen=True, slots=True)
class KeepoutZone:
    """Polygon in the map frame in which no robot may be."""

    name: str
    points: Points


@dataclass(frozen=True, slots=True)
class SpeedZone:
    """Polygon in the map frame in which robots are slower."""

    name: str
    points: Points
    limit: float  # [m/s], or [%] of the robot's largest speed
    is_percentage: bool


@dataclass(frozen=True, slots=True)
class DirectedZone:
    """Polygon in the map frame through which ways to goals lead in one direction, or two."""

    points: Points
    direction: float  # [rad]
    free_off: float  # [rad] off it up to which a way costs no more
    most_off: float  # [rad] off it up to which a way may lead
    is_two_way: bool = False  # whether the opposite direction is as good


@dataclass(frozen=True, slots=True, eq=False)
class SpeedMask:
    """Filter mask of speed limits: value * multiplier + base, as in Nav2's CostmapFilterInfo."""

    values: Grid  # 0 to 100, or unknown
    is_percentage: bool
    base: float
    multiplier: float

    def raw_limits(self) -> NDArray[np.float64]:
        """Return the raw limit of each value from 0 to 100 (101,), [m/s] or [%]."""
        return np.arange(OCCUPIED + 1, dtype=np.float64) * self.multiplier + self.base

    def by_value(self) -> NDArray[np.float64]:
        """Return the limit of each value from 0 to 100 (101,); inf for none, as Nav2 has it.

        There is none for the value 0, and where no robot could keep it: at or below 0, above 100 %.
        """
        limits = self.raw_limits()
        limits[(limits <= 0.0) | (self.is_percentage & (limits > 100.0))] = np.inf
        limits[0] = np.inf
        return limits

    def limits(self) -> NDArray[np.float64]:
        """Return the limit (h, w) of each cell; inf where there is none."""
        return self.by_value()[np.maximum(self.values.cells, 0)]


@dataclass(frozen=True, slots=True, eq=False)
class Lanes:
    """Preferred lanes: driving beside them costs more."""

    values: Grid  # 1 to 99: costs more
    learned: Mapping[str, str] = field(default_factory=dict)  # what they were made for


@dataclass(frozen=True, slots=True, eq=False)
class Zones:
    """All zones of a world; the section `zones:` of `sites.yaml`."""

    keepout: tuple[KeepoutZone, ...] = ()
    speed: tuple[SpeedZone, ...] = ()
    keepout_mask: Grid | None = None  # 100: forbidden; 1 to 99: costs more; else free
    speed_mask: SpeedMask | None = None
    lanes: Lanes | None = None
    notes: tuple[str, ...] = ()  # how masks were understood, a sentence each

    def __bool__(self) -> bool:
        return self.has_keepout or self.has_speed or self.lanes is not None

    @property
    def has_keepout(self) -> bool:
        """Whether robots may not be everywhere."""
        return bool(self.keepout) or self.keepout_mask is not None

    @property
    def has_speed(self) -> bool:
        """Whether there is a speed limit anywhere."""
        return bool(self.speed) or self.speed_mask is not None

    def keepout_at(self, x: float, y: float) -> str:
        """Return the reason why a place is forbidden, for messages; empty if it is free."""
        for zone in self.keepout:
            if bool(_polygon(zone.points).covers(_point(x, y))):
                return f"keepout zone '{zone.name}'"
        if self.keepout_mask is not None and value_at(self.keepout_mask, x, y) == KEEPOUT:
            return "a keepout zone of the keepout mask"
        return ""

    def limit_at(self, x: float, y: float, max_speed: float) -> float:
        """Return the speed limit [m/s] of a robot at a place [m] in map; inf without one."""
        limits = [
            _in_metres(zone.limit, zone.is_percentage, max_speed)
            for zone in self.speed
            if bool(_polygon(zone.points).contains(_point(x, y)))
        ]
        if (mask := self.speed_mask) is not None:
            value = value_at(mask.values, x, y)
            limit = float(mask.by_value()[max(0, value)])
            limits.append(_in_metres(limit, mask.is_percentage, max_speed))
        return min(limits, default=np.inf)

    def mark(self, grid: Grid) -> Grid:
        """Return a map with keepout zones and lanes on it; itself if there are none."""
        if not self or grid.keepout is not None:
            return grid
        layers = _layers(self, geometry_of(grid))
        return replace(grid, keepout=layers.keepout) if layers.keepout is not None else grid

    def limits(self, geometry: Geometry, max_speed: float) -> NDArray[np.float64]:
        """Return the speed limit (h, w) [m/s] of each cell of a map; inf where there is none."""
        layers = _layers(self, geometry)
        limits: NDArray[np.float64] = np.minimum(
            layers.absolute, 0.01 * layers.percentage * max_speed
        )
        return limits


NO_ZONES = Zones()


def with_mask(grid: Grid, mask: Grid) -> Grid:
    """Return a map with a keepout mask besides the zones that it has."""
    keepout = _layers(Zones(keepout_mask=mask), geometry_of(grid)).keepout
    assert keepout is not None
    return replace(
        grid, keepout=keepout if grid.keepout is None else np.maximum(keepout, grid.keepout)
    )


@dataclass(frozen=True, slots=True)
class _Layers:
    """The zones on the cells of a map (h, w)."""

    keepout: NDArray[np.int8] | None
    absolute: NDArray[np.float64]  # [m/s], inf without a limit
    percentage: NDArray[np.float64]  # [%] of a robot's largest speed, likewise


def value_at(mask: Grid, x: float, y: float) -> int:
    """Return the value of a mask at a place; 0 beside it."""
    return int(mask.cells[mask.cell_of(x, y)]) if mask.contains(x, y) else 0


def keepout_area(zones: Zones) -> shapely.Geometry:
    """Return where no robot may be, in the map frame, prepared for many questions."""
    mask = zones.keepout_mask
    return _area(zones.keepout, mask, None if mask is None else mask.cells == KEEPOUT)


def speed_area(zones: Zones) -> shapely.Geometry:
    """Return where there is a speed limit, in the map frame."""
    mask = zones.speed_mask
    if mask is None:
        return _area(zones.speed, None, None)
    return _area(zones.speed, mask.values, np.isfinite(mask.limits()))


def triangles(area: shapely.Geometry) -> list[tuple[float, float]]:
    """Return the corners of triangles that fill an area, three for each."""
    import shapely

    corners: list[tuple[float, float]] = []
    for triangle in shapely.get_parts(shapely.constrained_delaunay_triangles(area)):
        corners += [(float(x), float(y)) for x, y in triangle.exterior.coords[:3]]
    return corners


def _area(
    polygons: Sequence[KeepoutZone | SpeedZone], mask: Grid | None, cells: NDArray[np.bool_] | None
) -> shapely.Geometry:
    """Return the union of polygons and the cells (h, w) of a mask."""
    import shapely

    parts: list[Any] = [_polygon(zone.points) for zone in polygons]
    if mask is not None and cells is not None:
        parts += _runs(mask, cells)
    area = shapely.union_all(parts)
    shapely.prepare(area)
    return area


def _runs(mask: Grid, cells: NDArray[np.bool_]) -> Iterator[Any]:
    """Yield cells (h, w) of a mask, those side by side in a row as one box."""
    import shapely

    closed = np.zeros((mask.height, mask.width + 2), np.int8)
    closed[:, 1:-1] = cells
    steps = np.diff(closed, axis=1)
    for (row, first), (_, end) in zip(np.argwhere(steps > 0), np.argwhere(steps < 0), strict=True):
        x, y, size = mask.origin_x, mask.origin_y, mask.resolution
        yield shapely.box(x + first * size, y + row * size, x + end * size, y + (row + 1) * size)


@functools.lru_cache(maxsize=4)
def _layers(zones: Zones, geometry: Geometry) -> _Layers:
    """Return all zones on a map; a zone that is nowhere on it is an error."""
    x, y, resolution, height, width = geometry
    grid = Grid(np.zeros((height, width), np.int8), resolution, x, y)
    lanes = None if zones.lanes is None else zones.lanes.values
    has_costs = zones.has_keepout or lanes is not None
    keepout = np.zeros((height, width), np.int8) if has_costs else None
    absolute, percentage = (np.full((height, width), np.inf) for _ in range(2))
    for zone in zones.keepout:
        assert keepout is not None
        keepout[_covered(f"keepout zone '{zone.name}'", zone.points, grid)] = KEEPOUT
    for name, mask in (("keepout mask", zones.keepout_mask), ("mask of lanes", lanes)):
        if keepout is not None and mask is not None:
            costs = np.maximum(mask.cells, 0)
            found = _resampled(f"the {name}", mask, costs, grid, np.maximum)
            keepout = np.maximum(keepout, found)
    for speed in zones.speed:
        limits = percentage if speed.is_percentage else absolute
        cells = _covered(f"speed zone '{speed.name}'", speed.points, grid)
        limits[cells] = np.minimum(limits[cells], speed.limit)
    if (slow := zones.speed_mask) is not None:
        limits = percentage if slow.is_percentage else absolute
        least = _resampled("the speed mask", slow.values, slow.limits(), grid, np.minimum)
        np.minimum(limits, least, out=limits)
    return _Layers(keepout, absolute, percentage)


def _covered(what: str, points: Points, grid: Grid) -> NDArray[np.bool_]:
    """Return the cells (h, w) of a grid that a polygon overlaps."""
    import shapely

    polygon = _polygon(points)
    shapely.prepare(polygon)
    covered = np.zeros(grid.cells.shape, np.bool_)
    left, low, right, high = polygon.bounds
    (r0, c0), (r1, c1) = grid.cell_of(left, low), grid.cell_of(right, high)
    r0, c0, r1, c1 = max(0, r0), max(0, c0), min(grid.height, r1 + 1), min(grid.width, c1 + 1)
    if r0 < r1 and c0 < c1:
        size = grid.resolution
        x = grid.origin_x + (np.arange(c0, c1) + INSET)[None, :] * size
        y = grid.origin_y + (np.arange(r0, r1) + INSET)[:, None] * size
        edge = (1.0 - 2.0 * INSET) * size
        boxes = shapely.box(x, y, x + edge, y + edge)
        covered[r0:r1, c0:c1] = shapely.intersects(polygon, boxes)
    if not covered.any():
        raise _beside(what, polygon.bounds, grid)
    return covered


def _resampled(
    what: str, mask: Grid, values: NDArray[Any], grid: Grid, strictest: np.ufunc
) -> NDArray[Any]:
    """Return a value for each cell of a grid: the strictest of the mask's cells that overlap it.

    Of two squares that overlap, one has a corner in the other.
    """
    nothing = 0 if strictest is np.maximum else np.inf
    found = np.full(grid.cells.shape, nothing, values.dtype)
    overlaps = False
    for row_part in (INSET, 1.0 - INSET):
        for column_part in (INSET, 1.0 - INSET):
            rows, columns = _cells_of(grid, mask, row_part, column_part)
            inner = np.ix_(
                (rows >= 0) & (rows < mask.height), (columns >= 0) & (columns < mask.width)
            )
            of_mask = np.ix_(rows[inner[0].ravel()], columns[inner[1].ravel()])
            found[inner] = strictest(found[inner], values[of_mask])
            overlaps |= found[inner].size > 0
            if mask.resolution >= grid.resolution:
                continue
            rows, columns = _cells_of(mask, grid, row_part, column_part)
            r, c = np.nonzero(values != nothing)
            r, c, v = rows[r], columns[c], values[r, c]
            on_grid = (r >= 0) & (r < grid.height) & (c >= 0) & (c < grid.width)
            strictest.at(found, (r[on_grid], c[on_grid]), v[on_grid])
    if not overlaps:
        size = mask.resolution
        right, high = mask.origin_x + mask.width * size, mask.origin_y + mask.height * size
        raise _beside(what, (mask.origin_x, mask.origin_y, right, high), grid)
    return found


def _cells_of(
    grid: Grid, other: Grid, row_part: float, column_part: float
) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Return the rows and columns of another grid in which points of all cells of a grid lie."""
    y = grid.origin_y + (np.arange(grid.height) + row_part) * grid.resolution
    x = grid.origin_x + (np.arange(grid.width) + column_part) * grid.resolution
    return (
        np.floor((y - other.origin_y) / other.resolution).astype(np.int64),
        np.floor((x - other.origin_x) / other.resolution).astype(np.int64),
    )


def _beside(what: str, bounds: tuple[float, float, float, float], grid: Grid) -> MapError:
    x, y, size = grid.origin_x, grid.origin_y, grid.resolution
    return MapError(
        f"{what}, from ({bounds[0]:g}, {bounds[1]:g}) to ({bounds[2]:g}, {bounds[3]:g}), lies"
        f" beside the map, which reaches from ({x:g}, {y:g}) to ({x + grid.width * size:g},"
        f" {y + grid.height * size:g}); zones are in the map frame [m]"
    )


def geometry_of(grid: Grid) -> Geometry:
    """Return where the cells of a grid lie, as a key of caches."""
    return grid.origin_x, grid.origin_y, grid.resolution, grid.height, grid.width


def _in_metres(limit: float, is_percentage: bool, max_speed: float) -> float:
    return 0.01 * limit * max_speed if is_percentage else limit


@functools.lru_cache(maxsize=1024)
def _polygon(points: Points) -> Any:
    import shapely

    polygon = shapely.Polygon(points)
    shapely.prepare(polygon)
    return polygon


def _point(x: float, y: float) -> Any:
    import shapely

    return shapely.Point(x, y)
