"""Failures met with 100 robots in one hall, each as a test of its cure."""

import math

import numpy as np
import pytest

from swarm_common.model.beacon import HEARD_ENTRIES
from swarm_common.model.records import Pose
from swarm_nav.behaviour.goal_progress import GoalProgress
from swarm_nav.core.config import TrafficConfig
from swarm_nav.core.goals import Goal, GoalKind
from swarm_nav.perception.neighbor_table import UNHEARD_PATIENCE, NeighborTable
from swarm_nav.traffic.arbiter import Arbiter
from swarm_nav.traffic.single_lanes import SingleLanes
from tests.fakes.navigation import beacon, hear, robot_in, room

HALL = room(9.0, 9.0)
CROWD = 2 * HEARD_ENTRIES


def acknowledging(robot, x, tick):
    record = beacon(robot, x, 0.0)
    record["heard"][5] = 1 << 16 | tick
    return record


def crowd(acknowledged):
    """Return what robot 1 knows of a crowd 4 m away that acknowledged its beacon of a tick."""
    neighbors = NeighborTable(1, TrafficConfig())
    for tick in range(10, 101, 10):
        batch = [acknowledging(robot, 4.0, acknowledged) for robot in range(2, 2 + CROWD)]
        for record in batch:
            record["tick"] = tick
        neighbors.receive(np.array(batch), 0.0, 0.0)
        neighbors.refresh(tick + 1)
    return neighbors


def test_a_robot_beside_a_crowd_that_acknowledges_in_turn_is_not_taken_for_unheard():
    last = 100 - UNHEARD_PATIENCE
    assert crowd(last - 3).deaf_neighbor == 0
    assert crowd(last - 30).deaf_neighbor != 0


@pytest.mark.parametrize("others", [5, HEARD_ENTRIES, 100])
def test_everybody_in_range_is_acknowledged_within_the_patience(others):
    neighbors = NeighborTable(1, TrafficConfig())
    seen: set[int] = set()
    for tick in range(1, 1 + UNHEARD_PATIENCE):
        batch = [beacon(robot, 0.05 * robot, 0.0) for robot in range(2, 2 + others)]
        for record in batch:
            record["tick"] = tick
        neighbors.receive(np.array(batch), 0.0, 0.0)
        neighbors.refresh(tick + 1)
        seen |= {int(entry) >> 16 for entry in neighbors.heard(tick + 1)} - {0}
    assert seen == set(range(2, 2 + others))


def task(s):
    goal = Goal(
        kind=GoalKind.NAVIGATE, goal_id=1, poses_map=(Pose(8.0, 4.5, math.nan),), start_tick=0
    )
    return GoalProgress(goal, s)


def test_who_queued_for_longer_than_the_patience_drives_on_afterwards():
    s = robot_in(HALL, Pose(4.5, 4.5, 0.0))
    queued = task(s)
    patience = s.ticks(s.config.traffic.patience)
    for _ in range(3):
        s.tick += patience
        queued.record_holding(s)
    s.tick += 1
    assert s.tick - queued.moved_tick < patience
    assert not queued.lacks_progress(s)


def test_who_waits_for_an_acknowledgement_is_not_expected_to_move():
    s = robot_in(HALL, Pose(4.5, 4.5, 0.0))
    s.tube.adopt(np.column_stack((np.linspace(4.5, 6.0, 31), np.full(31, 4.5))))
    s.tube.publish(s.pose, s.tick - 1)
    reservation = Arbiter(s, SingleLanes())
    silent = beacon(2, 5.5, 5.5)
    hear(s, silent)
    s.neighbors.acks[:] = -1000  # it has not acknowledged anything yet
    reservation.extend()
    assert (s.tube.stop, s.blocked_ticks, s.is_unconfirmed) == (0, 0, True)
    s.neighbors.acks[:] = s.tick - 1
    reservation.extend()
    assert s.tube.stop > 0
    assert not s.is_unconfirmed
