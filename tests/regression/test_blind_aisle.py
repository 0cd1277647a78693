"""A blind aisle for one robot, longer than the radio reaches, with robots in it from the start."""

import math

import pytest

from swarm_bench.halls import halls
from swarm_bench.halls.hall import Hall
from swarm_common.model.records import Pose
from swarm_sim.maps.draw_map import draw_world

END, ELSEWHERE = Pose(4.0, 13.2, math.nan), Pose(7.0, 1.0, math.nan)
UP = math.pi / 2


@pytest.mark.parametrize("robots", [5, pytest.param(8, marks=pytest.mark.long)])
def test_all_get_to_its_end_one_after_the_other(monkeypatch, robots):
    """Two of them did: who started deep in it was pushed back, who was done stayed at its end."""
    hall = Hall(8.0, 14.0, [(0.0, 5.0, 3.5, 14.0), (4.5, 5.0, 8.0, 14.0)], [END, ELSEWHERE])
    inside = [Pose(4.0, 11.5, UP), Pose(4.0, 10.0, UP)]
    hall.homes = [*inside, *(Pose(1.0 + 1.2 * k, 1.0, UP) for k in range(robots - 2))]
    hall.goals = [[ELSEWHERE], *([END] for _ in range(robots - 1))]
    grid = draw_world(hall.scene())
    monkeypatch.setattr(halls, "hall_of", lambda options: (hall, grid))
    result = halls.run_hall(halls.hall_runs([0], [robots], "roam", "none")[0])
    assert result.goals_reached == robots
    assert result.robot_robot + result.robot_world == 0
    assert result.makespan is not None
    assert result.makespan < 100.0 * robots
