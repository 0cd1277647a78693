"""Polylines against their slow twins: resampled, smoothed, lifted off walls, and their corners."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from swarm_common.model.records import Pose
from swarm_nav.planning import distance_kernels as kernels
from swarm_nav.planning import path_kernels
from swarm_nav.planning.cells import distance_cells
from swarm_nav.planning.planner import SPACING, path_length, straight_path
from tests.oracles import fields as oracle

FINE, COARSE = kernels.Frame(0.0, 0.0, 0.05), kernels.Frame(0.0, 0.0, 0.1)


def resampled(points, spacing):
    out = np.empty((int(path_length(points) / spacing) + len(points) + 4, 2))
    return out[: path_kernels.resample(points, spacing, out)]


coordinates = st.floats(-3.0, 3.0).map(lambda value: round(value, 3))
polylines = st.lists(st.tuples(coordinates, coordinates), min_size=2, max_size=8).map(np.array)


@settings(max_examples=60, deadline=None)
@given(polylines)
def test_resampling_equals_its_slow_twin(points):
    length = path_length(points)
    tail = length % SPACING
    if length < 2 * SPACING or min(tail, SPACING - tail) < 1e-6 or 0.0 < tail < 0.25 * SPACING:
        return  # the twins may round such an end differently; see the properties below
    assert np.allclose(resampled(points, SPACING), oracle.resample(points, SPACING), atol=1e-6)


@settings(max_examples=60, deadline=None)
@given(polylines)
def test_a_resampled_path_keeps_its_ends_and_its_spacing(points):
    path = resampled(points, SPACING)
    assert np.allclose(path[0], points[0])
    assert np.allclose(path[-1], points[-1], atol=0.2 * SPACING + 1e-9)
    if len(path) > 1:
        steps = np.hypot(*np.diff(path, axis=0).T)
        assert steps.max() <= 1.2 * SPACING + 1e-9


def test_a_straight_path_goes_behind_for_negative_distances():
    path = straight_path(Pose(1.0, 1.0, math.pi / 2), -0.3)
    assert np.allclose(path[-1], (1.0, 0.7))
    assert len(path) == 7


def corner_path():
    legs = np.vstack((np.column_stack((np.arange(0.3, 1.5, 0.05), np.full(24, 0.5))),
                      np.column_stack((np.full(20, 1.5), np.arange(0.5, 1.5, 0.05)))))  # fmt: skip
    return np.ascontiguousarray(legs)


def smoothed(path, field, blocked, floor):
    out = np.empty_like(path)
    walls = path_kernels.WallClearance(kernels.Field(field, FINE), floor)
    path_kernels.smooth_path(path, 3, 4, walls, path_kernels.Blocked(blocked, COARSE), out)
    return out


FREE, OPEN = np.full((40, 40), 5.0), np.zeros((20, 20), np.float32)


def test_smoothing_rounds_corners_and_keeps_the_ends():
    path = corner_path()
    smooth = smoothed(path, FREE, OPEN, 0.3)
    assert np.allclose(smooth[[0, -1]], path[[0, -1]])

    def sharpest(points):
        steps = np.diff(points, axis=0)
        return float(np.abs(np.diff(np.unwrap(np.arctan2(steps[:, 1], steps[:, 0])))).max())

    assert sharpest(smooth) < 0.4 * sharpest(path)


def test_smoothing_keeps_off_walls_and_what_others_hold():
    blocked = OPEN.copy()
    blocked[6:, :14] = 1e9  # the inside of the corner
    smooth = smoothed(corner_path(), FREE, blocked, 0.3)
    values = [path_kernels.cell_value(blocked, COARSE, x, y) for x, y in smooth]
    assert max(values) == 0.0
    occupied = np.zeros((40, 40), np.bool_)
    occupied[16:, :24] = True
    field = distance_cells(occupied) * 0.05
    smooth = smoothed(corner_path(), field, OPEN, 0.3)
    before = min(oracle.sample(field, FINE, x, y) for x, y in corner_path())
    after = min(oracle.sample(field, FINE, x, y) for x, y in smooth)
    assert after >= min(0.3, before) - 1e-3


def test_lifting_moves_inner_points_off_the_wall():
    occupied = np.zeros((40, 60), np.bool_)
    occupied[0, :] = True
    field = distance_cells(occupied) * 0.05
    points = np.column_stack((np.arange(0.3, 2.5, 0.05), np.full(44, 0.28)))
    walls = path_kernels.WallClearance(kernels.Field(field, FINE), 0.30)
    path_kernels.lift_off_walls(points, walls, 6)
    gaps = np.array([oracle.sample(field, FINE, x, y) for x, y in points])
    assert gaps[[0, -1]].max() < 0.26  # ends stay
    assert gaps[1:-1].min() > 0.299


@settings(max_examples=60, deadline=None)
@given(polylines, st.floats(0.1, 1.5))
def test_corners_equal_their_slow_twin(points, angle):
    assert path_kernels.corners(points, angle).tolist() == oracle.corners(points, angle)


@settings(max_examples=60, deadline=None)
@given(polylines, st.sampled_from((0.2, 0.05)))
def test_between_two_corners_no_step_of_a_path_leads_back(points, spacing):
    path = path_kernels.thinned(resampled(points, spacing), 0.6 * spacing)
    assert np.array_equal(path[[0, -1]], points[[0, -1]])
    inner = np.diff(path, axis=0)[:-1]
    assert len(inner) == 0 or np.hypot(*inner.T).min() >= 0.6 * spacing
    found = set(path_kernels.corners(path, 0.7).tolist())
    steps = np.diff(path, axis=0)
    turned_back = np.flatnonzero((steps[:-1] * steps[1:]).sum(axis=1) < -1e-12) + 1
    assert set(turned_back.tolist()) <= found


@settings(max_examples=60, deadline=None)
@given(polylines)
def test_the_ends_replace_what_is_near_them(points):
    ends = np.array(((0.0, 0.0), (1.0, 1.0)))
    walls = path_kernels.WallClearance(kernels.Field(FREE, FINE), 0.3)
    course = path_kernels.with_ends(points, ends, 0.5, walls)
    assert np.array_equal(course[[0, -1]], ends)
    far = [p for p in points[1:-1] if min(math.dist(p, ends[0]), math.dist(p, ends[1])) > 0.5]
    assert np.array_equal(course[1:-1], np.array(far).reshape(-1, 2))


@pytest.mark.parametrize("is_last", [False, True])
def test_an_end_of_a_path_stays_where_the_straight_way_past_it_leads_into_a_wall(is_last):
    occupied = np.zeros((40, 40), np.bool_)
    occupied[16:, :24] = True  # its corner is at (1.2, 0.8)
    walls = path_kernels.WallClearance(
        kernels.Field(kernels.face_distance(occupied) * 0.05, FINE), 0.27
    )
    points = np.array(((1.35, 0.5), (1.55, 0.7), (1.6, 1.6)))  # around the corner
    ends = np.array(((0.9, 0.5), (1.6, 1.7)))
    if is_last:
        points, ends = points[::-1].copy(), ends[::-1].copy()
    course = path_kernels.with_ends(points, ends, 0.1, walls)
    k = -2 if is_last else 1
    assert course[k].tolist() == [1.35, 0.5]
    free = path_kernels.WallClearance(kernels.Field(FREE, FINE), 0.27)
    assert [1.35, 0.5] not in path_kernels.with_ends(points, ends, 0.1, free).tolist()


def test_a_drivable_path_is_resampled_smoothed_lifted_and_resampled():
    course = np.array(((0.3, 0.5), (1.5, 0.5), (1.5, 1.5)))
    walls = path_kernels.WallClearance(kernels.Field(FREE, FINE), 0.3)
    others = path_kernels.Blocked(OPEN, COARSE)
    path = path_kernels.drivable(course, SPACING, path_kernels.Smoothing(3, 4, 6), walls, others)
    by_hand = smoothed(path_kernels.resampled(course, SPACING), FREE, OPEN, 0.3)
    assert np.allclose(path, path_kernels.resampled(by_hand, SPACING))
    short = course[:1] + np.array(((0.0, 0.0), (0.05, 0.0)))
    assert (
        len(path_kernels.drivable(short, SPACING, path_kernels.Smoothing(3, 4, 6), walls, others))
        == 2
    )
