"""A costmap's topics: composed for listeners only, whole or in parts."""

from typing import Any

import numpy as np
import pytest

from swarm_nav.behaviour.costmap import changed_window
from swarm_nav.interfaces import Costmap
from swarm_nav.ros.nav2.costmaps import CostmapTopics

RAW, UPDATES, RAW_UPDATES = "costmap_raw", "costmap_updates", "costmap_raw_updates"


def costmap(*marks, origin_x=0.0):
    cells = np.zeros((4, 6), np.uint8)
    for row, column in marks:
        cells[row, column] = 254
    return Costmap(cells, 0.5, origin_x, 0.0)


class FakePublisher:
    def __init__(self):
        self.listeners = 0
        self.sent: list[Any] = []

    def get_subscription_count(self):
        return self.listeners

    def publish(self, message):
        self.sent.append(message)


class Bench:
    """The topics of one costmap on a node that is none, with listeners by topic."""

    def __init__(self, *listened):
        self.now = costmap()
        self.composed = 0
        self.publishers: dict[str, FakePublisher] = {}
        self.topics = CostmapTopics(self, "local_costmap", 2, self.compose, self)
        for name in listened:
            self.publishers[name].listeners = 1
        self.topics.poll_subscribers()

    def create_publisher(self, _, topic, __):
        return self.publishers.setdefault(topic.removeprefix("local_costmap/"), FakePublisher())

    def offer_topics(self, _, create):
        create()

    def compose(self):
        self.composed += 1
        return self.now

    def publish(self, tick, now):
        self.now = now
        self.topics.publish(tick)

    def sent(self, name):
        return self.publishers[name].sent


def test_nothing_is_composed_for_nobody_or_between_two_periods():
    bench = Bench()
    bench.publish(2, costmap())
    assert (bench.composed, bench.topics.is_wanted) == (0, False)
    bench = Bench(RAW)
    bench.publish(3, costmap())
    assert bench.composed == 0
    bench.publish(4, costmap())
    assert bench.composed == 1


@pytest.mark.parametrize("listened", ["costmap", RAW, UPDATES, RAW_UPDATES])
def test_only_what_is_listened_to_is_sent(listened):
    bench = Bench(listened)
    bench.publish(2, costmap())
    bench.publish(4, costmap((1, 2)))
    assert [name for name in bench.publishers if bench.sent(name)] == [listened]


def test_an_update_is_the_smallest_rectangle_of_what_has_changed():
    bench = Bench(UPDATES, RAW_UPDATES)
    for tick, now in (
        (2, costmap((0, 0))),
        (4, costmap((1, 2), (2, 4))),
        (6, costmap((1, 2), (2, 4))),
    ):
        bench.publish(tick, now)
    (raw,), (occupancy,) = bench.sent(RAW_UPDATES), bench.sent(UPDATES)
    assert (raw.x, raw.y, raw.size_x, raw.size_y) == (0, 0, 5, 3)
    assert list(raw.data) == [0, 0, 0, 0, 0, 0, 0, 254, 0, 0, 0, 0, 0, 0, 254]
    assert (occupancy.x, occupancy.y, occupancy.width, occupancy.height) == (0, 0, 5, 3)
    assert list(occupancy.data) == [100 if cost else 0 for cost in raw.data]
    assert raw.header.frame_id == occupancy.header.frame_id == "map"


def test_a_window_that_has_moved_is_no_update_but_the_next_change_is():
    bench = Bench(RAW_UPDATES)
    for tick, now in (
        (2, costmap((0, 0))),
        (4, costmap((1, 2), origin_x=0.5)),
        (6, costmap((1, 3), origin_x=0.5)),
    ):
        bench.publish(tick, now)
    (update,) = bench.sent(RAW_UPDATES)
    assert (update.x, update.y, update.size_x, update.size_y) == (2, 1, 2, 1)


def test_changes_are_told_of_equal_windows_that_somebody_heard_only():
    bench = Bench(RAW_UPDATES)
    bench.publish(2, costmap())
    bench.publishers[RAW_UPDATES].listeners = 0
    bench.topics.poll_subscribers()
    bench.publishers[RAW_UPDATES].listeners = 1
    bench.topics.poll_subscribers()
    bench.publish(4, costmap((1, 1)))
    assert bench.sent(RAW_UPDATES) == []
    small = Costmap(np.zeros((2, 2), np.uint8), 0.5, 0.0, 0.0)
    assert changed_window(costmap(), small) is None
    assert changed_window(costmap(), costmap()) is None
