"""The graph is asked after it has changed, and at no other time."""

import time

import rclpy
from rclpy.context import Context
from std_srvs.srv import Empty

from swarm_common.middleware.graph_watch import GraphWatch
from swarm_nav.ros.nav2.demand import LOOK_NAMES, LOOK_PERIOD, OnDemand
from tests.fakes.ros_domains import reserved_domain


def quiet(watch, node):
    """Wait until nothing has changed for half a second."""
    end = time.monotonic() + 20.0
    last = time.monotonic()
    while time.monotonic() - last < 0.5:
        assert time.monotonic() < end
        if watch.has_changed(node):
            last = time.monotonic()
        time.sleep(0.02)


def changes(watch, node):
    end = time.monotonic() + 20.0
    while not watch.has_changed(node):
        assert time.monotonic() < end
        time.sleep(0.02)
    return True


def test_what_another_participant_brings_and_takes_away_is_a_change():
    ours, theirs = Context(), Context()
    with reserved_domain() as domain:
        rclpy.init(context=ours, domain_id=domain)
        rclpy.init(context=theirs, domain_id=domain)
        nodes = [rclpy.create_node(name, context=ours) for name in ("one", "two")]
        other = rclpy.create_node("other", context=theirs)
        watch = GraphWatch(ours)
        quiet(watch, nodes[0])
        client = other.create_client(Empty, "/one/service")
        assert changes(watch, nodes[1])
        quiet(watch, nodes[1])
        assert nodes[0].count_clients("/one/service") == 1
        other.destroy_client(client)
        assert changes(watch, nodes[0])
        quiet(watch, nodes[0])
        nodes[0].destroy_node()  # a navigator that failed
        quiet(watch, nodes[1])
        for node in (nodes[1], other):
            node.destroy_node()
        rclpy.shutdown(context=theirs)
        rclpy.shutdown(context=ours)


class CountedNode:
    """A node that counts questions, and whose clients are given."""

    def __init__(self):
        self.asked, self.wanted = [], set()
        self.handle = self

    def __enter__(self):
        return self

    def __exit__(self, *_):
        pass

    def get_name(self):
        return "navigator"

    def get_namespace(self):
        return "/Srobot1"

    def get_count_clients(self, name):
        self.asked.append(name)
        return int(name in self.wanted)


def test_each_offer_is_asked_for_once_after_a_change():
    node = CountedNode()
    demand = OnDemand(node, is_eager=False)
    created = []
    names = [f"service_{number}" for number in range(3 * LOOK_NAMES)]
    for name in names:
        demand.offer([name], lambda name=name: created.append(name))
    times = (number * LOOK_PERIOD for number in range(100))
    for _ in range(10):
        demand.look(next(times), has_begun=True, has_changed=False)
    assert len(node.asked) == len(set(node.asked)) == len(names)  # they were new
    node.wanted = {f"/Srobot1/{names[-1]}", f"/Srobot1/{names[0]}"}
    for _ in range(10):
        demand.look(next(times), has_begun=True, has_changed=False)
    assert len(node.asked) == len(names)
    assert not created
    for number in range(10):
        demand.look(next(times), has_begun=True, has_changed=number == 0)
    assert sorted(created) == sorted([names[0], names[-1]])
    assert len(node.asked) == 2 * len(names)
