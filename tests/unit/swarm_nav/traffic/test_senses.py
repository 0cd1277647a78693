"""The senses: when there is enough to drive on, and when to listen anew."""

import math

import numpy as np
import pytest

from swarm_common.model.beacon import BEACON_DTYPE, reception_of
from swarm_common.model.records import Pose, Scan
from swarm_nav.traffic.senses import Senses
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
