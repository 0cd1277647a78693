import numpy as np
import pytest

from swarm_bench.baselines.outlines import loops, simplified, wall_outlines
from swarm_common.files.map_io import load_map, map_path
from swarm_common.model.grid import Grid


def area(polygon):
    """Signed, by the shoelace formula: positive for counterclockwise ones."""
    x, y = polygon[:, 0], polygon[:, 1]
    return 0.5 * float(x @ np.roll(y, -1) - y @ np.roll(x, -1))


def grid_of(*rows):
    """Return a map of 1 m cells; `#` is occupied, the last row lies lowest."""
    cells = [[100 if sign == "#" else 0 for sign in row] for row in reversed(rows)]
    return Grid(np.array(cells, np.int8), 1.0, 0.0, 0.0)


def test_blocks_and_rooms_are_outlined():
    (outline,) = wall_outlines(grid_of(".....", ".###.", ".###.", "....."))
    assert sorted(map(tuple, outline)) == [(1, 1), (1, 3), (4, 1), (4, 3)]
    assert area(outline) == 6.0
    outlines = wall_outlines(grid_of("#####", "#...#", "#...#", "#####"))
    assert sorted(area(outline) for outline in outlines) == [-6.0, 20.0]
    outlines = wall_outlines(grid_of("##..", "##..", "..##", "..##"))
    assert [area(outline) for outline in outlines] == [4.0, 4.0]


@pytest.mark.parametrize("seed", range(20))
def test_loops_enclose_exactly_the_occupied_cells(seed):
    occupied = np.random.default_rng(seed).random((9, 11)) < 0.4
    chains = [np.array(chain, np.float64) for chain in loops(occupied)]
    assert sum(area(chain) for chain in chains) == occupied.sum()
    assert all(np.abs(np.diff(chain, axis=0)).sum(axis=1).max() == 1.0 for chain in chains)


def test_stairs_become_a_slope_and_the_hall_has_few_corners():
    stairs = [(float(k), float(k + step)) for k in range(20) for step in (0, 1)]
    polygon = simplified(np.array([*stairs, (20.0, 0.0)]), 0.75)
    assert len(polygon) <= 5
    assert area(polygon[::-1]) == pytest.approx(area(np.array([*stairs, (20.0, 0.0)])[::-1]), 0.1)
    grid = load_map(map_path("slim_blockage"))
    outlines = wall_outlines(grid)
    assert 4 <= sum(len(outline) for outline in outlines) < 200
    solid = sum(area(outline) for outline in outlines)
    assert solid == pytest.approx((grid.cells == 100).sum() * grid.resolution**2, rel=0.1)
