"""Paths that are told to a fleet control of version 3.0."""

from datetime import UTC, datetime

import numpy as np

from swarm_vda5050.paths import MOST_POINTS, intermediate_path, planned_path
from swarm_vda5050.reading import Reader, written

NOW = datetime(2026, 1, 1, tzinfo=UTC)
LINE = np.column_stack([np.linspace(0.0, 3.0, 301), np.zeros(301)])


def test_a_long_way_is_told_with_its_ends_and_when_the_robot_is_there():
    path = planned_path(LINE, ["n1", "n2"])
    points = path.trajectory["controlPoints"]
    assert len(points) == MOST_POINTS
    assert (points[0], points[-1]) == ({"x": 0.0, "y": 0.0}, {"x": 3.0, "y": 0.0})
    assert len(path.trajectory["knotVector"]) == MOST_POINTS + 2
    near = intermediate_path(LINE[:51], 0.25, NOW)
    assert near.polyline[-1].eta == "2026-01-01T00:00:02.000Z"
    assert planned_path(LINE[:1], []) is None
    assert intermediate_path(LINE[:0], 0.25, NOW) is None


def test_they_are_valid_in_3_0_and_left_out_before():
    content = {
        "plannedPath": {"trajectory": planned_path(LINE, []).trajectory, "traversedNodes": []},
        "intermediatePath": {"polyline": [{"x": 0.0, "y": 0.0, "eta": "2026-01-01T00:00:00Z"}]},
    }
    told = written(content, "visualization", "3.0")
    assert set(told) == set(content)
    reader = Reader("3.0", is_lenient=True)
    reader.record(told, "visualization")
    assert all("lacks" in remark for remark in reader.forgiven)
    assert written(content, "visualization", "2.1") == {}
