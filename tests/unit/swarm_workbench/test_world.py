"""Worlds made from Python."""

import pytest

from swarm_common.model.errors import SwarmError
from swarm_workbench import Swarm, World

ROOM = [(-3, -2, 3, -2), (3, -2, 3, 2), (3, 2, -3, 2), (-3, 2, -3, -2)]


def test_robots_drive_in_a_world_of_ones_own(tmp_path):
    world = World.create(
        tmp_path / "room", walls=ROOM, boxes=[(0, 0, 0.6, 0.6)], stations={"east": (2.2, 0, 0)}
    )
    assert world.name == "room"
    row, column = world.map.cell_of(0.0, 0.28)
    assert world.map.cells[row, column] != 0  # the box
    row, column = world.map.cell_of(1.5, 1.0)
    assert world.map.cells[row, column] == 0
    with Swarm(robots=1, world=world, bench=True) as swarm:
        assert swarm["Srobot1"].go_to("east").wait(timeout=90.0)
        assert swarm.report.collisions == 0


@pytest.mark.parametrize(
    ("parts", "message"),
    [
        ({"walls": [(0, 0, 1)]}, "wall_1 is .* expected 4 finite numbers"),
        ({"boxes": [(0, 0, 1, 0)]}, "both must be positive"),
        ({"stations": {"a": (0, "x", 0)}}, "station a is"),
    ],
)
def test_numbers_that_make_no_sense_are_refused(tmp_path, parts, message):
    with pytest.raises(SwarmError, match=message):
        World.create(tmp_path / "room", **parts)
