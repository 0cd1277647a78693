"""Zones on the cells of a map, compared with cell-by-cell twins."""

import numpy as np
import pytest
import shapely

from swarm_common.model.errors import MapError
from swarm_common.model.grid import KEEPOUT, Grid
from swarm_common.model.zones import (
    INSET,
    KeepoutZone,
    SpeedMask,
    SpeedZone,
    Zones,
    geometry_of,
    keepout_area,
    speed_area,
    triangles,
)

MAP = Grid(np.zeros((20, 30), np.int8), 0.1, -1.0, -0.5)


def overlapping(area, grid):
    """Return which cells an area overlaps, cell by cell."""
    found = np.zeros(grid.cells.shape, np.bool_)
    for row, column in np.ndindex(found.shape):
        x, y = grid.center_of(row, column)
        half = (0.5 - INSET) * grid.resolution
        cell = shapely.box(x - half, y - half, x + half, y + half)
        found[row, column] = shapely.intersects(area, cell)
    return found


@pytest.mark.parametrize("seed", range(4))
def test_a_polygon_closes_every_cell_that_it_overlaps(seed):
    rng = np.random.default_rng(seed)
    corners = shapely.MultiPoint(rng.uniform((-1.5, -1.0), (2.5, 2.0), (6, 2))).convex_hull
    zone = KeepoutZone("a", tuple(corners.exterior.coords[:-1]))
    marked = Zones(keepout=(zone,)).mark(MAP)
    assert marked.keepout is not None
    assert np.array_equal(marked.keepout == KEEPOUT, overlapping(corners, MAP))
    assert np.array_equal(marked.cells, MAP.cells)


def test_a_zone_on_the_lines_of_the_map_closes_no_further_cells_also_finer_ones():
    zone = KeepoutZone("a", ((0.0, 0.0), (0.3, 0.0), (0.3, 0.2), (0.0, 0.2)))
    marked = Zones(keepout=(zone,)).mark(MAP)
    assert marked.keepout is not None
    rows, columns = np.nonzero(marked.keepout)
    assert (set(rows), set(columns)) == ({5, 6}, {10, 11, 12})
    zone = KeepoutZone("a", ((0.0, 0.0), (0.1, 0.0), (0.1, 0.1), (0.0, 0.1)))
    fine = Zones(keepout=(zone,)).mark(MAP).refined()
    assert fine.keepout.shape == fine.cells.shape
    assert (fine.keepout == KEEPOUT).sum() == 4


@pytest.mark.parametrize("resolution", [0.03, 0.1, 0.25])
@pytest.mark.parametrize("origin", [(-1.0, -0.5), (-1.04, -0.47), (-1.9, 0.3), (1.2, 1.1)])
def test_a_mask_of_any_resolution_closes_the_cells_that_it_overlaps(resolution, origin):
    """A thin line of a fine mask must not fall between the cells of the map."""
    cells = (np.random.default_rng(1).random((30, 40)) < 0.05).astype(np.int8) * KEEPOUT
    cells[3, :] = 40
    mask = Grid(cells, resolution, *origin)
    zones = Zones(keepout_mask=mask)
    marked = zones.mark(MAP)
    assert marked.keepout is not None
    expected = overlapping(keepout_area(zones), MAP)
    assert np.array_equal(marked.keepout == KEEPOUT, expected)


def test_a_turned_mask_is_where_its_origin_says():
    cells = np.full((4, 4), KEEPOUT, np.int8)
    turned = Grid(cells, 0.1, 0.4, 0.0, np.pi / 2).upright()
    marked = Zones(keepout_mask=turned).mark(MAP)
    assert marked.keepout is not None
    assert set(np.nonzero(marked.keepout)[1]) == {10, 11, 12, 13}  # x from 0 to 0.4


def test_the_lowest_limit_counts():
    left, both = ((0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)), SpeedZone
    values = np.full((2, 2), 30, np.int8)
    zones = Zones(
        speed=(both("a", left, 0.2, False), both("b", left, 50.0, True)),
        speed_mask=SpeedMask(Grid(values, 0.5, 0.5, 0.0), False, 0.0, 0.01),
    )
    limits = zones.limits(geometry_of(MAP), 1.0)
    assert [limits[7, column] for column in (9, 12, 16, 22)] == [np.inf, 0.2, 0.2, 0.3]
    assert zones.limits(geometry_of(MAP), 0.2)[7, 12] == pytest.approx(0.1)
    assert speed_area(zones).area == pytest.approx(1.5)


@pytest.mark.parametrize(
    "zones",
    [
        Zones(keepout=(KeepoutZone("far", ((9, 9), (10, 9), (10, 10))),)),
        Zones(speed=(SpeedZone("far", ((9, 9), (10, 9), (10, 10)), 0.1, False),)),
        Zones(keepout_mask=Grid(np.full((2, 2), KEEPOUT, np.int8), 0.1, 9.0, 9.0)),
    ],
)
def test_a_zone_beside_the_map_is_an_error(zones):
    with pytest.raises(MapError, match=r"lies beside the map, which reaches from \(-1, -0.5\)"):
        zones.mark(MAP)


def test_triangles_fill_an_area_with_a_hole():
    area = shapely.box(0, 0, 3, 3) - shapely.box(1, 1, 2, 2)
    corners = np.array(triangles(area)).reshape(-1, 3, 2)
    assert sum(shapely.Polygon(three).area for three in corners) == pytest.approx(8.0)
