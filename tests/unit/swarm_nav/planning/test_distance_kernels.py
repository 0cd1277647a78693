"""Distance fields and stamps against their slow twins."""

import math

import numpy as np
import pytest

from swarm_nav.planning import distance_kernels as kernels
from tests.oracles import fields as oracle

FRAME = kernels.Frame(-1.0, 2.0, 0.05)


def random_map(seed, height=17, width=23):
    rng = np.random.default_rng(seed)
    return rng.random((height, width)) < rng.choice([0.01, 0.1, 0.6])


@pytest.mark.parametrize("shape", [(1, 1), (1, 9), (9, 1), (2, 2)])
def test_the_distance_transform_takes_any_shape(shape):
    occupied = np.zeros(shape, np.bool_)
    occupied[-1, -1] = True
    assert np.allclose(kernels.face_distance(occupied), oracle.face_distance(occupied))


@pytest.mark.parametrize("seed", range(20))
def test_the_distance_to_walls_is_exact_at_their_corners_too(seed):
    occupied = random_map(seed)
    occupied[seed % 17, seed % 23] = True
    assert np.allclose(kernels.face_distance(occupied), oracle.face_distance(occupied))


@pytest.mark.parametrize("seed", range(5))
def test_samples_between_cells_are_bilinear(seed):
    rng = np.random.default_rng(seed)
    field = rng.random((6, 8))
    for x, y in rng.uniform((-1.2, 1.8), (-0.4, 2.5), (50, 2)):
        expected = oracle.sample(field, FRAME, x, y)
        assert kernels.sample(field, FRAME, x, y) == pytest.approx(expected, abs=2e-3)


def test_a_lattice_is_sampled_at_its_centres_and_no_wall_is_far():
    field = np.random.default_rng(0).random((8, 8))
    lattice = np.empty((4, 4))
    kernels.sample_lattice(field, FRAME, lattice, 0.1)
    for row, column in np.ndindex(4, 4):
        x, y = FRAME[0] + (column + 0.5) * 0.1, FRAME[1] + (row + 0.5) * 0.1
        assert lattice[row, column] == pytest.approx(oracle.sample(field, FRAME, x, y), abs=2e-3)
    assert kernels.face_distance(np.zeros((7, 9), np.bool_)).min() > math.hypot(7, 9)


@pytest.mark.parametrize("radius", [0.03, 0.2, 1.5])
def test_discs_are_stamped_where_cell_centres_lie_inside(radius):
    rng = np.random.default_rng(3)
    grid = rng.random((12, 15)).astype(np.float32)
    points = rng.uniform((-1.3, 1.7), (0.0, 2.8), (4, 2))
    expected = oracle.stamp_discs(grid, FRAME, points, radius, 0.7)
    kernels.stamp_discs(grid, FRAME, points, len(points), radius, np.float32(0.7))
    assert np.allclose(grid, expected)


def test_rows_of_points_are_stamped_with_a_radius_and_a_value_each():
    rng = np.random.default_rng(4)
    grid = rng.random((12, 15)).astype(np.float32)
    points = rng.uniform((-1.3, 1.7), (0.0, 2.8), (3, 4, 2)).astype(np.float32)
    sizes = np.array((4, 0, 2), np.uint32)
    radii, values = np.array((0.2, 1.0, 0.3)), np.array((0.7, 9.0, 0.4), np.float32)
    expected = grid
    for row in range(3):
        expected = oracle.stamp_discs(
            expected, FRAME, points[row, : sizes[row]], radii[row], values[row]
        )
    kernels.stamp_rows(grid, FRAME, points, sizes, radii, values)
    assert np.allclose(grid, expected)
