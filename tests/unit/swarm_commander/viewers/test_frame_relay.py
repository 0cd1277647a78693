"""All robots' frames in one tree: renamed, and complete for those who come late."""

from typing import Any

from geometry_msgs.msg import TransformStamped
from tf2_msgs.msg import TFMessage

from swarm_commander.viewers.frame_relay import FrameRelay, frame_of


def link(parent, child, x=0.0):
    transform = TransformStamped(child_frame_id=child)
    transform.header.frame_id = parent
    transform.transform.translation.x = x
    return TFMessage(transforms=[transform])


def pairs(message):
    return [(one.header.frame_id, one.child_frame_id) for one in message.transforms]


class FakeNode:
    """A node with topics that others publish."""

    def __init__(self, *robots):
        self.robots = set(robots)
        self.sent: dict[str, list[TFMessage]] = {}
        self.takers: dict[str, Any] = {}

    def create_publisher(self, _, topic, __):
        sent = self.sent.setdefault(topic, [])
        return type("Publisher", (), {"publish": staticmethod(sent.append)})()

    def create_subscription(self, _, topic, take, __, **___):
        self.takers[topic] = take
        return topic

    def destroy_subscription(self, topic):
        del self.takers[topic]

    def get_topic_names_and_types(self):
        names = {f"/{robot}/tf" for robot in self.robots} | set(self.takers)
        return [(name, ["tf2_msgs/msg/TFMessage"]) for name in (*names, "/sim/tf", "/tf")]

    def count_publishers(self, topic):
        return int(topic.split("/")[1] in self.robots)


def relay_of(node):
    relay = FrameRelay(node)
    relay.look()
    return relay


def test_every_frame_but_map_has_the_robots_name_in_front():
    assert frame_of("Srobot3", "base_link") == "Srobot3/base_link"
    assert frame_of("Srobot3", "/odom") == "Srobot3/odom"
    assert frame_of("Srobot3", "map") == "map"


def test_what_moves_is_passed_on_with_its_values():
    node = FakeNode("Srobot1", "Srobot2")
    relay_of(node)
    node.takers["/Srobot2/tf"](link("map", "odom", 1.5))
    node.takers["/Srobot1/tf"](link("odom", "base_footprint"))
    first, second = node.sent["/tf"]
    assert pairs(first) == [("map", "Srobot2/odom")]
    assert first.transforms[0].transform.translation.x == 1.5
    assert pairs(second) == [("Srobot1/odom", "Srobot1/base_footprint")]


def test_the_last_message_has_what_is_fixed_of_all_robots():
    node = FakeNode("Srobot1", "Srobot2")
    relay_of(node)
    node.takers["/Srobot1/tf_static"](link("base_link", "base_scan"))
    node.takers["/Srobot2/tf_static"](link("base_link", "base_scan"))
    node.takers["/Srobot1/tf_static"](link("base_link", "base_scan"))
    assert sorted(pairs(node.sent["/tf_static"][-1])) == [
        ("Srobot1/base_link", "Srobot1/base_scan"),
        ("Srobot2/base_link", "Srobot2/base_scan"),
    ]


def test_robots_come_and_go():
    node = FakeNode("Srobot2")
    relay = relay_of(node)
    node.takers["/Srobot2/tf_static"](link("base_link", "base_scan"))
    node.robots = {"Srobot10", "Srobot9"}
    relay.look()
    assert relay.robots == ["Srobot9", "Srobot10"]
    assert pairs(node.sent["/tf_static"][-1]) == []
    assert set(node.takers) == {
        f"/{robot}/{topic}" for robot in node.robots for topic in ("tf", "tf_static")
    }
