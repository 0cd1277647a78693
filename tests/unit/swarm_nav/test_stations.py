"""Five robots want one station: they take turns, and wait as they are told."""

import pytest

from swarm_common.model.records import Pose
from swarm_common.model.sites import Sites
from swarm_nav.core.goals import Outcome
from tests.fakes.navigation import Squad, config, room

DOCK = Pose(4.5, 0.6, 0.0)
SITES = Sites(
    stations={"dock": DOCK}, circuits={"ring": ((2.5, 3.0), (6.5, 3.0), (6.5, 6.5), (2.5, 6.5))}
)
STARTS = [Pose(1.0 + 1.2 * k, 4.0 - 0.9 * (k % 2), -1.5) for k in range(5)]


@pytest.mark.parametrize("mode", ["park", "circuit", "auto"])
def test_all_are_served_one_after_the_other(mode):
    parameters = config(holding__mode=mode, holding__approach_slots=1)
    squad = Squad(room(9.0, 9.0), STARTS, parameters, SITES)
    robots = range(len(STARTS))
    for index in robots:
        squad.send(index, DOCK, goal_id=1)
    patterns: set[str] = set()
    goals = [1] * len(STARTS)
    while squad.tick < 1500 and any(len(squad.ended(k)) < 2 for k in robots):
        squad.run(1)
        for index in robots:
            status = squad.robots[index].status()
            if status.state == "holding":
                patterns.add(status.detail.split(",")[0])
                assert status.station == "dock"
                assert status.queue_place >= 1 or squad.ended(index)
            if len(squad.ended(index)) == goals[index] == 1:
                goals[index] = 2
                squad.send(index, STARTS[index], goal_id=2)
    ends = [end for index in robots for end in squad.ended(index)]
    assert [end.outcome for end in ends] == [Outcome.SUCCEEDED] * 10
    expected = {"park": {"parked"}, "circuit": {"on the circuit"}}.get(mode)
    assert patterns == expected if expected else patterns
    waited = sum(squad.robots[k].status().hold_time for k in robots)
    assert waited > 5.0
