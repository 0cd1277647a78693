"""Caution around people, and which marks may be somebody who walks on."""

import dataclasses
import math

import numpy as np
import pytest

from swarm_common.model.records import LidarSpec, Pose, Scan, Twist
from swarm_nav.behaviour.rules import CheckProgress
from swarm_nav.core.config import CostmapConfig
from swarm_nav.perception.dynamic_obstacles import CAME_TICKS, MOVER_TICKS, STILL_TICKS
from swarm_nav.perception.obstacles import ObstacleLayer
from swarm_nav.traffic.speed_near_people import (
    CREEP_SPEED,
    NOBODY_NEAR,
    People,
    caution_distance,
    cautious_speed,
    people_near,
    slow_near_people,
)
from tests.fakes.navigation import Squad, robot_in, room

HALL = room(8.0, 8.0)
MIDDLE = Pose(4.0, 4.0, 0.0)
LIDAR = LidarSpec(0.0, 0.0, 0.1)
SCAN_TICKS = 2


def ranges_to(x, y, radius, pose=MIDDLE):
    """Return what 360 rays measure of a disc."""
    ranges = np.full(360, np.inf, np.float32)
    dx, dy = x - pose.x, y - pose.y
    for ray in range(360):
        angle = pose.yaw + math.radians(ray)
        along = dx * math.cos(angle) + dy * math.sin(angle)
        aside = dy * math.cos(angle) - dx * math.sin(angle)
        if along > 0.0 and abs(aside) < radius:
            ranges[ray] = along - math.sqrt(radius**2 - aside**2)
    return ranges


def watch(s, layer, tick, x, y):
    """See a person at (x, y) in a tick; return how near something restless is then."""
    scan = Scan(tick, 0.0, math.tau / 360, 0.12, 3.5, ranges_to(x, y, 0.25))
    layer.update(scan, MIDDLE, s.terrain, s.neighbors)
    return layer.restless_gap(MIDDLE.x, MIDDLE.y, tick)


def test_who_walks_or_was_seen_moving_stays_restless():
    s, layer = robot_in(HALL, MIDDLE), ObstacleLayer(CostmapConfig(), LIDAR)
    for tick in range(0, 20, SCAN_TICKS):  # walks past at 0.8 m/s and stops
        watch(s, layer, tick, 5.5, 3.0 + 0.08 * tick)
    gaps = [watch(s, layer, t, 5.5, 4.5) for t in range(20, 4 * STILL_TICKS, SCAN_TICKS)]
    assert all(math.isfinite(gap) for gap in gaps)
    assert math.isfinite(layer.restless_gap(MIDDLE.x, MIDDLE.y, MOVER_TICKS - 1))
    assert math.isinf(layer.restless_gap(MIDDLE.x, MIDDLE.y, MOVER_TICKS + 4 * STILL_TICKS))
    s, layer = robot_in(HALL, MIDDLE), ObstacleLayer(CostmapConfig(), LIDAR)
    for tick in range(0, 24, SCAN_TICKS):
        x = 6.4 - 0.08 * tick
        assert watch(s, layer, tick, x, 4.0) == pytest.approx(x - 4.0 - 0.25, abs=0.06)


def test_what_comes_from_nowhere_and_stands_is_a_thing_sooner():
    """More of it is seen all the time, as the robot creeps past: that belongs to it."""
    s, layer = robot_in(HALL, MIDDLE), ObstacleLayer(CostmapConfig(), LIDAR)
    for tick in range(0, 20, SCAN_TICKS):
        watch(s, layer, tick, 20.0, 20.0)
    gaps = {}
    for tick in range(20, 20 + CAME_TICKS + 20, SCAN_TICKS):
        ranges = ranges_to(5.5, 4.0, 0.1 + 0.15 * (tick - 20) / CAME_TICKS)
        scan = Scan(tick, 0.0, math.tau / 360, 0.12, 3.5, ranges)
        layer.update(scan, MIDDLE, s.terrain, s.neighbors)
        gaps[tick] = layer.restless_gap(MIDDLE.x, MIDDLE.y, tick)
    assert all(math.isfinite(gap) for tick, gap in gaps.items() if tick < 20 + CAME_TICKS)
    assert math.isinf(gaps[20 + CAME_TICKS + 18])


def test_a_thing_does_not_become_a_person_because_one_walks_past():
    s, layer = robot_in(HALL, MIDDLE), ObstacleLayer(CostmapConfig(), LIDAR)
    box = ranges_to(5.2, 4.0, 0.2)

    def see(tick, y):
        ranges = np.minimum(box, ranges_to(5.75, y, 0.25))
        layer.update(
            Scan(tick, 0.0, math.tau / 360, 0.12, 3.5, ranges), MIDDLE, s.terrain, s.neighbors
        )

    for tick in range(0, STILL_TICKS + 10, SCAN_TICKS):
        see(tick, 20.0)
    for tick in range(STILL_TICKS + 10, STILL_TICKS + 40, SCAN_TICKS):
        see(tick, 2.6 + 0.08 * (tick - STILL_TICKS - 10))
        assert layer.restless_gap(5.0, 4.0, tick) > 0.2


def test_nothing_seen_is_nobody_and_a_thing_is_restless_at_first():
    layer = ObstacleLayer(CostmapConfig(), LIDAR)
    assert layer.restless_gap(0.0, 0.0, 5) == math.inf
    layer.clear()
    assert layer.restless_gap(0.0, 0.0, 5) == math.inf
    s, layer = robot_in(HALL, MIDDLE), ObstacleLayer(CostmapConfig(), LIDAR)
    gaps = {tick: watch(s, layer, tick, 5.5, 4.0) for tick in range(0, 200, SCAN_TICKS)}
    assert gaps[0] == pytest.approx(1.25, abs=0.05)
    assert math.isfinite(gaps[STILL_TICKS - SCAN_TICKS])
    assert all(math.isinf(gap) for tick, gap in gaps.items() if tick >= STILL_TICKS)


@pytest.mark.parametrize("speed", [0.01, 0.05, 0.1, 0.26])
def test_speed_and_distance_are_inverse(speed):
    assert cautious_speed(caution_distance(speed, 1.0), 1.0) == pytest.approx(speed)
    assert cautious_speed(caution_distance(0.0, 1.0) - 0.01, 1.0) == 0.0


def test_who_has_walked_out_of_sight_is_forgotten():
    s, layer = robot_in(HALL, MIDDLE), ObstacleLayer(CostmapConfig(), LIDAR)
    for tick in range(0, 20, SCAN_TICKS):
        watch(s, layer, tick, 5.5, 3.0 + 0.08 * tick)
    assert len(layer.points)
    blind = Scan(0, 0.0, math.tau / 360, 0.12, 3.5, np.full(360, 0.5, np.float32))
    for tick in range(20, 60, SCAN_TICKS):  # something stands in front of it all around
        layer.update(dataclasses.replace(blind, tick=tick), MIDDLE, s.terrain, s.neighbors)
    assert np.hypot(*(layer.points - (4.0, 4.0)).T).max() < 0.6


@pytest.mark.parametrize("walking", [0.6, 0.8, 1.0])
@pytest.mark.parametrize("phase", [0.0, 0.05, 0.1, 0.15, 0.199])
def test_a_robot_stands_before_a_person_who_comes_at_it_is_there(walking, phase):
    """Head on: sees at 5 Hz, brakes at 1 m/s², is slower than 0.02 m/s before the contact."""
    speed, brakes, step = 0.26, 1.0, 0.01
    gap = 3.0
    v, is_braking, next_scan = speed, False, phase
    time = 0.0
    while v >= 0.02:
        if time >= next_scan - 1e-9:
            next_scan += 0.2
            is_braking |= gap < caution_distance(speed, brakes)
        if is_braking:
            v = max(0.0, v - brakes * step)
        gap -= (walking + v) * step
        time += step
        assert gap > 0.0


def test_near_somebody_the_robot_creeps_and_turns_or_does_nothing():
    s = robot_in(HALL, MIDDLE)
    drive = Twist(0.2, 0.0, 0.4)
    config = s.config.controller
    assert people_near(s) == NOBODY_NEAR
    assert slow_near_people(drive, NOBODY_NEAR, config) == drive
    body = s.body_radius
    for gap, expected in (
        (1.5, drive),
        (0.3, Twist(CREEP_SPEED, 0.0, 0.4 * CREEP_SPEED / 0.2)),
        (0.01, Twist()),
    ):
        s.obstacles.clear()
        watch(s, s.obstacles, s.tick, MIDDLE.x + 0.25 + body + gap + 0.025, MIDDLE.y)
        people = people_near(s)
        found = slow_near_people(drive, people, config)
        assert found.vx == pytest.approx(expected.vx)
        assert found.wz == pytest.approx(expected.wz)
        assert people.gap == pytest.approx(gap, abs=0.05)
        assert people.is_near == (gap < 1.0)
        turn = Twist(0.0, 0.0, 1.0)
        assert slow_near_people(turn, people, config) == (turn if gap > 0.1 else Twist())


def test_who_walks_by_again_and_again_excuses_a_stuck_robot_only_while_it_is_near():
    """A robot before a crate never tried a recovery while a person paced beside it."""
    one = Squad(HALL, [MIDDLE])
    one.send(0, Pose(7.4, 4.0, 0.0))
    one.run(60)
    robot = one.robots[0]
    s, task = robot._s, robot._goal_manager.task
    s.blocked_ticks, s.is_unconfirmed = 0, False
    allowance = s.ticks(s.config.progress_checker.movement_time_allowance)
    task.record_progress(s, True)
    check = CheckProgress(robot._parts)
    alone = 0
    for _ in range(4 * allowance):
        s.tick += 1
        is_near = s.tick % 50 < 30
        alone += not is_near
        robot._parts.people = People(0.0, is_near)
        (event,) = check.propose(s).events
        robot._goal_manager.apply(event)
        assert task.recoveries == (alone > allowance)
        if task.recoveries:
            return
    pytest.fail("it never tried anything else")
