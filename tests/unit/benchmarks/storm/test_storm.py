"""Storms: what is drawn from a seed, what counts as a contact and as a way, and a short one."""

import dataclasses
import itertools
import json

import numpy as np
import pytest

from benchmarks.storm.plan import (
    FIRST,
    FOR_EVER,
    Crate,
    Failure,
    Fault,
    StormPlan,
    draw_faults,
)  # fmt: skip
from benchmarks.storm.reachable import Floor
from benchmarks.storm.storm import ROWS, Storm, StormOptions, StormResult
from swarm_sim.world.verdict import Collision
from tests.fakes.navigation import room

CALM = StormPlan((), (), ())


def calm(*faults):
    return Storm(StormOptions("crossing", 1), dataclasses.replace(CALM, faults=faults))


@pytest.mark.parametrize("seed", range(20))
def test_a_robot_has_one_failure_at_a_time_and_most_robots_live(seed):
    faults = draw_faults(np.random.default_rng(seed), 12)
    assert faults == draw_faults(np.random.default_rng(seed), 12)
    lost = [fault.robot for fault in faults if fault.end >= FOR_EVER]
    assert len(lost) <= 3
    for robot in range(12):
        own = [fault for fault in faults if fault.robot == robot]
        assert all(a.end + FIRST <= b.begin for a, b in itertools.pairwise(own))


def test_a_way_is_one_for_the_whole_body_among_walls_and_discs():
    floor = Floor(room(6.0, 3.0, (2.9, 0.0, 3.1, 1.0)))
    start, end = (1.0, 1.0), (5.0, 1.0)

    def is_way(*discs):
        return floor.connected(floor.components(0.25, discs), start, end)

    assert is_way()
    assert is_way((3.0, 2.9, 1.0))
    assert not is_way((3.0, 2.9, 1.7))  # bars the gap
    assert not is_way((5.0, 1.0, 0.3))  # is on the goal


def test_a_failure_begins_and_ends_when_it_is_to():
    storm = calm(
        Fault(0, Failure.KILLED, 20, 60), Fault(1, Failure.HUNG, 20, 60),
        Fault(2, Failure.MUTE, 20, 60), Fault(3, Failure.DEAF, 20, FOR_EVER),
        Fault(4, Failure.KILLED, 30, FOR_EVER),
    )  # fmt: skip
    drivers = list(storm.episode.drivers)
    while storm.episode.world.tick < 50:
        assert storm.advance()
    before = storm.episode.world.poses.copy()
    heard = {int(beacon["id"]) for beacon in storm.episode.world.observe()[5].neighbors}
    storm.advance()
    assert not heard & {1, 2, 3, 5}
    assert np.allclose(before[[0, 1, 4]], storm.episode.world.poses[[0, 1, 4]], atol=1e-3)
    assert drivers[3].status().detail.startswith("stands")
    while storm.episode.world.tick < 80:
        storm.advance()
    assert storm.episode.drivers[0] is not drivers[0]
    assert storm.episode.drivers[1:] == drivers[1:]
    pose = storm.episode.drivers[0].status().pose_map
    assert np.allclose((pose.x, pose.y), storm.episode.world.poses[0, :2], atol=0.02)


def test_only_contacts_in_which_a_robot_that_lives_moves_are_held_against_it():
    storm = calm(Fault(0, Failure.KILLED, 0, FOR_EVER))
    storm.begin(5)
    storm._was_moving[:] = False
    storm._was_moving[[0, 1]] = True
    meetings = [("Srobot1", "Srobot3"), ("Srobot3",), ("Srobot1",), ("Srobot2", "Srobot3")]
    storm.on_contacts([Collision(names, "", 0.0, 0.0, 1.0) for names in meetings])
    assert [contact.robots for contact in storm.contacts] == [("Srobot2", "Srobot3")]


def test_a_goal_that_lies_on_a_dead_robot_is_barred_and_not_owed():
    storm = calm(Fault(0, Failure.KILLED, 10, FOR_EVER))
    storm.begin(20)
    goal = storm.episode.stops[1][0]
    assert storm._leads(storm._regions(storm._stuck()), 1, goal)
    storm.episode.world.place(0, goal.pose_map)
    assert not storm._leads(storm._regions(storm._stuck()), 1, goal)


def test_crates_are_put_down_although_a_goal_is_barred_already_and_bar_no_other():
    plan = dataclasses.replace(
        CALM, faults=(Fault(0, Failure.KILLED, 10, FOR_EVER),),
        crates=tuple(Crate(20, 0.4, 0.0) for _ in range(3)),
    )  # fmt: skip
    storm = Storm(StormOptions("pillars", 2), plan)
    storm.begin(11)
    storm.episode.world.place(0, storm.episode.stops[1][0].pose_map)
    before = storm._led_to(storm._stuck())
    assert (1, 0) not in before
    for tick in range(20, 80, 10):
        storm.begin(tick)
    assert len(storm._crates) == 3
    assert storm._led_to([*storm._crates, *storm._stuck()]) == before


@pytest.mark.parametrize("world", ["crossing", "pillars"])
def test_a_short_storm_hurts_nobody(world):
    """The whole seeds are `python -m benchmarks storm`; see docs/reliability.md."""
    storm = Storm(StormOptions(world, list(ROWS).index(world)))
    for _ in range(700):
        if not storm.advance():
            break
    assert storm.contacts == []


def test_a_result_survives_its_file():
    storm = calm()
    storm._limit = 30
    result = storm.storm()
    assert not result.is_flawless
    again = json.loads(json.dumps(result.as_json()))
    assert again.pop("schema") == 1
    assert StormResult(**again).first_miss == result.first_miss
