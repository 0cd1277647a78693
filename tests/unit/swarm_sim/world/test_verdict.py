"""Collision episodes, clearances and the hash of the trajectories."""

import json
import math

import numpy as np

from swarm_sim.physics.engine import NearPair, Touch
from swarm_sim.world.verdict import Judge

FAR = np.full((2, 2), np.inf)
POSES = np.zeros((2, 3))


def make_judge():
    return Judge(["a", "b"], POSES, FAR)


def feed(judge, tick, *touches):
    judge.observe(0.1 * tick, 0.01, touches, POSES, FAR)


def test_one_episode_counts_once_and_ends_after_half_a_second():
    judge = make_judge()
    meeting = Touch(0, 1, "", 1.0, 2.0, 4)
    for tick in range(3):
        feed(judge, tick, meeting, meeting)
    for tick in range(3, 7):
        feed(judge, tick)
    feed(judge, 7, meeting)  # 0.5 s after the last touch: the same episode
    for tick in range(8, 13):
        feed(judge, tick)
    feed(judge, 13, meeting)  # 0.6 s after it: a new one
    verdict = judge.verdict(1.4)
    assert (verdict.robot_robot, verdict.robot_world) == (2, 0)
    assert [c.sim_time for c in verdict.collisions] == [0.05, 1.35]
    assert verdict.collisions[0].robots == ("a", "b")
    assert [verdict.robots[name].collisions for name in "ab"] == [2, 2]
    assert verdict.min_clearance == 0.0


def test_obstacles_count_apart_with_distance_and_clearance():
    judge = make_judge()
    feed(judge, 0, Touch(1, -1, "wall", 0, 0, 0), Touch(1, -1, "post", 0, 0, 1))
    feed(judge, 1, Touch(1, -1, "wall", 0, 0, 0))
    verdict = judge.verdict(0.2)
    assert (verdict.robot_robot, verdict.robot_world) == (0, 2)
    assert verdict.robots["a"].collisions == 0
    assert verdict.collisions[0].obstacle == "wall"
    judge = make_judge()
    moved = np.array([[0.3, 0.4, 0.0], [0.0, 0.0, 1.0]])
    judge.observe(0.0, 0.01, [], moved, np.array([[0.5, 0.2], [np.inf, np.inf]]))
    verdict = judge.verdict(0.1)
    assert math.isclose(verdict.robots["a"].distance, 0.5)
    assert verdict.robots["a"].min_clearance == verdict.min_clearance == 0.2
    assert verdict.robots["b"].distance == 0.0
    assert verdict.robots["b"].min_clearance == math.inf


def approach(judge, tick, *approaches):
    judge.observe(0.1 * tick, 0.01, [], POSES, FAR, approaches)


def test_a_near_miss_is_one_episode_with_its_closest_place():
    judge = make_judge()
    for tick, gap in enumerate([0.02, 0.01, 0.025]):
        poses = np.array([[float(tick), 0.0, 0.0], [0.0, 1.0, 0.0]])
        judge.observe(0.1 * tick, 0.01, [], poses, FAR, [NearPair(0, 1, "", gap)])
    for tick in range(3, 12):
        feed(judge, tick)
    approach(judge, 12, NearPair(0, -1, "wall", 0.005))
    verdict = judge.verdict(1.3)
    first, second = verdict.close_calls
    assert (first.robots, first.obstacle, first.distance) == (("a", "b"), "", 0.01)
    assert (first.x, first.y, first.sim_time) == (0.5, 0.5, 0.1)
    assert (second.robots, second.obstacle, second.sim_time) == (("a",), "wall", 1.3)
    assert verdict.near_misses == 2
    assert [verdict.robots[name].near_misses for name in "ab"] == [2, 1]
    assert verdict.as_json()["close_calls"][0]["robots"] == ("a", "b")


def test_an_approach_that_ends_or_begins_with_contact_is_no_near_miss():
    judge = make_judge()
    approach(judge, 0, NearPair(0, 1, "", 0.01))
    feed(judge, 1, Touch(0, 1, "", 0.0, 0.0, 3))
    approach(judge, 2, NearPair(0, 1, "", 0.01))
    verdict = judge.verdict(0.3)
    assert (verdict.robot_robot, verdict.near_misses) == (1, 0)
    for tick in range(3, 10):
        feed(judge, tick)
    approach(judge, 10, NearPair(0, 1, "", 0.01))  # long after it: one of its own
    assert judge.verdict(1.1).near_misses == 1


def test_json_has_no_infinity_and_the_hash_tells_trajectories_apart():
    data = json.loads(json.dumps(make_judge().verdict(0.0).as_json(), allow_nan=False))
    assert data["min_clearance"] is None
    assert data["robots"]["a"] == {
        "distance": 0.0,
        "collisions": 0,
        "min_clearance": None,
        "near_misses": 0,
    }
    hashes = []
    for offset in (0.0, 0.0, 1e-15):
        judge = make_judge()
        judge.observe(0.0, 0.01, [], POSES + offset, FAR)
        hashes.append(judge.verdict(0.1).trajectory_sha256)
    assert hashes[0] == hashes[1] != hashes[2]
