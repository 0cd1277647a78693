"""Collision episodes, clearances and the hash of the trajectories."""

from __future__ import annotations

import json
import math

import numpy as np

from swarm_sim.engine import Touch
from swarm_sim.verdict import Judge

FAR = np.full((2, 2), np.inf)
POSES = np.zeros((2, 3))


def make_judge() -> Judge:
    return Judge(["a", "b"], POSES, FAR)


def feed(judge: Judge, tick: int, *touches: Touch) -> None:
    judge.observe(0.1 * tick, 0.01, touches, POSES, FAR)


def test_one_episode_counts_once_and_ends_after_half_a_second() -> None:
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


def test_obstacles_count_apart() -> None:
    judge = make_judge()
    feed(judge, 0, Touch(1, -1, "wall", 0, 0, 0), Touch(1, -1, "post", 0, 0, 1))
    feed(judge, 1, Touch(1, -1, "wall", 0, 0, 0))
    verdict = judge.verdict(0.2)
    assert (verdict.robot_robot, verdict.robot_world) == (0, 2)
    assert verdict.robots["a"].collisions == 0
    assert verdict.collisions[0].obstacle == "wall"


def test_distance_and_clearance() -> None:
    judge = make_judge()
    moved = np.array([[0.3, 0.4, 0.0], [0.0, 0.0, 1.0]])
    judge.observe(0.0, 0.01, [], moved, np.array([[0.5, 0.2], [np.inf, np.inf]]))
    verdict = judge.verdict(0.1)
    assert math.isclose(verdict.robots["a"].distance, 0.5)
    assert verdict.robots["a"].min_clearance == verdict.min_clearance == 0.2
    assert verdict.robots["b"].distance == 0.0
    assert verdict.robots["b"].min_clearance == math.inf


def test_json_has_no_infinity() -> None:
    data = json.loads(json.dumps(make_judge().verdict(0.0).as_json(), allow_nan=False))
    assert data["min_clearance"] is None
    assert data["robots"]["a"] == {"distance": 0.0, "collisions": 0, "min_clearance": None}


def test_the_hash_tells_trajectories_apart() -> None:
    hashes = []
    for offset in (0.0, 0.0, 1e-15):
        judge = make_judge()
        judge.observe(0.0, 0.01, [], POSES + offset, FAR)
        hashes.append(judge.verdict(0.1).trajectory_sha256)
    assert hashes[0] == hashes[1] != hashes[2]
