"""Whose messages of a topic count: the rightful node's, or whoever came first without one."""

import time
from collections import Counter

import pytest
import rclpy
from rclpy.context import Context
from std_msgs.msg import String

from swarm_common.middleware.ros_io import RELIABLE
from swarm_common.middleware.ros_poll import SoleTopic
from tests.fakes.ros_domains import reserved_domain

TOPIC = "/Srobot1/cmd_vel"
RIGHTFUL = "/Srobot1/navigator"


class Place:
    """A topic, its listener, and publishers by the names of their nodes."""

    def __init__(self, domain, is_shared):
        self.context = Context()
        rclpy.init(context=self.context, domain_id=domain)
        self._nodes = [self._make("/world")]
        self.ignored: Counter[str] = Counter()
        self.topic = SoleTopic(
            self._nodes[0],
            String,
            TOPIC,
            RELIABLE,
            lambda who: who == RIGHTFUL or (is_shared and who.startswith("/Srobot1/")),
            lambda who: self.ignored.update([who]),
            is_shared=is_shared,
        )

    def _make(self, name):
        space, _, node = name.rpartition("/")
        return rclpy.create_node(
            node, namespace=space or "/", context=self.context, enable_rosout=False
        )

    def publisher(self, name):
        node = self._make(name)
        self._nodes.append(node)
        publisher = node.create_publisher(String, TOPIC, RELIABLE)
        end = time.monotonic() + 20.0
        while publisher.get_subscription_count() == 0 or self._is_unknown(name):
            assert time.monotonic() < end
            time.sleep(0.05)
        return publisher

    def _is_unknown(self, name):
        known = self._nodes[0].get_publishers_info_by_topic(TOPIC)
        return name.rpartition("/")[2] not in [info.node_name for info in known]

    def heard(self, publisher, text):
        """Whether a message of a publisher comes through."""
        publisher.publish(String(data=text))
        time.sleep(0.3)
        taken = []
        while (data := self.topic.take()) is not None:
            taken.append(data)
        return any(text.encode() in data for data in taken)

    def leave(self, publisher):
        node = next(node for node in self._nodes if publisher in node.publishers)
        node.destroy_node()
        self._nodes.remove(node)
        time.sleep(0.5)

    def close(self):
        self.topic.destroy()
        for node in self._nodes:
            node.destroy_node()
        self.context.try_shutdown()


@pytest.fixture
def domain():
    with reserved_domain() as number:
        yield number


@pytest.fixture
def place(domain):
    found = Place(domain, is_shared=False)
    yield found
    found.close()


def test_without_a_rightful_node_the_first_counts_until_it_leaves(place):
    first, second = place.publisher("/somebody"), place.publisher("/somebody_else")
    assert place.heard(first, "one")
    assert not place.heard(second, "two")
    assert place.ignored == {"/somebody_else": 1}
    assert place.heard(first, "three")
    place.leave(first)
    time.sleep(1.0)
    assert place.heard(second, "four")


def test_the_rightful_node_takes_the_place_of_any_other_for_good(place):
    stranger = place.publisher("/stranger")
    assert place.heard(stranger, "one")
    navigator = place.publisher(RIGHTFUL)
    assert place.heard(navigator, "two")
    assert not place.heard(stranger, "three")
    place.leave(navigator)
    time.sleep(1.5)
    assert not place.heard(stranger, "four")
    assert place.ignored["/stranger"] == 2


def test_a_navigator_started_anew_takes_the_place_of_one_that_is_silent(place):
    old, new = place.publisher(RIGHTFUL), place.publisher(RIGHTFUL)
    assert place.heard(old, "one")
    assert not place.heard(new, "two")  # DDS lists both; the old one has just spoken
    time.sleep(2.5)
    assert place.heard(new, "three")
    assert not place.heard(old, "four")
    assert not place.ignored, "a restart is nobody's forgery"


def test_a_navigator_started_anew_is_heard_soon_and_not_reported_however_often_it_speaks(place):
    old, new = place.publisher(RIGHTFUL), place.publisher(RIGHTFUL)
    assert place.heard(old, "one")
    end = time.monotonic() + 4.0
    while not place.heard(new, "two"):
        assert time.monotonic() < end, "the old one does not speak any more"
    assert not place.ignored


def test_two_navigators_of_a_robot_that_both_go_on_are_reported(place):
    first, second = place.publisher(RIGHTFUL), place.publisher(RIGHTFUL)
    for number in range(4):
        assert place.heard(first, f"a{number}")
        assert not place.heard(second, f"b{number}")
    assert place.ignored[RIGHTFUL] > 0


def test_in_free_run_all_nodes_of_the_robot_count_and_no_others(domain):
    place = Place(domain, is_shared=True)
    smoother, behaviors = (
        place.publisher(f"/Srobot1/{name}") for name in ("velocity_smoother", "behavior_server")
    )
    stranger = place.publisher("/stranger")
    assert place.heard(smoother, "one")
    assert place.heard(behaviors, "two")
    assert place.heard(smoother, "three")
    assert not place.heard(stranger, "four")
    place.close()
