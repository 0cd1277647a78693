"""All robots' frames in one tree, on `/tf` and `/tf_static`, for one RViz of the whole swarm.

Each robot has a tree of its own, on topics in its namespace and with Nav2's names. Here every
frame but `map` gets the robot's name in front, as RViz's "TF Prefix" and robot_state_publisher's
`frame_prefix` have it: `Srobot3/base_link`. It runs as long as somebody wants it, beside the swarm,
by `swarm-commander frames` or `swarm-up --rviz merged`.
"""

from __future__ import annotations

import re
import time
from collections.abc import Callable, Iterable
from functools import partial

import rclpy
from geometry_msgs.msg import TransformStamped
from rclpy.node import Node
from rclpy.subscription import Subscription
from tf2_msgs.msg import TFMessage

from swarm_common.middleware import ros_env, ros_io
from swarm_common.middleware.rclpy_compat import SafeExecutor, removable_subscription
from swarm_common.model.robot_names import natural

NODE = "swarm_frames"
SHARED = "map"  # the frame that all trees have in common
TOPIC = re.compile(r"/(?!sim/)(\w+)/tf")  # `/sim/tf` has all robots' places
LOOK_PERIOD = 1.0  # [s] of wall time between two looks for robots that came or went
WAIT = 0.1  # [s] of wall time for a message


class FrameRelay:
    """Relays the frames of every robot that is there.

    Attributes:
        robots: Whose frames are relayed.
    """

    def __init__(self, node: Node) -> None:
        """Create the topics; `look` finds the robots."""
        self._node = node
        self._tf = node.create_publisher(TFMessage, "/tf", ros_io.TRANSFORMS)
        self._tf_static = node.create_publisher(TFMessage, "/tf_static", ros_io.STATIC_TRANSFORMS)
        self._subscriptions: dict[str, list[Subscription]] = {}
        self._fixed: dict[str, dict[str, TransformStamped]] = {}  # by robot and child frame

    @property
    def robots(self) -> list[str]:
        """Return the names of the robots, sorted, agv2 before agv10."""
        return sorted(self._subscriptions, key=natural)

    def look(self) -> None:
        """Find robots that came, and forget those that went."""
        present = set()
        for topic, _ in self._node.get_topic_names_and_types():
            match = TOPIC.fullmatch(topic)
            if match and self._node.count_publishers(topic):
                present.add(match[1])
        for robot in present - self._subscriptions.keys():
            self._subscriptions[robot] = self._listen(robot)
        for robot in self._subscriptions.keys() - present:
            for subscription in self._subscriptions.pop(robot):
                self._node.destroy_subscription(subscription)
            if self._fixed.pop(robot, None):
                self._publish_fixed()

    def _listen(self, robot: str) -> list[Subscription]:
        make = partial(removable_subscription, self._node)
        moving, fixed = partial(self._relay, robot), partial(self._relay_fixed, robot)
        return [
            make(TFMessage, f"/{robot}/tf", moving, ros_io.TRANSFORMS),
            make(TFMessage, f"/{robot}/tf_static", fixed, ros_io.STATIC_TRANSFORMS),
        ]

    def _relay(self, robot: str, message: TFMessage) -> None:
        self._tf.publish(TFMessage(transforms=prefixed(robot, message.transforms)))

    def _relay_fixed(self, robot: str, message: TFMessage) -> None:
        """Publish what is fixed of all robots: a latecomer gets the last message only."""
        frames = self._fixed.setdefault(robot, {})
        for transform in prefixed(robot, message.transforms):
            frames[transform.child_frame_id] = transform
        self._publish_fixed()

    def _publish_fixed(self) -> None:
        transforms = [one for frames in self._fixed.values() for one in frames.values()]
        self._tf_static.publish(TFMessage(transforms=transforms))


def prefixed(robot: str, transforms: Iterable[TransformStamped]) -> list[TransformStamped]:
    """Return transforms with the robot's name in front of every frame but `map`."""
    relayed = list(transforms)
    for transform in relayed:
        transform.header.frame_id = frame_of(robot, transform.header.frame_id)
        transform.child_frame_id = frame_of(robot, transform.child_frame_id)
    return relayed


def frame_of(robot: str, frame: str) -> str:
    """Return the name of a robot's frame in the tree of all."""
    name = frame.removeprefix("/")
    return name if name == SHARED else f"{robot}/{name}"


def relay_frames(node: Node, tell: Callable[[list[str]], None]) -> None:
    """Relay all frames until the process is ended.

    Args:
        tell: Called with the names of the robots, at first and when they have changed.
    """
    relay = FrameRelay(node)
    executor = SafeExecutor(context=node.context)
    executor.add_node(node)
    due, told = 0.0, None
    while node.context.ok():
        if time.monotonic() >= due:
            due = time.monotonic() + LOOK_PERIOD
            relay.look()
            if relay.robots != told:
                told = relay.robots
                tell(told)
        executor.spin_once(timeout_sec=WAIT)


def main() -> None:
    """Relay until a signal ends it; for `swarm-up --rviz merged`."""
    ros_env.set_defaults()
    rclpy.init()
    node = rclpy.create_node(NODE, enable_rosout=False, start_parameter_services=False)
    relay_frames(node, lambda robots: node.get_logger().info(f"frames of {', '.join(robots)}"))


if __name__ == "__main__":
    main()
