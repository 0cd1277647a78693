import itertools

import numpy as np
import pytest

from swarm_common.model.battery import BatteryReading, SupplyStatus
from swarm_common.model.beacon import empty_beacons
from swarm_common.model.records import Odometry, Pose, Scan, Twist
from swarm_nav.ros.inputs import MAX_OPEN, TickInputs


def odom(tick):
    return Odometry(tick, Pose(0.0, 0.0, 0.0), Twist())


def scan(tick):
    return Scan(tick, 0.0, 0.1, 0.1, 3.5, np.zeros(3, np.float32))


def feed(inputs, tick, parts):
    takers = {
        "odom": lambda: inputs.add_odom(odom(tick)),
        "scan": lambda: inputs.add_scan(scan(tick)),
        "neighbors": lambda: inputs.add_neighbors(tick, empty_beacons(0)),
    }
    return [takers[part]() for part in parts]


@pytest.mark.parametrize("order", list(itertools.permutations(["odom", "scan", "neighbors"])))
def test_a_tick_is_complete_with_its_last_part_in_any_order(order):
    first, second, third = feed(TickInputs(2), 4, order)
    assert first is second is None
    assert third.tick == 4
    assert third.scan is not None


def test_a_tick_waits_for_what_its_robot_has():
    answers = feed(TickInputs(2), 3, ["odom", "neighbors"])
    assert answers[1].scan is None
    assert feed(TickInputs(1), 3, ["odom", "neighbors"]) == [None, None]
    for tick in range(3):
        assert feed(TickInputs(0), tick, ["odom", "neighbors"])[1].tick == tick
    inputs = TickInputs(0, has_battery=True)
    assert feed(inputs, 9, ["odom", "neighbors"])[1].battery is None
    assert feed(inputs, 10, ["odom", "neighbors"]) == [None, None]
    assert inputs.missing == "battery_state"
    reading = BatteryReading(10, 0.5, -6.0, SupplyStatus.DISCHARGING)
    assert inputs.add_battery(reading).battery is reading


def test_what_was_lost_or_comes_twice_is_dropped():
    inputs = TickInputs(2)
    assert feed(inputs, 1, ["odom", "neighbors"])[1] is not None
    assert inputs.is_repeat(1)
    assert feed(inputs, 1, ["odom", "neighbors"]) == [None, None]
    inputs = TickInputs(2)
    feed(inputs, 1, ["odom"])
    assert feed(inputs, 3, ["odom", "neighbors"])[1].tick == 3
    assert feed(inputs, 1, ["neighbors"]) == [None]
    inputs = TickInputs(2)
    for tick in range(3 * MAX_OPEN):
        inputs.add_odom(odom(tick))
    assert feed(inputs, MAX_OPEN - 1, ["neighbors"]) == [None]
    assert feed(inputs, 3 * MAX_OPEN - 1, ["neighbors"])[0].tick == 3 * MAX_OPEN - 1


@pytest.mark.parametrize("order", list(itertools.permutations(["odom", "scan", "neighbors"])))
def test_what_is_waited_for_is_always_something_that_is_missing(order):
    """Waiting for `neighbors` that were overtaken cost 0.2 s a tick."""
    inputs = TickInputs(2)
    for tick in (2, 4):
        assert inputs.missing == "neighbors"  # which comes last
        there = set()
        for part in order:
            assert inputs.missing not in there
            feed(inputs, tick, [part])
            there.add(part)


def test_of_several_ticks_the_newest_counts():
    inputs = TickInputs(2)
    feed(inputs, 3, ["neighbors"])
    assert inputs.missing == "odom"
    feed(inputs, 4, ["odom", "neighbors"])
    assert inputs.missing == "scan"
    feed(inputs, 5, ["odom"])
    assert inputs.missing == "neighbors"
