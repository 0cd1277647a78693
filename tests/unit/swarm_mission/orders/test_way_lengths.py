"""Ways to stations: around walls, and straight without a map."""

import math

import numpy as np
import pytest

from swarm_common.model.grid import OCCUPIED, Grid
from swarm_common.model.records import Pose
from swarm_mission.orders.way_lengths import WayLengths

STATIONS = {"left": Pose(1.0, 3.0, 0.0), "right": Pose(5.0, 3.0, 0.0), "shut": Pose(5.0, 8.5, 0.0)}


def hall():
    cells = np.zeros((180, 120), np.int8)
    cells[20:, 58:62] = OCCUPIED
    cells[158:162, 60:] = OCCUPIED
    return Grid(cells, 0.05, 0.0, 0.0)


def test_a_way_goes_around_walls_or_is_straight_without_a_map():
    ways = WayLengths(STATIONS, hall(), 0.2)
    corners = 2.0 * math.hypot(2.0, 3.0 - 0.7)
    assert ways.between("left", "right") == pytest.approx(corners, rel=0.12)
    assert ways.length(4.5, 3.0, "right") == pytest.approx(0.5, abs=0.3)
    assert math.isinf(ways.between("left", "shut"))
    assert WayLengths(STATIONS, None).between("left", "right") == 4.0
