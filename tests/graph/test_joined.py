"""A tick is one message each way while nobody else listens; topics return with their listeners."""

import itertools

import pytest
from geometry_msgs.msg import TwistStamped
from nav_msgs.msg import Odometry
from rclpy.serialization import deserialize_message
from sensor_msgs.msg import LaserScan
from swarm_interfaces.msg import Beacon, NeighborArray

from swarm_common.middleware.ros_io import TICK_INPUT, tick_of
from swarm_common.middleware.ros_poll import PolledTopic

KINDS = {
    "odom": Odometry,
    "scan": LaserScan,
    "neighbors": NeighborArray,
    "beacon": Beacon,
    "cmd_vel": TwistStamped,
}
ALONE = 15  # ticks without a listener
MOST_SENT = 8  # of them with a message of its own: until the graph knows who listens


@pytest.fixture(scope="module")
def swarm(start_swarm):
    started = start_swarm(2, world={"speed": 5.0})
    started.wait_until_active()
    return started


def sent(swarm, name, count):
    """Return ticks, and the sender's numbers, of messages of a topic that is heard for a while."""
    topic = PolledTopic(swarm.node, KINDS[name], f"/Srobot1/{name}", TICK_INPUT)
    found = []

    def is_enough():
        while (data := topic.take()) is not None:
            message = deserialize_message(data, KINDS[name])
            stamp = message.stamp if hasattr(message, "stamp") else message.header.stamp
            found.append((tick_of(stamp), topic.sequence))
        return len(found) >= count

    try:
        swarm.spin_until(is_enough)
    finally:
        topic.destroy()
    return found


@pytest.mark.parametrize("name", KINDS)
def test_a_topic_is_published_while_somebody_listens(swarm, name):
    """DDS numbers the messages of a publisher, so those that nobody heard show as well."""
    before = sent(swarm, name, 6)
    swarm.spin_until(lambda: swarm.sim_time() > 0.1 * (before[-1][0] + ALONE))
    after = sent(swarm, name, 6)
    per_tick = 0.5 if name == "scan" else 1.0
    for ticks, _ in (zip(*before, strict=True), zip(*after, strict=True)):
        gaps = {later - earlier for earlier, later in itertools.pairwise(ticks)}
        assert gaps - {0} == {round(1 / per_tick)}, "each tick, and again if an answer is late"
    passed, numbered = (end - start for start, end in zip(before[-1], after[0], strict=True))
    assert passed >= ALONE
    if name in ("neighbors", "cmd_vel"):  # these carry the others
        assert numbered >= passed
    else:
        assert numbered <= MOST_SENT < per_tick * passed
