"""Trajectories and corridors of edges."""

import math

import msgspec
import numpy as np
import pytest
import shapely
from hypothesis import given
from hypothesis import strategies as st

from swarm_common.model.records import Pose
from swarm_vda5050.messages import Edge, NodePosition, Trajectory
from swarm_vda5050.ways import corridor_area, is_followed, line_of, problem_of
from tests.fakes.fleet_orders import MAP, OF_3, Toy, along, edge, node, nurbs, order

START, END = NodePosition(x=1.0, y=0.0, map_id=MAP), NodePosition(x=0.0, y=1.0, map_id=MAP)
QUARTER = nurbs(
    (1.0, 0.0), (1.0, 1.0, math.sqrt(0.5)), (0.0, 1.0), degree=2, knots=[0, 0, 0, 1, 1, 1]
)


def read(**more):
    return msgspec.convert(edge(0) | more, Edge)


def test_a_corridor_has_sides_and_a_weighted_trajectory_is_an_arc():
    line = line_of(read(trajectory=QUARTER), START, END)
    assert np.hypot(*line.T) == pytest.approx(1.0, abs=1e-3)
    assert line[0] == pytest.approx((1.0, 0.0))
    assert line[-1] == pytest.approx((0.0, 1.0))
    assert np.hypot(*np.diff(line, axis=0).T).max() < 0.06
    way = read(corridor={"leftWidth": 1.0, "rightWidth": 0.2, "corridorRefPoint": "CONTOUR"})
    area = corridor_area(way, np.array([(0.0, 0.0), (4.0, 0.0)]), 0.1)
    inside = shapely.contains_xy(area, [2.0, 2.0, 2.0, 2.0], [0.9, 1.1, -0.1, -0.3])
    assert inside.tolist() == [True, False, True, False]


@given(st.lists(st.tuples(st.floats(-9, 9), st.floats(-9, 9)), min_size=2, max_size=6, unique=True))
def test_a_trajectory_of_degree_1_passes_its_points(points):
    line = line_of(read(trajectory=nurbs(*points)), START, END)
    for point in points:
        assert np.hypot(*(line - point).T).min() < 0.06


@pytest.mark.parametrize(
    ("more", "expected"),
    [
        ({}, False),
        ({"trajectory": QUARTER}, True),
        ({"corridor": {"leftWidth": 0.0, "rightWidth": 0.0}}, True),
        ({"trajectory": QUARTER, "corridor": {"leftWidth": 1.0, "rightWidth": 1.0}}, False),
    ],
)
def test_only_a_narrow_way_is_followed(more, expected):
    assert is_followed(read(**more)) is expected


def test_a_robot_stops_where_the_kind_of_way_changes():
    toy = Toy()
    content = order([node(number) for number in range(5)])
    content["edges"][1]["corridor"] = {"leftWidth": 0.5, "rightWidth": 0.5}
    content["edges"][2]["trajectory"] = nurbs((4.0, 0.0), (5.0, 1.0), (6.0, 0.0))
    toy.send(content)
    kinds = []
    while (leg := toy.vehicle.leg) is not None:
        path = toy.vehicle.path_of(leg)
        kinds.append((len(leg.nodes), len(toy.vehicle.corridors_of(leg)), path is not None))
        toy.step()
    assert kinds == [(1, 0, False), (1, 1, False), (1, 0, True), (1, 0, False)]
    assert not toy.vehicle.is_busy


def test_a_robot_that_leaves_its_corridor_stops_and_says_so():
    content = along(0, 3, 3)
    for number in (0, 1):
        content["edges"][number]["corridor"] = {"leftWidth": 1.0, "rightWidth": 1.0}
    content["nodes"][0]["nodePosition"]["allowedDeviationXY"] = {"a": 3.0, "b": 3.0, "theta": 0.0}
    toy = Toy(OF_3)
    toy.pose = Pose(0.5, 1.9, 0.0)
    toy.sense()
    toy.send(content)
    for x, y, is_out in (
        (0.5, 1.9, False),  # it begins there
        (0.5, 0.9, False),
        (0.6, 1.15, False),
        (0.7, 1.4, True),
        (0.8, 0.9, False),
    ):
        toy.pose = Pose(x, y, 0.0)
        toy.wait(1.0)
        assert (toy.faults == ["OUTSIDE"]) is is_out, (x, y)
        assert (toy.vehicle.leg is None) is is_out
        for error in toy.vehicle.errors:
            assert error.references["edgeId"] == "e0"
    toy.drive()
    assert toy.vehicle.last_node == ("n3", 6)
    toy.pose = Pose(6.0, 5.0, 0.0)
    toy.wait(1.0)
    assert toy.faults == []


def test_a_robot_that_a_fleet_control_coordinates_leaves_no_edge_but_in_corridors():
    toy = Toy(follows_edges=True)
    content = order([node(0), node(1), node(2, y=1.0), node(3)])
    content["edges"][2]["corridor"] = {"leftWidth": 0.5, "rightWidth": 0.5}
    toy.send(content)
    path = toy.vehicle.path_of(toy.vehicle.leg)
    assert np.abs(path[:, 1] - np.maximum(0.0, 0.5 * path[:, 0] - 1.0)).max() < 1e-9
    toy.step()
    toy.step()
    assert toy.vehicle.path_of(toy.vehicle.leg) is None


@pytest.mark.parametrize(
    "trajectory",
    [
        nurbs((0.0, 0.0), (1e308, 1e308)),
        nurbs((0.0, 0.0), (2e4, 0.0)),
        nurbs((0.0, 0.0, 1e308), (1.0, 0.0, 1e-308)),
        nurbs((0.0, 0.0), (1.0, 0.0), knots=[0.0, 0.0, 1e308, 1e308]),
    ],
)
def test_a_trajectory_without_measure_is_refused(trajectory):
    assert problem_of(msgspec.convert(trajectory, Trajectory))
