"""What a path costs, and whether it clears another robot's way."""

import itertools
import math

import numpy as np
import pytest

from swarm_nav.planning.distance_kernels import Frame
from swarm_nav.planning.path_cost_kernels import Layers, clears, nearest_index, path_cost

FRAME = Frame(0.0, 0.0, 0.5)
REACH, TOLERANCE, GAIN = 0.6, 2, 8


def layers(base, lane, heading):
    shape = (8, 8)
    return Layers(
        np.full(shape, base, np.float32),
        np.full(shape, lane, np.float32),
        np.full((*shape, 2), heading, np.float32),
    )


def line(*corners, spacing=0.1):
    pieces = [np.array(corners[:1])]
    for a, b in itertools.pairwise(corners):
        count = round(math.dist(a, b) / spacing)
        pieces.append(np.linspace(a, b, count + 1)[1:])
    return np.vstack(pieces)


@pytest.mark.parametrize(
    ("heading", "lane_cost"), [((1.0, 0.0), 0.0), ((0.0, 1.0), 0.5), ((-1.0, 0.0), 1.0)]
)
def test_a_metre_costs_more_the_more_it_goes_against_the_lane(heading, lane_cost):
    extra = np.full((8, 8), 0.25, np.float32)
    cost = path_cost(line((1.0, 1.0), (3.0, 1.0)), FRAME, layers(1.5, 1.0, heading), extra)
    assert cost == pytest.approx(2.0 * (1.5 + lane_cost + 0.25))


def test_costs_of_walls_end_and_points_on_top_of_each_other_cost_nothing():
    wall = layers(1e9, 0.0, (1.0, 0.0))
    extra = np.full((8, 8), 1e9, np.float32)
    assert path_cost(line((1.0, 1.0), (2.0, 1.0)), FRAME, wall, extra) == pytest.approx(1003.0)
    extra = np.zeros((8, 8), np.float32)
    points = np.array(((1.0, 1.0), (1.0, 1.0)))
    assert path_cost(points, FRAME, layers(1.0, 1.0, (1.0, 0.0)), extra) == 0.0
    way = np.array(((0.0, 1.0), (2.0, 0.0), (0.0, -1.0)))
    assert nearest_index(way, 0.0, 0.0) == (0, 1.0)
    assert nearest_index(way, 1.5, 0.0) == (1, 0.25)


WAY = line((0.0, 0.0), (3.0, 0.0))


@pytest.mark.parametrize(
    ("path", "expected"),
    [
        (line((1.0, 0.0), (1.0, 1.0)), True),  # leaves it aside
        (line((1.0, 0.0), (2.0, 0.0)), True),  # gets ahead on it
        (line((1.0, 0.0), (1.5, 0.0)), False),  # not far enough ahead
        (line((1.0, 0.0), (0.0, 0.0), (0.0, 2.0)), False),  # first comes towards the other robot
        (line((1.0, 0.0), (0.8, 0.0), (0.8, 1.0)), True),  # comes nearer by the tolerance only
        (line((1.0, 0.0)), False),  # stays
    ],
)
def test_a_path_clears_a_way_by_leaving_it_or_getting_ahead(path, expected):
    assert clears(path, WAY, REACH, TOLERANCE, GAIN) is expected
