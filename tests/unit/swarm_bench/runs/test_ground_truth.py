"""Standing, circles and deadlocks as the simulator sees them."""

import numpy as np
import pytest

from swarm_bench.runs.ground_truth import GroundTruthWatch
from swarm_common.model.grid import Grid
from swarm_common.model.records import Pose
from swarm_mission.way_table import WayTable

RADIUS = 0.2


def floor():
    return Grid(np.zeros((100, 100), np.int8), 0.1, 0.0, 0.0)


def watched(poses, goals, seconds=100, drift=0.0):
    """Return what is seen of robots that stay; the last one moves by `drift` [m/s]."""
    names = [f"Srobot{number}" for number in range(1, len(poses) + 1)]
    watch = GroundTruthWatch(names, [RADIUS] * len(poses), floor(), ["dock"], 0.0)
    for index, goal in enumerate(goals):
        if goal is not None:
            watch.send(index, Pose(*goal, 0.0), "dock", 0)
    for second in range(seconds):
        now = np.array(poses)
        now[-1, 0] += drift * second
        watch.look(10 * second, now)
    return watch.figures(float(seconds))


def test_circles_and_queues_are_told_from_who_does_not_stand():
    seen = watched([(4.0, 5.0, 0.0), (4.6, 5.0, 3.1)], [(9.0, 5.0), (1.0, 5.0)])
    assert (seen.circles, seen.deadlocks) == (1, 1)
    assert seen.longest_circle == 97.0  # all but the first three seconds
    assert (seen.stood_time, seen.stood_worst) == (194.0, 97.0)
    assert seen.stood_share == pytest.approx(0.97, abs=0.01)
    poses = [(9.0, 5.0, 0.0), (8.4, 5.0, 0.0), (7.8, 5.0, 0.0)]
    seen = watched(poses, [None, (9.0, 5.0), (9.0, 5.0)], seconds=59)
    assert (seen.circles, seen.deadlocks) == (0, 0)
    assert seen.stood_worst == 56.0
    assert seen.stations["dock"].occupied == 1.0
    assert watched(poses, [None, (9.0, 5.0), (9.0, 5.0)]).deadlocks == 1  # nobody comes nearer
    assert watched([(4.0, 5.0, 0.0)], [None]).deadlocks == 0
    assert watched([(4.0, 5.0, 0.0)], [(4.1, 5.0)]).stood_time == 0.0
    moving = watched([(1.0, 5.0, 0.0)], [(7.5, 5.0)], seconds=60, drift=0.1)
    assert (moving.stood_time, moving.deadlocks) == (0.0, 0)
    assert 0.0 < moving.stations["dock"].approached < 0.2


def test_a_way_goes_round_a_wall():
    cells = np.zeros((100, 100), np.int8)
    cells[:80, 50] = 100
    ways = WayTable(Grid(cells, 0.1, 0.0, 0.0), RADIUS)
    goal = Pose(7.0, 2.0, 0.0)
    assert ways.left(goal, 3.0, 2.0) == pytest.approx(12.9, abs=1.0)  # 2 x hypot(2, 6.1)
    assert ways.direction(goal, 3.0, 2.0)[1] > 0.5  # up, although the goal is to the right
    assert ways.left(goal, 7.2, 2.0) == pytest.approx(0.2)
