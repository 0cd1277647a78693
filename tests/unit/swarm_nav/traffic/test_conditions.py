"""What is said before a run: how many robots a map has room for, and where it has not."""

import numpy as np
import pytest

from swarm_common.model.grid import Grid
from swarm_describe.robots.loading import load_robot
from swarm_nav.core.config import NavConfig
from swarm_nav.traffic.conditions import PLACES_PER_ROBOT, conditions
from tests.fakes.navigation import room, waffle

HALL = room(6.0, 6.0)
DOOR = room(
    9.0, 4.0, (4.0, 0.0, 4.2, 1.6), (4.0, 2.5, 4.2, 4.0)
)  # 0.9 m wide, rooms to 4 and 4.8 m
CLOSET = room(9.0, 4.0, (7.2, 0.0, 7.4, 1.6), (7.2, 2.5, 7.4, 4.0))
LEFT, RIGHT = (2.0, 2.0), (8.3, 2.0)
# a comb: a lane of 0.9 m along the wall with three teeth of 0.9 m
COMB = room(
    5.7, 3.0, (0.0, 1.0, 0.4, 3.0), (1.3, 1.0, 2.4, 3.0), (3.3, 1.0, 4.4, 3.0), (5.3, 1.0, 5.7, 3.0)
)
TEETH = ((0.85, 2.4), (2.85, 2.4), (4.85, 2.4))


def of(grid, *goals):
    return conditions(
        [(waffle(), NavConfig())] * len(goals), grid, [each[0] for each in goals], goals
    )


def test_a_hall_has_room_and_a_pocket_and_the_outside_have_none():
    found = of(HALL, (LEFT,), (LEFT,))
    assert found.is_guaranteed
    assert 40 < found.places < 120  # 5.4 m by 5.4 m, about 0.57 m apart
    most = found.places // PLACES_PER_ROBOT
    said = f"all 2 robots have room to reach every known goal (there is room for {most})"
    assert str(found) == said
    small = room(2.2, 2.2)
    framed = Grid(np.pad(small.cells, 40), small.resolution, -2.0, -2.0)  # 2 m of free margin
    goals = [((1.0, 1.0),)] * 12
    assert of(framed, *goals) == of(small, *goals)
    assert not of(framed, *goals).is_guaranteed
    pocket = room(9.0, 4.0, (4.0, 0.0, 4.2, 4.0))
    found = of(pocket, *[(LEFT,)] * 60)
    assert found.findings == (f"room for {found.places // PLACES_PER_ROBOT} robots; 60 asked for",)
    assert found.places == of(room(4.05, 4.0), (LEFT,)).places


def test_rooms_of_less_than_four_places_are_said_where_somebody_goes():
    """8 of 12 places taken: robots that stood between the places had nowhere to make way to."""
    small = room(3.2, 1.85)
    goals = [((1.0, 1.0),)] * 8
    found = of(small, *goals)
    assert found.findings == (f"room for {found.places // PLACES_PER_ROBOT} robots; 8 asked for",)
    assert of(small, *goals[: found.places // PLACES_PER_ROBOT]).is_guaranteed
    assert of(CLOSET, *[(LEFT,)] * 20).is_guaranteed
    assert of(DOOR, *[(LEFT, RIGHT)] * 10).is_guaranteed
    halls = room(9.0, 4.0, (6.4, 0.0, 6.6, 4.0))
    robots, goals = [(waffle(), NavConfig())] * 20, [(LEFT,)] * 20
    found = conditions(robots, halls, [RIGHT] * 20, goals).findings
    assert any("on the floor around (7.9, 2.1); 20 asked for" in finding for finding in found)


@pytest.mark.parametrize(("robots", "holds"), [(3, True), (40, False)])
def test_beyond_a_door_there_must_be_room_for_all(robots, holds):
    found = of(CLOSET, (RIGHT,), *[(LEFT,)] * (robots - 1))
    assert found.is_guaranteed is holds
    if not holds:
        assert "robots beyond the single lane around (7.4, 2.1); 40 asked for" in str(found)


@pytest.mark.parametrize(("count", "holds"), [(1, True), (2, True), (3, False)])
def test_single_lanes_have_room_for_one_robot_less_than_blind_ends(count, holds):
    found = of(COMB, *[(tooth,) for tooth in TEETH[:count]])
    assert found.is_guaranteed is holds
    if not holds:
        assert found.findings[0].startswith("room for 2 robots on the single lanes around")
        assert found.findings[0].endswith("3 have goals there")


def test_each_of_two_halls_needs_room_for_its_own_robots():
    halls = room(9.0, 4.0, (6.4, 0.0, 6.6, 4.0))  # 6.4 m and 2.4 m long
    left, right = of(halls, (LEFT,)).places, of(halls, (RIGHT,)).places
    assert left > right
    most = right // PLACES_PER_ROBOT
    assert of(halls, *[(LEFT,)] * (left // PLACES_PER_ROBOT), *[(RIGHT,)] * most).is_guaranteed
    found = of(halls, (LEFT,), *[(RIGHT,)] * (most + 1))
    assert found.places == left + right
    here = "the floor around (7.9, 2.1)"
    assert found.findings == (f"room for {most} robots on {here}; {most + 1} asked for",)


def test_a_goal_without_room_or_without_a_way_is_said():
    """They counted for nothing: all robots had "room to reach every known goal"."""
    halls = room(9.0, 4.0, (6.4, 0.0, 6.6, 4.0))
    outside, in_wall = (-50.0, 0.0), (6.5, 0.05)
    robots = [(waffle(), NavConfig())] * 2
    found = conditions(robots, halls, [LEFT, RIGHT], [(LEFT, outside, in_wall), (RIGHT, LEFT)])
    assert found.findings == (
        "no room for the robot at the goal (-50.00, 0.00) and 1 more",
        "no way to the goal (2.00, 2.00)",
    )


@pytest.mark.parametrize(("count", "holds"), [(1, True), (2, False)])
def test_an_aisle_for_small_robots_only_is_a_single_lane(count, holds):
    """It was no floor at all where a larger robot was in the swarm, and goals in it not seen."""
    grid = room(4.0, 5.0, (0.0, 3.0, 1.7, 5.0), (2.2, 3.0, 4.0, 5.0))  # 0.5 m wide
    small = load_robot("turtlebot3_burger"), NavConfig()
    robots = [(waffle(), NavConfig()), *[small] * count]
    starts = [(1.0 + k, 1.0) for k in range(count + 1)]
    ends = [(1.95, 4.6 - 0.5 * k) for k in range(count)]
    found = conditions(robots, grid, starts, [starts[:1], *[(end,) for end in ends]])
    assert found.is_guaranteed is holds
    if not holds:
        assert found.findings[0].startswith("room for 1 robot on the single lanes around (2.0, ")
