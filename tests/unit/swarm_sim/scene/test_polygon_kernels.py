"""Polygon kernels against shapely."""

import numpy as np
import pytest

from swarm_sim.physics.planar import pad_polygon
from swarm_sim.scene.polygon_kernels import distance, overlap
from swarm_sim.scene.section import convex_hull
from tests.oracles import polygons as oracle


@pytest.mark.parametrize("seed", range(40))
def test_distance_equals_that_of_shapely(seed):
    rng = np.random.default_rng(seed)
    for _ in range(10):
        a = convex_hull(rng.normal(size=(6, 2)))
        b = convex_hull(rng.normal(size=(9, 2)) * 0.7 + rng.normal(size=2) * 2.5)
        expected = oracle.distance(a, b)
        assert distance(pad_polygon(a, 8), pad_polygon(b, 10)) == pytest.approx(expected, abs=1e-9)
        assert overlap(a, b) == (expected == 0.0)


def test_edge_cases():
    square = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])
    assert distance(square, np.add(square, [1.0, 0.0])) == 0.0  # they share an edge
    assert distance(square, np.add(square, [1.0, 1.0])) == 0.0  # they share a corner
    assert distance(square, np.add(square, [1.0 + 1e-9, 0.0])) == pytest.approx(1e-9, rel=1e-3)
    assert distance(square, 0.2 * square + 0.4) == 0.0  # one inside the other
