"""Entry control: what a narrow region is, who counts, and that the gate only delays."""

from __future__ import annotations

import numpy as np
import pytest

from swarm_common.records import Pose
from swarm_nav import gate_kernels as kernels
from swarm_nav.gate import ADMITTED, NONE, Gate, narrow_region
from tests.oracles import narrows as oracle
from tests.standins.navigation import beacon, hear, room, situation

FRAME = (-1.0, -0.5, 0.1)
HALL = room(9.0, 9.0)


@pytest.mark.parametrize("seed", range(5))
def test_the_kernels_equal_their_slow_twins(seed: int) -> None:
    rng = np.random.default_rng(seed)
    region = rng.random((30, 40)) < 0.4
    places = rng.uniform((-0.9, -0.4), (3.5, 3.0), (12, 2))
    for x, y in places:
        expected = oracle.is_inside(region, FRAME, (x, y))
        assert kernels.is_inside(region, FRAME, x, y) == expected
    inside = [oracle.is_inside(region, FRAME, (x, y)) for x, y in places]
    assert kernels.enters(region, FRAME, places) == any(inside)
    ticks = rng.choice((0, 1, 50, 60, 70), 12).astype(np.uint32)
    poses = np.column_stack((places, np.zeros(12))).astype(np.float32)
    robots = [
        ((float(x), float(y)), int(tick), robot)
        for robot, ((x, y, _), tick) in enumerate(zip(poses, ticks, strict=True), 1)
    ]
    ids = np.arange(1, 13, dtype=np.uint32)
    counted = kernels.count_ahead(region, FRAME, poses, ticks, ids, (60, 6))
    assert counted == oracle.count_ahead(region, FRAME, robots, (60, 6))
    cells = kernels.cells_within(region, FRAME, (1.0, 1.0), 0.83)
    assert cells == oracle.cells_within(region, FRAME, (1.0, 1.0), 0.83)


def test_a_hall_alone_has_no_narrow_region() -> None:
    s = situation(HALL, Pose(4.5, 4.5, 0.0))
    assert narrow_region(s.terrain, ((4.5, 4.5),)) is None
    assert narrow_region(s.terrain, ()) is None


def gate_and_robot(*others: np.void) -> tuple[Gate, object]:
    """Return a robot west of a region, with its way into it, and its gate."""
    s = situation(HALL, Pose(3.0, 4.5, 0.0))
    s.tube.adopt(np.column_stack((np.arange(3.0, 6.0, 0.05), np.full(60, 4.5))))
    region = np.zeros(s.planner.lattice.base.shape, np.bool_)
    region[:, 50:54] = True  # 3.6 m² of it, more or less, within radio range
    if others:
        hear(s, *others)
    return Gate(region), s


def test_a_robot_whose_way_leads_in_asks_and_is_admitted_where_there_is_room() -> None:
    gate, s = gate_and_robot()
    gate.update(s, True, True)
    assert gate.asked_tick == s.tick
    assert gate.is_admitted
    assert gate.announced == ADMITTED
    gate.update(s, False, True)
    assert gate.announced == NONE


def test_a_full_region_is_waited_for_but_not_for_ever() -> None:
    crowd = [beacon(k, 5.2, 0.6 + 0.6 * k) for k in range(2, 14)]
    gate, s = gate_and_robot(*crowd)
    start = s.tick
    gate.update(s, True, True)
    assert gate.is_closed
    assert gate.announced == start
    waited = 0
    while gate.is_closed and waited < 20_000:
        waited += 50
        s.tick = start + waited
        gate.update(s, True, True)
    assert gate.is_admitted
    assert waited * 0.1 <= 12 * s.config.holding.gate_patience + 5.0


def test_inside_nothing_is_asked() -> None:
    gate, s = gate_and_robot()
    s.pose = Pose(5.2, 4.5, 0.0)
    gate.update(s, True, True)
    assert gate.announced == NONE


def test_a_way_to_a_refuge_does_not_ask() -> None:
    gate, s = gate_and_robot()
    gate.update(s, True, False)
    assert gate.announced == NONE


def test_who_need_not_go_in_any_more_stops_waiting() -> None:
    crowd = [beacon(k, 5.2, 0.6 + 0.6 * k) for k in range(2, 14)]
    gate, s = gate_and_robot(*crowd)
    gate.update(s, True, True)
    assert gate.is_closed
    gate.recheck(s, np.array(((3.0, 4.5), (5.2, 4.5))))
    assert gate.is_closed
    gate.recheck(s, np.array(((3.0, 4.5), (3.0, 2.5))))
    assert gate.announced == NONE


def test_a_queue_that_advances_earns_no_patience() -> None:
    crowd = [beacon(k, 5.2, 0.6 + 0.6 * k) for k in range(2, 14)]
    gate, s = gate_and_robot(*crowd)
    start = s.tick
    gate.update(s, True, True)
    pause = s.ticks(0.9 * s.config.holding.gate_patience)
    for left in range(1, 6):
        s.tick = start + left * pause
        hear(s, *(beacon(k, 5.2 if k > 1 + left else 2.0, 0.6 * k - 0.6) for k in range(2, 14)))
        gate.update(s, True, True)
        assert gate.is_closed
