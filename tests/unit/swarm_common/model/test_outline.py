"""Outlines of bodies from above."""

import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st

from swarm_common.model.beacon import FOOTPRINT_POINTS
from swarm_common.model.outline import MOST_GROWTH, bounds, outline_around, placed_corners, volume
from swarm_common.model.shapes import Box, Cylinder, Part, Sphere, transform_from_xyz_rpy
from swarm_describe.files.meshes import hull_of

COORDINATE = st.floats(-1.0, 1.0).map(lambda value: round(value, 3))


@settings(deadline=None)
@given(st.lists(st.tuples(COORDINATE, COORDINATE), min_size=3, max_size=40), st.integers(4, 8))
def test_an_outline_holds_its_points_and_is_convex(points, most):
    array = np.array(points)
    try:
        outline = np.array(outline_around(array, most))
    except ValueError:
        return  # on a line
    assert 3 <= len(outline) <= most
    edges = np.roll(outline, -1, axis=0) - outline
    for corner, edge in zip(outline, edges, strict=True):
        aside = edge[0] * (array[:, 1] - corner[1]) - edge[1] * (array[:, 0] - corner[0])
        assert aside.min() > -2e-3 * np.hypot(*edge) - 1e-4


RIMS = st.integers(8, 64).map(lambda n: 2.0 * np.pi * np.arange(n) / n)


@settings(deadline=None)
@given(RIMS, st.floats(0.2, 1.0), st.floats(0.0, 1.0), st.floats(0.0, 0.5), st.floats(0.0, 0.9))
def test_no_circle_grows_by_more_than_two_percent(angles, across, square, nose, turn):
    """Round, oval and rounded square bodies, with a nose or without, about any centre."""
    power = 1.0 - 0.8 * square
    x, y = np.cos(angles + turn), np.sin(angles + turn)
    body = np.column_stack(
        (np.sign(x) * np.abs(x) ** power, across * np.sign(y) * np.abs(y) ** power)
    )
    body = np.vstack((body, [(1.0 + nose, 0.0)]))
    outline = np.array(outline_around(body, FOOTPRINT_POINTS))
    assert len(outline) <= FOOTPRINT_POINTS
    assert shapely.Polygon(outline).buffer(2e-4).contains(shapely.MultiPoint(body).convex_hull)
    radius = np.hypot(*body.T).max()
    assert np.hypot(*outline.T).max() <= (1.0 + MOST_GROWTH) * radius + 2e-4


def test_a_body_of_few_corners_keeps_them_and_points_on_a_line_have_none():
    body = [(0.3, -0.2), (0.3, 0.2), (-0.3, 0.2), (-0.3, -0.2)]
    assert sorted(outline_around(np.array(body), FOOTPRINT_POINTS)) == sorted(body)
    with pytest.raises(ValueError, match="span no area"):
        outline_around(np.array([(0.0, 0.0), (1.0, 1.0), (2.0, 2.0)]), 8)


@pytest.mark.parametrize(
    ("shape", "size", "content"),
    [
        (Box((1.0, 2.0, 3.0)), (3.0, 1.0, 2.0), 6.0),
        (Cylinder(0.5, 3.0), (3.0, 1.0, 1.0), np.pi * 0.75),
        (Sphere(0.5), (1.0, 1.0, 1.0), np.pi / 6.0),
    ],
)
def test_bodies_turned_on_their_side(shape, size, content):
    place = transform_from_xyz_rpy(1.0, 2.0, 3.0, np.pi / 2, 0.0, 0.0)
    if not isinstance(shape, Sphere):
        place[:3, :3] = np.array([[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])
    low, high = bounds([Part(shape, place)])
    np.testing.assert_allclose((low + high) / 2.0, [1.0, 2.0, 3.0], atol=1e-9)
    np.testing.assert_allclose(high - low, size, rtol=6e-3)
    assert volume(shape) == pytest.approx(content)


def test_a_hull_has_the_corners_of_its_mesh():
    corners = placed_corners([Part(Box((1.0, 1.0, 1.0)), np.eye(4))])
    hull = hull_of(np.vstack([corners, np.zeros((1, 3))]), "cube")
    assert len(hull.vertices) == 8
    assert len(hull.faces) == 12
    assert len(hull.edges()) == 18  # the sides of a cube are two triangles each
    middle = np.array(hull.vertices)[list(hull.faces[0])].mean(axis=0)
    a, b, c = (np.array(hull.vertices[i]) for i in hull.faces[0])
    assert np.cross(b - a, c - a) @ middle > 0.0  # outwards
