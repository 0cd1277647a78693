"""Presets show all of a hall beside the panel, and labels do not cover each other."""

import itertools

import numpy as np
import pytest

from swarm_view.scene.labels import LETTER_HEIGHT, LabelWish, arrange
from swarm_view.scene.views import PANEL_WIDTH, STRIP_HEIGHT, Camera, View, eye_of, whole
from swarm_view.state.decode import Raster

SIZE = (1600.0, 900.0)


def hall(width, depth):
    return Raster(np.zeros((round(depth), round(width)), np.int8), 1.0, (-3.0, 5.0))


@pytest.mark.parametrize("view", [View.TOP, View.HALL])
@pytest.mark.parametrize("size", [(17, 13), (40, 8), (6, 60)])
def test_all_of_a_hall_is_seen_as_large_as_the_free_part_allows(view, size):
    raster = hall(*size)
    camera = whole(raster, view, 1.3, *SIZE)
    (x, y), (width, depth) = raster.origin, raster.size
    corners = np.array([(a, b, 0.0) for a in (x, x + width) for b in (y, y + depth)])
    pixels, depths = camera.project(corners)
    assert (depths > 0.0).all()
    free = np.array([SIZE[0] - PANEL_WIDTH, SIZE[1] - STRIP_HEIGHT])
    assert (pixels > -0.01 * free).all()
    assert (pixels < 1.01 * free).all()
    assert ((pixels.max(axis=0) - pixels.min(axis=0)) / free).max() > 0.85


def test_a_camera_projects_right_and_ahead_and_nothing_behind_it():
    camera = Camera(np.array([0.0, -5.0, 5.0]), np.zeros(3), 1.0, *SIZE)
    pixels, depths = camera.project(np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]))
    np.testing.assert_allclose(pixels[0], [800.0, 450.0])
    assert pixels[1][0] > 800.0
    assert pixels[2][1] < 450.0
    assert depths[0] == pytest.approx(50.0**0.5)
    metre = 1.0 / camera.sizes(np.zeros((1, 3)))[0]
    assert pixels[1][0] - 800.0 == pytest.approx(metre, rel=0.05)
    target, position = eye_of(np.array([1.0, 2.0, 0.5 * np.pi]), 0.3)
    np.testing.assert_allclose(position[:2], [1.0, 2.3], atol=1e-9)
    assert target[1] > position[1]
    assert target[2] < position[2]
    camera = Camera(np.array([0.0, -5.0, 1.0]), np.zeros(3), 1.0, *SIZE)
    assert arrange([LabelWish("a", ("a",), np.array([0.0, -9.0, 0.0]))], camera) == {}


def test_labels_in_one_place_do_not_pile_up():
    camera = Camera(np.array([0.0, -1e-3, 10.0]), np.zeros(3), 1.0, *SIZE)
    wishes = [
        LabelWish(
            f"Srobot{i}", (f"Srobot{i} waiting", f"{i}"), np.array([0.2 * i - 3.0, 0.0, 0.0]), 0.1
        )
        for i in range(30)
    ]
    placed = arrange(wishes, camera)
    assert "Srobot0" in placed
    assert placed["Srobot0"].text == "Srobot0 waiting"
    assert 3 < len(placed) < 30
    tops = {name: camera.project(label.place[None])[0][0] for name, label in placed.items()}
    same = [
        (a, b)
        for a, b in itertools.combinations(placed, 2)
        if placed[a].anchor == placed[b].anchor == "bottom-center"
        and abs(tops[a][1] - tops[b][1]) < LETTER_HEIGHT
    ]
    for a, b in same:
        assert abs(tops[a][0] - tops[b][0]) > 7.0 * min(len(placed[a].text), len(placed[b].text))


def test_labels_leave_marks_in_sight_and_are_shown_in_full_far_apart():
    camera = Camera(np.array([0.0, -1e-3, 10.0]), np.zeros(3), 1.0, *SIZE)
    wish = LabelWish("a", ("Srobot1 waiting", "1"), np.zeros(3), 0.3)
    alone = arrange([wish], camera)["a"]
    assert alone.anchor == "bottom-center"
    above = np.array([[0.0, 0.6, 0.0]])
    beside = arrange([wish], camera, marks=(above, np.array([0.3])))["a"]
    assert beside.text == "Srobot1 waiting"
    assert beside.anchor != "bottom-center"
    around = np.array([(x, y, 0.0) for x in (-0.6, 0.0, 0.6) for y in (-0.6, 0.0, 0.6)])
    crowded = arrange([wish], camera, marks=(around, np.full(9, 0.3)))["a"]
    assert crowded.text == "1"
    camera = Camera(np.array([0.0, -1e-3, 10.0]), np.zeros(3), 1.0, *SIZE)
    wishes = [
        LabelWish(f"{i}", (f"robot {i}", "x"), np.array([2.0 * i, 0.0, 0.0])) for i in (-2, 0, 2)
    ]
    placed = arrange(wishes, camera)
    assert [label.text for label in placed.values()] == ["robot -2", "robot 0", "robot 2"]
