"""Connected free space on an occupancy grid."""

import numpy as np
import pytest

from swarm_common.model.grid import FREE, OCCUPIED
from swarm_sim.maps.raster import connected


def by_hand(cells, seeds):
    reached = np.zeros(cells.shape, np.bool_)
    todo = [(int(row), int(column)) for row, column in seeds]
    while todo:
        row, column = todo.pop()
        is_inside = 0 <= row < cells.shape[0] and 0 <= column < cells.shape[1]
        if is_inside and cells[row, column] == FREE and not reached[row, column]:
            reached[row, column] = True
            todo += [(row + 1, column), (row - 1, column), (row, column + 1), (row, column - 1)]
    return reached


@pytest.mark.parametrize("seed", range(12))
def test_cells_hang_together_by_their_sides(seed):
    rng = np.random.default_rng(seed)
    cells = np.where(rng.random((15, 20)) < 0.4, OCCUPIED, FREE).astype(np.int8)
    seeds = rng.integers(-2, 22, (seed % 4, 2))  # some outside, some on walls, or none at all
    assert np.array_equal(connected(cells, seeds), by_hand(cells, seeds))


def test_a_corner_is_no_way():
    cells = np.array(((FREE, OCCUPIED), (OCCUPIED, FREE)), np.int8)
    assert connected(cells, np.array(((0, 0),))).tolist() == [[True, False], [False, False]]
