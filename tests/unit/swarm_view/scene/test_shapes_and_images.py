import numpy as np
import pytest

from swarm_common.model.palette import STATES
from swarm_view.scene.images import DARK, LIGHT, cost_image, grid_lines, map_image
from swarm_view.scene.shapes import (
    floor,
    loop,
    nearest_to_ray,
    on_floor,
    pointer,
    polyline,
    quaternions,
)
from swarm_view.state.decode import Raster


def test_lines_and_rays():
    points = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0]])
    assert polyline(points, 0.5).shape == (2, 2, 3)
    assert loop(points, 0.5)[-1, 1].tolist() == [0.0, 0.0, 0.5]
    assert polyline(np.zeros((0, 2)), 0.0).shape == (0, 2, 3)
    assert quaternions(np.array([np.pi]))[0] == pytest.approx([0.0, 0.0, 0.0, 1.0])
    eye, down = np.array([1.0, 2.0, 4.0]), np.array([0.5, 0.0, -1.0])
    assert on_floor(eye, down) == pytest.approx([3.0, 2.0])
    assert on_floor(eye, -down) is None
    balls = np.array([[1.0, 2.0, 0.0], [1.0, 2.0, 2.0], [5.0, 5.0, 0.0]])
    assert nearest_to_ray(balls, 0.2, eye, np.array([0.0, 0.0, -3.0])) == 1
    assert nearest_to_ray(balls, 0.2, eye, np.array([0.0, 0.0, 1.0])) is None
    assert nearest_to_ray(np.zeros((0, 3)), 0.2, eye, down) is None


def test_floors_robots_and_grid_lines_stand_out():
    vertices, _ = pointer(0.2)
    assert vertices[:, 0].max() > 1.4 * np.abs(vertices[:, 1]).max()  # its nose is ahead
    for vertices, faces in (pointer(0.2), floor(0, 0, 1, 2)):
        a, b, c = (vertices[faces[:, k]].astype(float) for k in range(3))
        assert (np.cross(b - a, c - a)[:, 2] > 0.0).all()
    for shades in (LIGHT, DARK):
        assert np.abs(np.subtract(shades.free, shades.background)).max() > 30
        for color in STATES.values():
            gap = np.abs(np.subtract(color, shades.free)).max()
            rim = np.abs(np.subtract((255, 255, 255) if shades is DARK else (0, 0, 0), shades.free))
            assert gap > 30 or rim.max() > 150
    assert list(grid_lines(-8.97, 10.03)) == [-8, -6, -4, -2, 0, 2, 4, 6, 8, 10]
    assert list(grid_lines(0.2, 3.9)) == [1, 2, 3]
    assert len(grid_lines(-400.0, 400.0)) <= 11


def test_pictures_of_grids_and_costs_have_the_highest_y_on_top():
    cells = np.array([[0, 100], [-1, 99]], np.int8)
    raster = Raster(cells, 0.5, (0.0, 0.0))
    assert raster.size == (1.0, 1.0)
    assert tuple(map_image(raster)[1, 1]) == LIGHT.wall
    image = cost_image(raster).astype(int)
    assert tuple(image[1, 0]) == LIGHT.free
    assert (image[1, 1] < image[1, 0]).all()
    assert tuple(image[0, 0]) == LIGHT.free
    floor = Raster(np.array([[0, 0, 100], [0, 0, 0]], np.int8), 1.0, (0.0, 0.0))
    costs = Raster(np.zeros((2, 4), np.int8), 0.5, (2.0, 0.0))
    image = cost_image(costs, floor)
    assert tuple(image[1, 1]) == LIGHT.wall
    assert tuple(image[1, 2]) == LIGHT.unknown  # beyond the map
