"""The obstacle layer: marks, clears, and knows walls and robots."""

import dataclasses
import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from swarm_common.model.beacon import FOOTPRINT_POINTS
from swarm_common.model.records import LidarSpec, Pose, Scan
from swarm_nav.core.config import CostmapConfig
from swarm_nav.perception import obstacle_kernels
from swarm_nav.perception.dynamic_obstacles import WALKED_TICKS
from swarm_nav.perception.obstacle_kernels import Beam, HitLimits
from swarm_nav.perception.obstacles import CELL, ObstacleLayer
from swarm_nav.planning.distance_kernels import Place, sample
from swarm_nav.reservation.tube import padded
from tests.fakes.navigation import beacon, hear, robot_in, room, waffle
from tests.oracles import control as oracle

HALL = room(6.0, 6.0)
MIDDLE = Pose(3.0, 3.0, 0.0)
LIDAR = LidarSpec(0.0, 0.0, 0.1)


def scan(hits, rays=360, increment=math.tau / 360):
    ranges = np.full(rays, np.inf, np.float32)
    for ray, distance in hits.items():
        ranges[ray] = distance
    return Scan(0, 0.0, increment, 0.12, 3.5, ranges)


def layer():
    return ObstacleLayer(CostmapConfig(), LIDAR)


def test_an_unexplained_hit_is_marked_where_it_is_and_a_mapped_wall_is_not():
    s, marks = robot_in(HALL, MIDDLE), layer()
    marks.update(scan({0: 1.0, 90: 0.8}), MIDDLE, s.terrain, s.neighbors)
    assert sorted(map(tuple, marks.points.round(3).tolist())) == [(3.0, 3.8), (4.0, 3.0)]
    s, marks = robot_in(HALL, Pose(1.0, 3.0, 0.0)), layer()
    marks.update(scan({180: 0.93}), s.pose, s.terrain, s.neighbors)
    assert len(marks.points) == 0
    mounted = LidarSpec(0.1, 0.0, 0.1, yaw=math.pi / 2)
    s, marks = robot_in(HALL, MIDDLE), ObstacleLayer(CostmapConfig(), mounted)
    marks.update(scan({0: 1.0}), Pose(3.0, 3.0, math.pi / 2), s.terrain, s.neighbors)
    assert marks.points.round(3).tolist() == [[2.0, 3.1]]


def test_rays_clear_what_they_pass_and_marks_are_rounded_to_cells():
    s, marks = robot_in(HALL, MIDDLE), layer()
    marks.update(scan({0: 1.0, 90: 1.0}), MIDDLE, s.terrain, s.neighbors)
    marks.update(scan({0: 0.5, 90: 2.0}), MIDDLE, s.terrain, s.neighbors)
    assert (4.0, 3.0) in map(tuple, marks.points.round(3).tolist())
    assert (3.0, 4.0) not in map(tuple, marks.points.round(3).tolist())
    s, marks = robot_in(HALL, MIDDLE), layer()
    marks.update(scan({ray: 1.0 for ray in range(0, 30)}), MIDDLE, s.terrain, s.neighbors)
    assert np.allclose(marks.points / CELL, np.round(marks.points / CELL))
    assert len(np.unique(marks.points, axis=0)) == len(marks.points)
    marks.clear()
    assert len(marks.points) == 0


@pytest.mark.parametrize("distance", [2.6, 3.4])
def test_a_hit_beyond_the_marking_range_is_not_marked(distance):
    s, marks = robot_in(room(12.0, 12.0), Pose(6.0, 6.0, 0.0)), layer()
    marks.update(scan({0: distance}), s.pose, s.terrain, s.neighbors)
    assert len(marks.points) == 0


def test_robots_that_say_where_they_are_are_not_marked_and_clear_old_marks():
    s, marks = robot_in(HALL, MIDDLE), layer()
    marks.update(scan({0: 1.0}), MIDDLE, s.terrain, s.neighbors)
    assert len(marks.points) == 1
    hear(s, beacon(2, 4.05, 3.0))
    marks.update(scan({0: 1.0}), MIDDLE, s.terrain, s.neighbors)
    assert len(marks.points) == 0


def silent(s, ticks, **fields):
    hear(s, beacon(2, 4.0, 3.0, **fields))
    s.tick += ticks
    s.neighbors.refresh(s.tick)


@pytest.mark.parametrize("ticks", [0, 10, 16, 17, 60, 200, 5000])
def test_however_long_a_robot_is_silent_it_masks_its_own_space_only(ticks):
    s, marks = robot_in(HALL, MIDDLE), layer()
    silent(s, ticks)
    hits = {0: 0.8, 21: 1.0, 339: 1.0, 33: 1.05}  # at 0.2, 0.36, 0.36, and 0.59 m from it
    marks.update(scan(hits), MIDDLE, s.terrain, s.neighbors, 0.047)
    assert len(marks.points) == 3


@pytest.mark.parametrize("ticks", [10, 17, 60, 200, 5000])
def test_no_mark_is_erased_because_of_an_old_beacon(ticks):
    s, marks = robot_in(HALL, MIDDLE), layer()
    marks.update(scan({0: 0.9}), MIDDLE, s.terrain, s.neighbors)
    silent(s, ticks)
    marks.update(scan({0: 0.5}), MIDDLE, s.terrain, s.neighbors, 0.047)  # does not see the place
    assert (3.9, 3.0) in map(tuple, marks.points.round(3).tolist())


def seeing():
    return ObstacleLayer(CostmapConfig(), LIDAR, waffle().footprint)


def waffles_beacon(**fields):
    points, size = padded(np.array(waffle().footprint), FOOTPRINT_POINTS)
    return {"footprint": points, "footprint_size": size, **fields}


def test_a_silent_robot_is_forgotten_once_its_place_was_seen_empty():
    s, marks = robot_in(HALL, MIDDLE), seeing()
    held = [(4.0, 3.0 + 0.05 * k) for k in range(8)]
    silent(s, 101, **waffles_beacon(held=held))
    marks.update(scan({}), MIDDLE, s.terrain, s.neighbors)
    s.neighbors.refresh(s.tick)
    assert len(s.neighbors.tubes(0)) == 8  # one scan may be wrong
    marks.update(scan({}), MIDDLE, s.terrain, s.neighbors)
    s.neighbors.refresh(s.tick)
    assert s.neighbors.ids.tolist() == []


def test_only_the_places_seen_through_are_given_up():
    s, marks = robot_in(HALL, MIDDLE), seeing()
    held = [(4.0, 2.8 + 0.2 * k) for k in range(6)]
    silent(s, 101, **waffles_beacon(held=held))
    housing = {0: 0.97, 1: 0.96, 359: 0.98}  # of its LiDAR
    for _ in range(4):
        marks.update(scan(housing), MIDDLE, s.terrain, s.neighbors)
        s.neighbors.refresh(s.tick)
    assert np.allclose(s.neighbors.tubes(0), held[1:2])
    assert len(marks.points) == 0


def test_a_place_is_given_up_as_soon_as_no_lidar_can_stand_there():
    s, marks = robot_in(HALL, MIDDLE), seeing()
    held = [(4.0, 3.0), (4.0, 3.06), (4.0, 3.12)]  # bodies there would overlap
    silent(s, 101, **waffles_beacon(held=held))
    for _ in range(2):
        marks.update(scan({0: 0.97, 1: 0.96, 359: 0.98}), MIDDLE, s.terrain, s.neighbors)
        s.neighbors.refresh(s.tick)
    assert np.allclose(s.neighbors.tubes(0), held[:2])


@pytest.mark.parametrize("case", ["other model", "hidden", "far", "not stopped", "lives"])
def test_what_does_not_show_that_a_place_is_empty(case):
    s, marks = robot_in(room(12.0, 6.0), MIDDLE), seeing()
    x = 6.2 if case == "far" else 4.0
    fields = {} if case == "other model" else waffles_beacon()
    silent(s, 60 if case == "not stopped" else 101, held=[(x, 3.0)], **fields)
    if case == "lives":
        hear(s, beacon(2, 4.0, 3.0, **fields))
    seen = scan({ray: 0.5 for ray in (0, 1, 5, 355)} if case == "hidden" else {})
    for _ in range(4):
        marks.update(seen, MIDDLE, s.terrain, s.neighbors)
        s.neighbors.refresh(s.tick)
    assert len(s.neighbors.tubes(0)) == 1


def test_where_somebody_walked_is_remembered_for_a_while():
    s, marks = robot_in(HALL, MIDDLE), layer()
    for step in range(20):
        s.tick += 1
        way = 2.0 - 0.08 * step  # [m] towards the robot, from (5, 3) to (3.5, 3)
        seen = dataclasses.replace(scan({ray: way for ray in (-2, -1, 0, 1, 2)}), tick=s.tick)
        marks.update(seen, MIDDLE, s.terrain, s.neighbors)
    walked = marks.walked(s.tick)
    assert (3.6, 3.0) in map(tuple, walked.round(3).tolist())
    marks.clear()
    assert len(marks.walked(s.tick)) == len(walked)
    assert len(marks.walked(s.tick + WALKED_TICKS)) == 0


def test_what_stands_has_not_walked_and_invalid_ranges_are_nothing():
    s, marks = robot_in(HALL, MIDDLE), layer()
    for _ in range(20):
        s.tick += 1
        seen = dataclasses.replace(scan({0: 1.0, 1: 1.0}), tick=s.tick)
        marks.update(seen, MIDDLE, s.terrain, s.neighbors)
    assert len(marks.points) > 0
    assert len(marks.walked(s.tick)) == 0
    s, marks = robot_in(HALL, MIDDLE), layer()
    marks.update(scan({0: 1.0}), MIDDLE, s.terrain, s.neighbors)
    marks.update(scan({0: math.nan, 90: math.nan, 180: 0.0}), MIDDLE, s.terrain, s.neighbors)
    assert marks.points.round(3).tolist() == [[4.0, 3.0]]


def test_a_lidar_that_looks_ahead_only_does_not_clear_behind():
    half = LidarSpec(0.0, 0.0, 0.1, rays=180, angle_min=-math.pi / 2)
    s, marks = robot_in(HALL, MIDDLE), ObstacleLayer(CostmapConfig(), half)
    ahead = Scan(0, -math.pi / 2, math.pi / 180, 0.12, 3.5, np.full(180, np.inf, np.float32))
    ahead.ranges[90] = 1.0
    marks.update(ahead, MIDDLE, s.terrain, s.neighbors)
    assert len(marks.points) == 1
    free = Scan(1, -math.pi / 2, math.pi / 180, 0.12, 3.5, np.full(180, np.inf, np.float32))
    marks.update(free, Pose(3.0, 3.0, math.pi - 0.3), s.terrain, s.neighbors)
    assert len(marks.points) == 1


@pytest.mark.parametrize("seed", range(6))
def test_the_choice_of_hits_equals_its_slow_twin(seed):
    rng = np.random.default_rng(seed)
    s = robot_in(HALL, MIDDLE)
    ranges = rng.uniform(0.0, 3.5, 360).astype(np.float32)
    robots, reach = rng.uniform(1.0, 5.0, (3, 2)), rng.uniform(0.2, 0.6, 3).astype(np.float32)
    pose = (*rng.uniform(2.0, 4.0, 2).tolist(), float(rng.uniform(-3.0, 3.0)))
    out = np.empty((360, 2))
    count = obstacle_kernels.unexplained(
        ranges, Beam(0.0, math.tau / 360, 0.12), Place(*pose), HitLimits(2.5, 0.2),
        s.terrain.field, robots, reach, out,
    )  # fmt: skip
    angles = pose[2] + np.arange(360) * math.tau / 360
    hits = np.array(pose[:2]) + ranges[:, None] * np.column_stack((np.cos(angles), np.sin(angles)))
    walls = np.array([sample(s.terrain.distance, s.terrain.frame, x, y) for x, y in hits])
    expected = oracle.unexplained(hits, ranges, (0.12, 2.5, 0.2), walls, robots, reach)
    assert np.allclose(out[:count], expected)


@settings(max_examples=50, deadline=None)
@given(st.integers(0, 10_000), st.integers(0, 30), st.integers(0, 30))
def test_marks_are_the_distinct_cells_of_all_points(seed, old, new):
    rng = np.random.default_rng(seed)
    points = rng.uniform(-0.4, 0.4, (old + new, 2))
    expected = np.unique(np.round(points / 0.05), axis=0) * 0.05
    marks = obstacle_kernels.marked(points[:old], points[old:], 0.05, 2000)
    assert np.allclose(marks, expected)
    few = obstacle_kernels.marked(points[:old], points[old:], 0.05, 3)
    assert np.allclose(few, expected[:3])
