"""Directed zones: ways to goals heed them; held space, ranks and admission know nothing of them."""

import math

import numpy as np
import pytest
import shapely

from swarm_common.middleware.directed_io import packed_zones, read_zones
from swarm_common.middleware.rejections import RejectedError
from swarm_common.model.records import Pose
from swarm_common.model.zones import DirectedZone
from swarm_nav.core.config import NavConfig
from swarm_nav.core.goals import Outcome, PlanError
from swarm_nav.planning.planner import Planner
from swarm_nav.planning.search_kernels import MOVES
from swarm_nav.planning.terrain import terrain_for
from tests.fakes.navigation import Squad, config, room, waffle

HALL = room(8.0, 6.0)
BOX = ((3.0, 0.0), (4.0, 0.0), (4.0, 4.5), (3.0, 4.5))  # leaves a way along the north wall
WEST, EAST = (1.5, 1.5), (6.5, 1.5)
SHARP, RIGHT, ANY = 0.47, math.pi / 2, math.pi  # [rad]
CUT = 0.1  # [m] of a corner, by which a smooth path, and who follows it, are inside
WALL = ((3.0, -1.0), (4.0, -1.0), (4.0, 7.0), (3.0, 7.0))  # across the hall


def zone(direction, most_off, *, points=BOX, free_off=0.5 * SHARP, **more):
    return DirectedZone(points, direction, free_off, most_off, **more)


def planner(*zones):
    c = NavConfig()
    terrain = terrain_for(HALL, c.planner, c.costmap, waffle().circumscribed_radius)
    there = Planner(terrain, c.planner)
    there.direct(zones)
    return there


def off_in(path, directed, inset=0.0):
    """Return how far [rad] a path leads off the direction of a zone in it; empty beside it.

    Args:
        inset: [m] by which the zone is smaller: at its borders a path is smoothed into bends.
    """
    area = shapely.Polygon(directed.points).buffer(-inset)
    if not area.is_empty:
        area = shapely.clip_by_rect(area, -9.0, -9.0, 9.0, area.bounds[3] - CUT)
    steps, middles = np.diff(path, axis=0), 0.5 * (path[1:] + path[:-1])
    steps = steps[shapely.contains_xy(area, middles[:, 0], middles[:, 1])]
    turn = np.arctan2(steps[:, 1], steps[:, 0]) - directed.direction
    off = np.abs((turn + math.pi) % (2 * math.pi) - math.pi)
    return np.minimum(off, math.pi - off) if directed.is_two_way else off


@pytest.mark.parametrize(
    ("directed", "leads_through"),
    [
        (zone(0.0, SHARP), True),
        (zone(0.3, SHARP), True),
        (zone(math.pi, ANY), True),  # against it, as the way round costs more
        (zone(math.pi, RIGHT), False),
        (zone(math.pi, SHARP), False),
        (zone(RIGHT, SHARP), False),
        (zone(math.pi, SHARP, is_two_way=True), True),
        (zone(RIGHT, RIGHT, points=WALL, is_two_way=True), True),
        (zone(math.pi, RIGHT, points=((3.5, 0), (3.51, 0), (3.51, 4.5), (3.5, 4.5))), False),
    ],
)
def test_ways_lead_through_a_zone_in_its_direction_or_around_it(directed, leads_through):
    path = planner(directed).plan(WEST, EAST, planner().no_extra())
    assert bool(len(off_in(path, directed))) is leads_through
    assert (off_in(path, directed, 0.25) <= directed.most_off + 0.05).all()
    assert directed.most_off == ANY or (off_in(path, directed) <= RIGHT).all()


def test_a_dear_direction_is_avoided_where_the_way_round_is_short():
    lane = zone(math.pi, ANY, points=((3.0, 0.0), (5.0, 0.0), (5.0, 2.5), (3.0, 2.5)))
    path = planner(lane).plan(WEST, EAST, planner().no_extra())
    assert len(off_in(path, lane)) == 0


def test_without_any_way_in_its_direction_a_goal_is_refused_for_good():
    across = zone(RIGHT, SHARP, points=WALL, is_two_way=True)
    for there in (planner(zone(math.pi, RIGHT, points=WALL)), planner(across)):
        with pytest.raises(PlanError, match="walls and directed zones on this map") as error:
            there.plan(WEST, EAST, there.no_extra())
        assert error.value.is_final
    there = planner(zone(math.pi, RIGHT, points=WALL))
    there.plan(EAST, WEST, there.no_extra())
    there.direct(())
    there.plan(WEST, EAST, there.no_extra())


def test_who_was_pushed_beside_a_lane_finds_out_of_it():
    """It was refused for good: in the lane of others only zigzags led on, or nothing."""
    down = zone(-RIGHT, RIGHT, points=((2, 1), (4, 1), (4, 5), (2, 5)))
    both = zone(RIGHT, SHARP, points=((4, 1), (6, 1), (6, 5), (4, 5)), is_two_way=True)
    there = planner(down, both)
    for x in (3.9, 4.0, 4.05, 4.1, 4.2):
        for y in (1.5, 2.0, 3.0, 4.0, 4.5):
            for goal in ((1.0, 3.0), (7.0, 3.0), (3.0, 0.6), (5.0, 5.4)):
                path = there.plan((x, y), goal, there.no_extra())
                assert (off_in(path, down, 0.25) <= down.most_off + 0.1).all(), (x, y, goal)
                assert (off_in(path, both, 0.25) <= both.most_off + 0.1).all(), (x, y, goal)


def test_who_stands_near_the_border_of_a_dead_end_leaves_it_against_its_direction():
    dead_end = zone(0.0, SHARP, points=((5.0, -1.0), (9.0, -1.0), (9.0, 7.0), (5.0, 7.0)))
    there = planner(dead_end)
    path = there.plan((5.5, 3.0), WEST, there.no_extra())
    assert tuple(path[-1]) == WEST
    with pytest.raises(PlanError, match="directed zones"):
        there.plan((6.8, 3.0), WEST, there.no_extra())


def test_who_makes_way_goes_against_a_direction_only_if_there_is_no_other_place():
    there = planner(zone(math.pi, RIGHT, points=WALL))
    lattice = there.lattice
    x = np.broadcast_to((np.arange(lattice.base.shape[1]) + 0.5) * lattice.step, lattice.base.shape)
    aside = ((x > 4.5) & (x < 5.0)) | (x < 0.8)
    start, extra = (2.8, 3.0), there.no_extra()
    assert there.nearest(start, extra, aside.astype(np.uint8), 20.0)[-1, 0] < 0.8
    assert there.nearest(start, extra, (x > 4.5).astype(np.uint8), 20.0)[-1, 0] > 4.5


def test_what_traffic_derives_from_the_map_does_not_depend_on_zones():
    plain, there = planner(), planner(zone(math.pi, RIGHT))
    assert there.terrain is plain.terrain
    assert np.array_equal(there.cost_to_go(EAST, math.nan), plain.cost_to_go(EAST, math.nan))
    assert np.array_equal(there.costs_in_order(EAST), plain.costs_in_order(EAST))
    assert there.no_extra().any() == plain.no_extra().any()
    moves = plain.terrain.search._ground.moves
    assert moves.max() < 1 << len(MOVES)  # nothing is dear


def test_zones_that_come_on_the_way_change_it():
    one = Squad(HALL, [Pose(1.5, 1.5, 0.0)], config())
    one.send(0, Pose(6.5, 1.5, 0.0))
    one.run(20)
    one.robots[0].services.on_directed_zones([zone(math.pi, RIGHT)])
    for _ in range(800):
        one.run(1)
        assert not robot_in_box(one.bodies[0].pose)
        if one.ended(0):
            break
    assert one.ended(0)[0].outcome is Outcome.SUCCEEDED


def robot_in_box(pose):
    return BOX[0][0] <= pose.x <= BOX[2][0] and pose.y <= BOX[2][1] - CUT


def test_zones_are_the_same_on_the_other_side_and_bad_ones_are_rejected():
    zones = (zone(0.5, SHARP), zone(-1.0, RIGHT, is_two_way=True))
    assert read_zones(packed_zones(zones)) == zones
    assert read_zones(packed_zones(())) == ()
    for bad in (b"", b"\0" * 40, packed_zones([zone(math.nan, 1.0)]), packed_zones(["x"]),
                packed_zones([zone(0.0, 1.0, points=((0, 0), (1, 1)))])):  # fmt: skip
        with pytest.raises(RejectedError):
            read_zones(bad)
