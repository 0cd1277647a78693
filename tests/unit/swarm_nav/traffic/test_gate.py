"""Entry control: what a narrow region is, who counts, and that it stands below the priorities."""

import dataclasses

import numpy as np
import pytest

from swarm_common.model.beacon import MODE_DRIVE, MODE_HOLD
from swarm_common.model.records import Pose
from swarm_nav.core.rank import SENIORITY
from swarm_nav.perception.absence_kernels import NEVER, Sightings
from swarm_nav.planning.cells import label
from swarm_nav.planning.distance_kernels import Frame
from swarm_nav.planning.search_kernels import WALL
from swarm_nav.traffic import gate_kernels as kernels
from swarm_nav.traffic.gate import (
    ADMITTED,
    MOST_AREA,
    NONE,
    TURN_TICKS,
    Gate,
    label_of,
    narrow_region,
)
from swarm_nav.traffic.single_lane_kernels import label_at
from tests.fakes.decisions import arbiter_of
from tests.fakes.navigation import beacon, hear, robot_in, room, seen
from tests.oracles import single_lanes as oracle

FRAME = Frame(-1.0, -0.5, 0.1)
HALL = room(9.0, 9.0)


@pytest.mark.parametrize("seed", range(5))
def test_the_kernels_equal_their_slow_twins(seed):
    rng = np.random.default_rng(seed)
    region = rng.random((30, 40)) < 0.4
    parts = label(region)
    places = rng.uniform((-0.9, -0.4), (3.5, 3.0), (12, 2))
    for x, y in places:
        expected = oracle.is_inside(region, FRAME, (x, y))
        assert (label_at(parts, FRAME, x, y) > 0) == expected
    inside = [oracle.is_inside(region, FRAME, (x, y)) for x, y in places]
    assert kernels.entry(parts, FRAME, places) == (inside.index(True) if any(inside) else -1)
    ticks = rng.choice((0, 1, 50, 60, 70), 12).astype(np.uint32)
    blocked = rng.choice((0, 30, 31), 12).astype(np.uint32)
    gone = rng.random(12) < 0.2
    modes = rng.choice((MODE_DRIVE, MODE_HOLD), 12).astype(np.uint32)
    seniority, rank = rng.integers(1, 4, 12), rng.integers(0, 3, 12)
    ids = np.arange(1, 13, dtype=np.uint32)
    poses = np.column_stack((places, np.zeros(12))).astype(np.float32)
    robots = [
        oracle.Neighbor(
            (float(x), float(y)), int(ticks[k]), int(blocked[k]), (int(seniority[k]), -k - 1),
            bool(rank[k]), bool(gone[k]), bool(modes[k] == MODE_HOLD),
        )
        for k, (x, y, _) in enumerate(poses)
    ]  # fmt: skip
    priorities = rank * (SENIORITY + 1) + seniority
    counted = kernels.count_ahead(
        parts,
        FRAME,
        (poses, ticks, blocked, modes),
        (ids, priorities, gone),
        (2, 6, 30),
        (1.0, 1.0, 1.5),
    )
    assert counted == oracle.count_ahead(region, FRAME, robots, (2, -6), 30, (1.0, 1.0), 1.5)
    groups = oracle.components(region)
    numbers = [oracle.part_of(groups, FRAME, (x, y)) for x, y in places]
    assert [label_at(parts, FRAME, x, y) for x, y in places] == numbers
    known = Sightings(np.full(20, NEVER), np.zeros((20, 2), np.float32), rng.random(20) < 0.5)
    known.ticks[3:15], known.places[3:15] = rng.choice((5, 9), 12), places
    for part in (1, 2):
        seen = [
            3 + k
            for k, number in enumerate(numbers)
            if k and number == part and known.ticks[3 + k] == 9
        ]
        asking = [robot for robot in seen if known.asks[robot]]
        frame = FRAME
        assert kernels.count_seen(parts, part, frame, known, 9, 3, False) == len(seen)
        assert kernels.count_seen(parts, part, frame, known, 9, 3, True) == len(asking)


def region_of(s, *stations):
    return narrow_region(s.terrain, stations, s.usual_radius)


def test_what_is_no_region():
    s = robot_in(HALL, Pose(4.5, 4.5, 0.0))
    assert region_of(s, (4.5, 4.5)) is None
    assert region_of(s) is None
    # Any corner within 2 m of two walls counted as narrow, and closed a free station in it.
    s = robot_in(HALL, Pose(4.5, 4.5, 0.0))
    assert region_of(s, (0.5, 0.5)) is None
    # In a hall that lay askew in its map all floor that robots reach was one region.
    outside = (0.0, 4.2, 28.0, 4.6)
    s = robot_in(room(28.0, 14.0, (2.5, 1.4, 25.5, 1.8), outside), Pose(1.0, 3.0, 0.0))
    region = region_of(s, (14.0, 0.7), (14.0, 3.0))
    assert region is not None
    frame = s.planner.lattice.frame
    places = ((14.0, 0.7), (14.0, 3.0), (14.0, 9.0))
    assert [label_at(region, frame, x, y) for x, y in places] == [1, 0, 0]


def gate_and_robot(*others):
    """Return a robot west of a region, with its way into it, and its gate."""
    s = robot_in(HALL, Pose(3.0, 4.5, 0.0))
    s.tube.adopt(np.column_stack((np.arange(3.0, 6.0, 0.05), np.full(60, 4.5))))
    region = np.zeros(s.planner.lattice.base.shape, np.int16)
    region[:, 50:54] = 1  # 3.6 m² of it, more or less, within radio range
    if others:
        hear(s, *others)
    return Gate(region), s


def ask(gate, s, *, has_turn=True, is_driving=True, priority=5):
    gate.update(s, has_turn=has_turn, is_driving=is_driving, priority=lambda: priority)


def crowd(priority, count=12):
    driving = priority + (SENIORITY + 1)
    return [beacon(k, 5.2, 0.6 * k - 0.6, priority=driving) for k in range(2, 2 + count)]


def test_who_asks_is_admitted_with_room_or_the_rank_it_was_lent():
    gate, s = gate_and_robot()
    ask(gate, s)
    assert gate.asked_tick == s.tick
    assert gate.is_admitted
    assert gate.announced == ADMITTED
    ask(gate, s, has_turn=False)
    assert gate.announced == NONE
    # Gate and lease waited for each other for ever.
    gate, s = gate_and_robot(*crowd(7))
    ask(gate, s, priority=5)
    assert gate.is_closed
    ask(gate, s, priority=8)  # inherited
    assert gate.is_closed
    s.tick += TURN_TICKS
    hear(s, *crowd(7))
    ask(gate, s, priority=8)
    assert gate.is_admitted


def test_a_full_region_is_waited_for_until_room_or_rank_admits():
    gate, s = gate_and_robot(*crowd(9))
    start = s.tick
    ask(gate, s)
    assert gate.is_closed
    assert gate.announced == start
    s.tick += 20_000
    hear(s, *crowd(9))
    ask(gate, s)
    assert gate.is_closed, "those inside rank above it"
    hear(s, *crowd(4))
    ask(gate, s)
    assert gate.is_admitted, "nobody ranks above it"


def test_who_waits_for_a_lease_or_is_blocked_takes_no_place_at_the_gate():
    gate, s = gate_and_robot(*crowd(9))
    ask(gate, s)
    ask(gate, s, has_turn=False)
    assert gate.announced == NONE
    for blocked, is_admitted in ((0, False), (31, True)):
        others = [
            beacon(k, 4.0, 0.6 * k - 0.6, priority=9 + SENIORITY + 1, gate_tick=ADMITTED,
                   blocked_ticks=blocked)
            for k in range(2, 14)
        ]  # fmt: skip
        gate, s = gate_and_robot(*others)
        ask(gate, s)
        assert gate.is_admitted is is_admitted


def test_who_waits_away_from_the_mouth_is_admitted_where_there_is_room():
    """Room was counted where it waits: parked 6 m away it saw none, and the aisle stayed empty."""
    gate, s = gate_and_robot(*crowd(9))
    gate.region[:, 50:70] = 1
    ask(gate, s)
    assert gate.is_closed
    s.tick += 1
    s.pose = Pose(0.5, 8.5, 0.0)
    hear(s, *crowd(9)[:2], *(beacon(k, 8.0, 0.6 * k) for k in range(4, 14)))  # the others are out
    ask(gate, s)
    assert gate.is_admitted


@pytest.mark.parametrize(("inside", "is_admitted"), [(5, True), (6, False)])
def test_who_was_seen_inside_beyond_hearing_takes_a_place(inside, is_admitted):
    """At the mouth of a long aisle only its beginning is heard: 49 robots were in room for 18."""
    gate, s = gate_and_robot()
    gate.region[:, 50:70] = 1  # 16 m², room for six
    hear(s, *crowd(9, 1), *seen(s.tick, *((6.5, 1.0 + 0.9 * k) for k in range(inside))))
    ask(gate, s)
    assert gate.is_admitted is is_admitted
    s.tick += 149
    hear(s, *crowd(9, 1))
    ask(gate, s)
    assert gate.is_admitted is is_admitted
    s.tick += 2
    hear(s, *crowd(9, 1))
    ask(gate, s)
    assert gate.is_admitted, "nobody has seen them there for a while"


def test_who_was_seen_in_another_region_takes_no_place():
    gate, s = gate_and_robot()
    gate.region[:, 60:80] = 2
    hear(s, *crowd(9, 1), *seen(s.tick, *((6.5, 1.0 + 0.8 * k) for k in range(9))))
    gate.region[:, 50:54] = 1
    ask(gate, s)
    assert gate.is_admitted


@pytest.mark.parametrize("change", ["density", "region"])
def test_without_a_gate_nobody_waits_before_it(change):
    """A robot that waited when the gate was switched off waited for ever."""
    gate, s = gate_and_robot(*crowd(9))
    ask(gate, s)
    assert gate.is_closed
    if change == "region":
        gate.region = None  # as on a map without narrow regions
    else:
        open_gate = dataclasses.replace(s.config.holding, region_density=0.0)
        arbiter_of(s).configure(dataclasses.replace(s.config, holding=open_gate))
    ask(gate, s)
    assert not gate.is_closed


@pytest.mark.parametrize(("nearer", "is_admitted"), [(5, True), (6, False)])
def test_who_stands_at_the_mouth_enters_first(nearer, is_admitted):
    """Who ranked higher went first, from wherever it was parked: the aisle was empty meanwhile."""
    gate, s = gate_and_robot()
    high = 9 + SENIORITY + 1
    near = [beacon(k, 4.0, 4.0 + 0.2 * k, gate_tick=50) for k in range(2, 2 + nearer)]
    far = [beacon(k, 0.5, 0.6 * k, priority=high, gate_tick=50) for k in range(8, 14)]
    hear(s, *near, *far)
    ask(gate, s)
    assert gate.is_admitted is is_admitted


@pytest.mark.parametrize(("holding", "is_admitted"), [(2, True), (3, False)])
def test_nobody_follows_those_who_wait_inside(holding, is_admitted):
    """A pipeline's robots crowded before its first loaders, in the way of those that left them."""
    gate, s = gate_and_robot()
    gate.region[:, 50:70] = 1  # 16 m², room for six
    for count, expected in ((holding, is_admitted), (0, True)):
        inside = [
            beacon(k, 5.5, 3.0 + 0.5 * k, priority=9 + SENIORITY + 1,
                   mode=MODE_HOLD if k < 2 + count else MODE_DRIVE)
            for k in range(2, 6)
        ]  # fmt: skip
        hear(s, *inside)
        ask(gate, s)
        assert gate.is_admitted is expected
        gate.leave()


AISLES = room(28.0, 4.2, (2.5, 1.4, 25.5, 1.8))  # 1.4 m and 2.4 m wide


def test_a_narrow_aisle_is_a_region_where_all_ways_are_narrow():
    """Without open floor 4 m wide there was none: 45 robots crowded into one of two lanes."""
    s = robot_in(AISLES, Pose(1.0, 3.0, 0.0))
    region = region_of(s, (14.0, 0.7), (14.0, 3.0))
    assert region is not None
    frame = s.planner.lattice.frame
    places = ((14.0, 0.7), (5.0, 0.7), (14.0, 3.0), (1.0, 0.7))
    assert [label_at(region, frame, x, y) for x, y in places] == [1, 1, 0, 0]


def test_who_stands_beside_the_nodes_of_a_region_is_in_it():
    """At a corner two robots waited at the gate in the lanes of those for whom they waited."""
    s = robot_in(AISLES, Pose(1.0, 3.0, 0.0))
    region = region_of(s, (14.0, 0.7))
    assert region is not None
    lattice = s.planner.lattice
    floor = lattice.base < WALL
    row, column = np.argwhere(floor & (region > 0))[0].tolist()
    x, y = lattice.point_of(row * floor.shape[1] + column)
    assert not floor[row - 1, column]
    assert label_of(region, lattice.frame, x, y - lattice.step)
    assert not label_of(region, lattice.frame, x, y - 4.0 * lattice.step)
    some = Gate(region)
    some._choose_part(s, x, y - lattice.step)
    assert some._part_area == pytest.approx(np.sum(floor & (region == 1)) * lattice.step**2)


def test_an_aisle_is_a_region_where_the_narrow_part_around_it_never_is_full(monkeypatch):
    walls = [(2.5 + x, 1.4, 25.5 + x, 1.8) for x in (0.0, 29.0)]
    grid = room(58.0, 9.0, *walls, (2.5, 4.2, 29.0, 4.6), (33.0, 4.2, 58.0, 4.6))
    s = robot_in(grid, Pose(1.0, 3.0, 0.0))
    frame = s.planner.lattice.frame
    for most, expected in ((MOST_AREA, [1, 1]), (60.0, [0, 1])):
        monkeypatch.setattr("swarm_nav.traffic.gate.MOST_AREA", most)
        narrow_region.cache_clear()
        region = region_of(s, (14.0, 3.0), (14.0, 0.7))
        assert region is not None
        assert [label_at(region, frame, 14.0, y) for y in (3.0, 0.7)] == expected
    narrow_region.cache_clear()


def test_where_nothing_is_asked():
    gate, s = gate_and_robot()
    s.pose = Pose(5.2, 4.5, 0.0)
    ask(gate, s)
    assert gate.announced == NONE
    gate, s = gate_and_robot()
    ask(gate, s, is_driving=False)
    assert gate.announced == NONE
    gate, s = gate_and_robot(*crowd(9))
    ask(gate, s)
    assert gate.is_closed
    gate.recheck(s, np.array(((3.0, 4.5), (5.2, 4.5))))
    assert gate.is_closed
    gate.recheck(s, np.array(((3.0, 4.5), (3.0, 2.5))))
    assert gate.announced == NONE


def test_the_floor_before_a_region_follows_region_and_depth():
    s = robot_in(room(9.0, 9.0), Pose(4.5, 4.5, 0.0))
    lattice = s.planner.lattice
    gate = Gate(None)
    assert gate.forecourt(lattice, 1.0) is None
    for first, depth in ((40, 1.0), (40, 2.0), (20, 2.0)):
        gate.region = np.zeros(lattice.base.shape, np.int16)
        gate.region[:, first : first + 10] = 1
        forecourt = gate.forecourt(lattice, depth)
        columns = np.flatnonzero(forecourt[45])
        assert (columns[0], columns[-1]) == (first - depth * 10, first + 9 + depth * 10)
        assert gate.forecourt(lattice, depth) is forecourt
