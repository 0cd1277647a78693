"""A robot without a goal leaves a narrow region once somebody waits to get in."""

from __future__ import annotations

import numpy as np

from swarm_common.model.records import Pose
from swarm_nav.traffic.departure import Departure
from swarm_nav.traffic.gate import Gate, is_inside
from swarm_nav.traffic.holding import NEXT_GOAL_PATIENCE, Lease
from swarm_nav.traffic.situation import Situation
from tests.fakes.navigation import beacon, hear, room, situation

HALL = room(9.0, 9.0)


def idle_robot(*others: np.void, x: float = 4.5) -> tuple[Departure, Gate, Situation]:
    """Return a robot that stands in or beside a region, 4.0 < x < 5.0 m, and hears others."""
    s = situation(HALL, Pose(x, 4.5, 0.0))
    region = np.zeros(s.planner.lattice.base.shape, np.bool_)
    region[:, 40:50] = True
    hear(s, *others)
    gate = Gate(region)
    return Departure(gate, Lease()), gate, s


def wait(departure: Departure, s: Situation, seconds: float) -> bool:
    """Let it be idle for some time; return whether it leaves at the end."""
    leaves = False
    for _ in range(round(seconds * 10.0)):
        leaves = departure.update(s, True)
        s.tick += 1
    return leaves


def test_who_stands_inside_while_somebody_waits_leaves_for_a_place_outside() -> None:
    departure, gate, s = idle_robot(beacon(2, 2.0, 4.5, gate_tick=50, priority=1 << 40))
    assert not wait(departure, s, NEXT_GOAL_PATIENCE - 0.2)
    assert wait(departure, s, 0.5)
    x, y = s.tube.points[-1]
    assert gate.region is not None
    assert not is_inside(gate.region, s.planner.lattice.frame, x, y)


def test_nobody_leaves_for_those_who_are_admitted_or_do_not_ask() -> None:
    for gate_tick in (0, 1):
        departure, _, s = idle_robot(beacon(2, 2.0, 4.5, gate_tick=gate_tick, priority=1 << 40))
        assert not wait(departure, s, 10.0)


def test_outside_or_without_a_region_nobody_leaves() -> None:
    asking = beacon(2, 2.0, 4.5, gate_tick=50, priority=1 << 40)
    departure, gate, s = idle_robot(asking, x=6.5)
    assert not wait(departure, s, 10.0)
    departure, gate, s = idle_robot(asking)
    gate.region = None
    assert not wait(departure, s, 10.0)


def test_a_goal_or_a_pusher_ends_it_and_time_begins_anew() -> None:
    departure, _, s = idle_robot(beacon(2, 2.0, 4.5, gate_tick=50, priority=1 << 40))
    assert wait(departure, s, NEXT_GOAL_PATIENCE + 0.5)
    assert not departure.update(s, False)
    assert not wait(departure, s, NEXT_GOAL_PATIENCE - 0.2)


def test_it_is_over_where_it_wanted_to_go() -> None:
    departure, _, s = idle_robot(beacon(2, 2.0, 4.5, gate_tick=50, priority=1 << 40))
    assert wait(departure, s, NEXT_GOAL_PATIENCE + 0.5)
    x, y = s.tube.points[-1]
    s.pose = Pose(float(x), float(y), 0.0)
    assert not departure.update(s, True)
