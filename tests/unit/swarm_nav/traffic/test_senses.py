"""The senses: when there is enough to drive on, and when to listen anew."""

import dataclasses
import math

import numpy as np
import pytest

from swarm_common.model.beacon import BEACON_DTYPE, FLAG_ACTIVE, FLAG_SPLIT, reception_of
from swarm_common.model.records import Pose, Scan
from swarm_nav.traffic.senses import SPLIT, SPLIT_PATIENCE, Senses
from tests.fakes.navigation import robot_in, room

NOBODY = np.zeros(0, BEACON_DTYPE)


def robot():
    s = robot_in(room(8.0, 8.0), Pose(4.0, 4.0, 0.0))
    return s, Senses(s)


def scan(tick):
    return Scan(tick, 0.0, math.tau / 360, 0.12, 3.5, np.full(360, 1.0, np.float32))


def test_an_empty_batch_is_enough_but_counts_for_one_tick_only():
    s, senses = robot()
    senses.on_scan(scan(s.tick))
    assert not senses.update()
    senses.on_reception(reception_of(NOBODY))
    assert senses.update()
    assert not senses.update()


@pytest.mark.parametrize("is_longer", [False, True])
def test_after_a_long_silence_only_the_robot_listens_anew(is_longer):
    s, senses = robot()
    for _ in range(s.config.traffic.lost_ticks + is_longer):
        s.tick += 1
        senses.update()
    s.tick += 1
    senses.on_reception(reception_of(NOBODY))
    senses.update()
    assert s.listening_since == (s.tick if is_longer else 0)


def test_nothing_is_marked_before_robots_are_heard_or_once_scans_stop():
    s, senses = robot()
    s.listening_since = s.tick
    senses.on_scan(scan(s.tick))
    assert len(s.obstacles.points) == 0
    senses.on_scan(scan(s.tick + s.config.traffic.listen_ticks))
    assert len(s.obstacles.points) > 0
    s, senses = robot()
    senses.on_scan(scan(s.tick))
    timeout = s.ticks(s.config.costmap.scan_timeout)
    for wait, is_enough in ((timeout, True), (1, False)):
        s.tick += wait
        senses.on_reception(reception_of(NOBODY))
        assert senses.update() == is_enough


def test_a_lost_robot_or_one_without_a_scan_stands():
    s, senses = robot()
    s.tick += s.ticks(s.config.costmap.scan_timeout) + 1
    senses.on_reception(reception_of(NOBODY))
    assert not senses.update()
    assert "no scan" in senses.missing
    s, senses = robot()
    senses.on_scan(scan(s.tick))
    senses.on_reception(reception_of(NOBODY))
    assert not senses.update(is_lost=True)
    assert senses.missing == "stands: lost"


OWN_ID = 1


def batch(tick, *robots, flags=FLAG_ACTIVE):
    """Return what is heard of robots that stand around (4, 4)."""
    beacons = np.zeros(len(robots), BEACON_DTYPE)
    for beacon, robot in zip(beacons, robots, strict=True):
        beacon["id"], beacon["tick"], beacon["radius"], beacon["flags"] = robot, tick, 0.3, flags
        beacon["pose"] = (4.0 + 0.7 * (robot - 2), 5.5, 0.0)
        beacon["held_size"], beacon["held"][0] = 1, beacon["pose"][:2]
        beacon["heard"][0] = (OWN_ID << 16) | (tick - 1)
    return reception_of(beacons)


def hear(s, senses, ticks, *robots, **said):
    """Let robots be heard for some ticks; return what is missing then."""
    for _ in range(ticks):
        s.tick += 1
        senses.on_reception(batch(s.tick, *robots, **said))
        s.neighbors.refresh(s.tick)
        senses.update()
    return senses.missing


def blind_robot():
    s, senses = robot()
    s.config = dataclasses.replace(
        s.config, costmap=dataclasses.replace(s.config.costmap, scan_timeout=0.0)
    )
    return s, senses


def test_who_sees_nothing_stands_when_several_fall_silent_at_once():
    """A radio that was split left both sides driving: 81 contacts of 16 robots in three runs."""
    s, senses = blind_robot()
    lost = s.config.traffic.lost_ticks
    assert hear(s, senses, 30, 2, 3, 4) == ""
    assert hear(s, senses, lost + 1, 4) == SPLIT
    assert hear(s, senses, 300, 4) == SPLIT
    assert hear(s, senses, 1, 3, 4) == ""  # the radio is back


def test_those_that_stay_silent_count_as_dead_in_the_end():
    s, senses = blind_robot()
    hear(s, senses, 30, 2, 3)
    assert hear(s, senses, SPLIT_PATIENCE) == SPLIT
    assert hear(s, senses, 40) == ""


def test_one_that_falls_silent_or_robots_that_a_lidar_sees_hold_nobody_up():
    s, senses = blind_robot()
    hear(s, senses, 30, 2, 3, 4)
    assert hear(s, senses, 40, 3, 4) == ""
    assert hear(s, senses, 40, 4) == ""  # not at once
    s, senses = blind_robot()
    senses.on_scan(scan(s.tick))
    hear(s, senses, 30, 2, 3)
    assert hear(s, senses, 40) == ""


def test_who_sees_nothing_stands_while_one_that_it_hears_says_that_the_radio_is_split():
    s, senses = blind_robot()
    assert hear(s, senses, 5, 2, flags=FLAG_ACTIVE | FLAG_SPLIT) == SPLIT
    assert not senses.is_split  # it passes on only what it noticed itself: else it never ended
    assert hear(s, senses, 1, 2) == ""
