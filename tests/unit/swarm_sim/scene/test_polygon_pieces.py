"""Convex pieces cover their polygon, however thin its triangles are."""

import numpy as np
import pytest
import shapely

from swarm_sim.scene.polygon_pieces import DEPTH, MAX_CORNERS, convex_pieces

CELL = 0.05  # [m] of a map

# A cut through 40 triangles that cross at small angles: 0.9 m² of it were lost, as rings that
# overlap themselves counted as convex.
SLIVERS = (
    "POLYGON ((-6.588808 16.305845, -6.567466 16.269813, -6.563726 16.260238, -3.54717 "
    "10.523255, -1.526065 6.598928, 3.132107 -2.598743, 5.014165 -6.380254, 5.072982 -6.503051, "
    "8.341683 -13.327507, -6.588808 16.305845), (3.279744 -3.196054, 3.278279 -3.193365, "
    "3.278879 -3.194687, 3.262463 -3.161253, 3.279744 -3.196054), (-1.835101 6.882128, "
    "-1.954742 7.137108, -1.954965 7.137506, -1.835101 6.882128), (-3.392088 10.220094, "
    "-2.781045 9.034498, -3.41077 10.256837, -3.392088 10.220094), (-3.16813 9.722849, "
    "-3.473093 10.37304, -3.475951 10.378286, -3.16813 9.722849), (-3.479298 10.385412, "
    "-3.475548 10.378274, -3.483263 10.394721, -3.486213 10.400137, -3.479298 10.385412), "
    "(-3.487901 10.40373, -3.484042 10.396382, -3.486996 10.402681, -3.492405 10.413321, "
    "-3.487901 10.40373), (-3.487968 10.404752, -3.508959 10.446855, -3.495136 10.420035, "
    "-3.503296 10.437432, -6.563703 16.260181, -6.558915 16.247925, -6.541269 16.214334, "
    "-6.545851 16.226009, -3.493054 10.414621, -3.487968 10.404752))"
)


def crossing_triangles(seed, count):
    """Return what triangles cover that cross each other at small angles, holes included."""
    rng = np.random.default_rng(seed)
    ends = rng.uniform(-2.0, 2.0, (count, 1, 2))
    corners = ends + rng.normal(0.0, 1.0, (count, 3, 2)) * 10.0 ** rng.uniform(
        -4.0, 0.5, (count, 3, 1)
    )
    union = shapely.union_all(shapely.polygons(corners), grid_size=1e-6).simplify(0.001)
    parts = shapely.get_parts(shapely.buffer(union, 0.0))
    return [part for part in parts if part.area > 1e-6]


def check(polygon):
    pieces = [shapely.Polygon(piece) for piece in convex_pieces(polygon)]
    assert all(len(piece.exterior.coords) - 1 <= MAX_CORNERS for piece in pieces)
    covered = shapely.union_all([piece.buffer(0.0) for piece in pieces])
    missing = shapely.difference(polygon, covered.buffer(DEPTH))
    assert missing.area < 1e-6, f"{missing.area} m² of {polygon.area} m² are lost"
    excess = shapely.difference(covered, polygon.buffer(CELL))
    assert excess.area < 1e-6


@pytest.mark.parametrize("seed", range(60))
def test_crossing_triangles_are_covered(seed):
    for polygon in crossing_triangles(seed, 40):
        check(polygon)


def test_rings_are_not_joined_that_overlap_themselves():
    check(shapely.from_wkt(SLIVERS))
    angles = np.linspace(0.0, 2.0 * np.pi, 25)[:-1]
    circle = np.column_stack([np.cos(angles), np.sin(angles)])
    check(shapely.Polygon(3.0 * circle, [0.999 * 3.0 * circle]))
    check(shapely.Polygon(3.0 * circle, [0.3 * circle]))
