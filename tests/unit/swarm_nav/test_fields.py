"""Distance fields and polylines against their slow twins."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from swarm_common.model.records import Pose
from swarm_nav.planning import distance_kernels as kernels
from swarm_nav.planning import path_kernels
from swarm_nav.planning.planner import SPACING, path_length, straight_path
from tests.oracles import fields as oracle

FRAME = kernels.Frame(-1.0, 2.0, 0.05)
FINE, COARSE = kernels.Frame(0.0, 0.0, 0.05), kernels.Frame(0.0, 0.0, 0.1)


def random_map(seed: int, height: int = 17, width: int = 23) -> np.ndarray:
    rng = np.random.default_rng(seed)
    return rng.random((height, width)) < rng.choice([0.01, 0.1, 0.6])


@pytest.mark.parametrize("seed", range(20))
def test_the_distance_transform_is_exact(seed: int) -> None:
    occupied = random_map(seed)
    occupied[seed % 17, seed % 23] = True
    assert np.allclose(kernels.distance_cells(occupied), oracle.distance_cells(occupied))


@pytest.mark.parametrize("shape", [(1, 1), (1, 9), (9, 1), (2, 2)])
def test_the_distance_transform_takes_any_shape(shape: tuple[int, int]) -> None:
    occupied = np.zeros(shape, np.bool_)
    occupied[-1, -1] = True
    assert np.allclose(kernels.distance_cells(occupied), oracle.distance_cells(occupied))


def test_a_map_without_walls_is_farther_than_its_diagonal() -> None:
    assert kernels.distance_cells(np.zeros((7, 9), np.bool_)).min() > math.hypot(7, 9)


@pytest.mark.parametrize("seed", range(5))
def test_samples_between_cells_are_bilinear(seed: int) -> None:
    rng = np.random.default_rng(seed)
    field = rng.random((6, 8))
    for x, y in rng.uniform((-1.2, 1.8), (-0.4, 2.5), (50, 2)):
        expected = oracle.sample(field, FRAME, x, y)
        assert kernels.sample(field, FRAME, x, y) == pytest.approx(expected, abs=2e-3)


def test_a_lattice_is_sampled_at_its_centres() -> None:
    field = np.random.default_rng(0).random((8, 8))
    lattice = np.empty((4, 4))
    kernels.sample_lattice(field, FRAME, lattice, 0.1)
    for row, column in np.ndindex(4, 4):
        x, y = FRAME[0] + (column + 0.5) * 0.1, FRAME[1] + (row + 0.5) * 0.1
        assert lattice[row, column] == pytest.approx(oracle.sample(field, FRAME, x, y), abs=2e-3)


@pytest.mark.parametrize("reach", [0, 1, 3])
def test_the_window_maximum_looks_at_a_disc(reach: int) -> None:
    field = np.random.default_rng(reach).random((9, 12))
    out = np.empty_like(field)
    kernels.window_max(field, reach, out)
    assert np.array_equal(out, oracle.window_max(field, reach))


@pytest.mark.parametrize("radius", [0.03, 0.2, 1.5])
def test_discs_are_stamped_where_cell_centres_lie_inside(radius: float) -> None:
    rng = np.random.default_rng(3)
    grid = rng.random((12, 15)).astype(np.float32)
    points = rng.uniform((-1.3, 1.7), (0.0, 2.8), (4, 2))
    expected = oracle.stamp_discs(grid, FRAME, points, radius, 0.7)
    kernels.stamp_discs(grid, FRAME, points, len(points), radius, np.float32(0.7))
    assert np.allclose(grid, expected)


def test_rows_of_points_are_stamped_with_a_radius_and_a_value_each() -> None:
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


def test_untouched_is_what_is_allowed_and_not_stamped() -> None:
    stamped = np.array(((0.0, 1.0), (0.0, 0.0)), np.float32)
    out = np.empty((2, 2), np.uint8)
    kernels.untouched(stamped, np.array(((1, 1), (0, 2)), np.uint8), out)
    assert out.tolist() == [[1, 0], [0, 1]]


def test_the_nearest_point_counts_the_first_ones_only() -> None:
    points = np.array(((3.0, 4.0), (0.0, 1.0)))
    assert kernels.nearest_squared(points, 1, 0.0, 0.0) == 25.0
    assert kernels.nearest_squared(points, 2, 0.0, 0.0) == 1.0
    assert kernels.nearest_squared(points, 0, 0.0, 0.0) == kernels.INFINITE


def resampled(points: np.ndarray, spacing: float) -> np.ndarray:
    out = np.empty((int(path_length(points) / spacing) + len(points) + 4, 2))
    return out[: path_kernels.resample(points, spacing, out)]


coordinates = st.floats(-3.0, 3.0).map(lambda value: round(value, 3))
polylines = st.lists(st.tuples(coordinates, coordinates), min_size=2, max_size=8).map(np.array)


@settings(max_examples=60, deadline=None)
@given(polylines)
def test_resampling_equals_its_slow_twin(points: np.ndarray) -> None:
    length = path_length(points)
    tail = length % SPACING
    if length < 2 * SPACING or min(tail, SPACING - tail) < 1e-6 or 0.0 < tail < 0.25 * SPACING:
        return  # the twins may round such an end differently; see the properties below
    assert np.allclose(resampled(points, SPACING), oracle.resample(points, SPACING), atol=1e-6)


@settings(max_examples=60, deadline=None)
@given(polylines)
def test_a_resampled_path_keeps_its_ends_and_its_spacing(points: np.ndarray) -> None:
    path = resampled(points, SPACING)
    assert np.allclose(path[0], points[0])
    assert np.allclose(path[-1], points[-1], atol=0.2 * SPACING + 1e-9)
    if len(path) > 1:
        steps = np.hypot(*np.diff(path, axis=0).T)
        assert steps.max() <= 1.2 * SPACING + 1e-9


def test_a_straight_path_goes_behind_for_negative_distances() -> None:
    path = straight_path(Pose(1.0, 1.0, math.pi / 2), -0.3)
    assert np.allclose(path[-1], (1.0, 0.7))
    assert len(path) == 7


def corner_path() -> np.ndarray:
    legs = np.vstack((np.column_stack((np.arange(0.3, 1.5, 0.05), np.full(24, 0.5))),
                      np.column_stack((np.full(20, 1.5), np.arange(0.5, 1.5, 0.05)))))  # fmt: skip
    return np.ascontiguousarray(legs)


def smoothed(path: np.ndarray, field: np.ndarray, blocked: np.ndarray, floor: float) -> np.ndarray:
    out = np.empty_like(path)
    walls = path_kernels.Walls(kernels.Field(field, FINE), floor)
    path_kernels.smooth_path(path, 3, 4, walls, path_kernels.Blocked(blocked, COARSE), out)
    return out


FREE, OPEN = np.full((40, 40), 5.0), np.zeros((20, 20), np.float32)


def test_smoothing_rounds_corners_and_keeps_the_ends() -> None:
    path = corner_path()
    smooth = smoothed(path, FREE, OPEN, 0.3)
    assert np.allclose(smooth[[0, -1]], path[[0, -1]])

    def sharpest(points: np.ndarray) -> float:
        steps = np.diff(points, axis=0)
        return float(np.abs(np.diff(np.unwrap(np.arctan2(steps[:, 1], steps[:, 0])))).max())

    assert sharpest(smooth) < 0.4 * sharpest(path)


def test_smoothing_is_a_moving_average_where_nothing_is_near() -> None:
    path = np.random.default_rng(0).random((30, 2)) * 0.02 + corner_path()[:30]
    once = np.empty_like(path)
    walls = path_kernels.Walls(kernels.Field(FREE, FINE), 0.3)
    others = path_kernels.Blocked(OPEN, COARSE)
    path_kernels.smooth_path(path, 1, 4, walls, others, once)
    for axis in (0, 1):
        expected = np.convolve(path[:, axis], np.full(9, 1 / 9), "valid")
        assert np.allclose(once[4:-4, axis], expected)


def test_smoothing_does_not_enter_what_others_hold() -> None:
    blocked = OPEN.copy()
    blocked[6:, :14] = 1e9  # the inside of the corner
    smooth = smoothed(corner_path(), FREE, blocked, 0.3)
    values = [path_kernels.cell_value(blocked, COARSE, x, y) for x, y in smooth]
    assert max(values) == 0.0


def test_smoothing_does_not_come_nearer_to_a_wall_than_the_clearance() -> None:
    occupied = np.zeros((40, 40), np.bool_)
    occupied[16:, :24] = True
    field = kernels.distance_cells(occupied) * 0.05
    smooth = smoothed(corner_path(), field, OPEN, 0.3)
    before = min(oracle.sample(field, FINE, x, y) for x, y in corner_path())
    after = min(oracle.sample(field, FINE, x, y) for x, y in smooth)
    assert after >= min(0.3, before) - 1e-3


def test_lifting_moves_inner_points_off_the_wall() -> None:
    occupied = np.zeros((40, 60), np.bool_)
    occupied[0, :] = True
    field = kernels.distance_cells(occupied) * 0.05
    points = np.column_stack((np.arange(0.3, 2.5, 0.05), np.full(44, 0.28)))
    walls = path_kernels.Walls(kernels.Field(field, FINE), 0.30)
    path_kernels.lift_off_walls(points, walls, 6)
    gaps = np.array([oracle.sample(field, FINE, x, y) for x, y in points])
    assert gaps[[0, -1]].max() < 0.26  # ends stay
    assert gaps[1:-1].min() > 0.299


def test_a_value_outside_the_grid_is_closed() -> None:
    assert path_kernels.cell_value(OPEN, COARSE, -0.01, 0.5) > 1e8


@settings(max_examples=60, deadline=None)
@given(polylines, st.floats(0.1, 1.5))
def test_corners_equal_their_slow_twin(points: np.ndarray, angle: float) -> None:
    assert path_kernels.corners(points, angle).tolist() == oracle.corners(points, angle)


@settings(max_examples=60, deadline=None)
@given(polylines)
def test_the_ends_replace_what_is_near_them(points: np.ndarray) -> None:
    ends = np.array(((0.0, 0.0), (1.0, 1.0)))
    course = path_kernels.with_ends(points, ends, 0.5)
    assert np.array_equal(course[[0, -1]], ends)
    far = [p for p in points[1:-1] if min(math.dist(p, ends[0]), math.dist(p, ends[1])) > 0.5]
    assert np.array_equal(course[1:-1], np.array(far).reshape(-1, 2))


def test_a_drivable_path_is_resampled_smoothed_lifted_and_resampled() -> None:
    course = np.array(((0.3, 0.5), (1.5, 0.5), (1.5, 1.5)))
    walls = path_kernels.Walls(kernels.Field(FREE, FINE), 0.3)
    others = path_kernels.Blocked(OPEN, COARSE)
    path = path_kernels.drivable(course, SPACING, path_kernels.Smoothing(3, 4, 6), walls, others)
    by_hand = smoothed(path_kernels.resampled(course, SPACING), FREE, OPEN, 0.3)
    assert np.allclose(path, path_kernels.resampled(by_hand, SPACING))
    short = course[:1] + np.array(((0.0, 0.0), (0.05, 0.0)))
    assert (
        len(path_kernels.drivable(short, SPACING, path_kernels.Smoothing(3, 4, 6), walls, others))
        == 2
    )
