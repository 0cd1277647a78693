"""DDS participants over which a process spreads the topics of a large swarm.

A process that discovers a DDS participant is told of all its topics, and of all of them again
whenever one is added. If the world had one participant, each of 100 navigators would be told of
1000 topics
of which it needs eleven; that costs more than all its work. So in a large swarm
(`ros_env.is_large`) the topics of each `HUB_SIZE` robots have a participant of their own, a hub,
and a navigator announces itself to the hubs it needs. Other terminals meet everybody.
"""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path

import psutil
import rclpy
from rclpy.context import Context
from rclpy.node import Node
from rclpy.parameter import Parameter
from rclpy.signals import SignalHandlerOptions

from swarm_common.middleware import ros_env
from swarm_common.middleware.ros_env import HUB_SIZE
from swarm_common.model.errors import ConfigError

REGISTRIES = 1  # where there are several hosts


def prepare(robots: int, navigators: int, profile: Path) -> bool:
    """Return whether a process needs hubs; call it before the first participant is created.

    Then the process announces itself to newcomers only: the navigators come to it.
    """
    if not ros_env.is_large(robots):
        return False
    is_alone = ros_env.bound_address() == ros_env.LOOPBACK
    others = navigators if is_alone else REGISTRIES  # else the navigators are on other hosts
    ros_env.write_profile(profile, (), ros_env.participants_of(robots, others))
    os.environ[ros_env.PROFILES] = str(profile)
    return True


class Hubs:
    """The nodes of a process by robot: its own node for a few robots, else one per hub.

    Attributes:
        gallery: For topics that no navigator needs; the navigators do not meet it.
        own_ports: Ports on which the process's own node is met.
    """

    def __init__(
        self, own: Node, robots: int, *, is_large: bool, with_gallery: bool = False
    ) -> None:
        """Create the hubs, before anybody is there to be told.

        Args:
            is_large: Result of `prepare`.
            with_gallery: Whether `gallery` is to be a participant of its own, too.
        """
        self._own = own
        self.gallery = own
        self._nodes = [own]
        self._ports: list[int] = []
        self.own_ports = sorted(_discovery_ports())
        if not is_large:
            return
        name = own.get_name()
        if with_gallery:
            self.gallery = _node(f"{name}_gallery", own)
        self._nodes = []
        for number in range(1, -(-robots // HUB_SIZE) + 1):
            before = _discovery_ports()
            self._nodes.append(_node(f"{name}_hub_{number}", own))
            self._ports += _discovery_ports() - before

    @property
    def nodes(self) -> list[Node]:
        """All nodes but `gallery`, without the process's own if there are hubs."""
        return self._nodes

    def node_of(self, robot: int) -> Node:
        """Return the node for the topics of a robot, by its index; late ones share the last."""
        return self._nodes[min(robot // HUB_SIZE, len(self._nodes) - 1)]

    def ports(self, names: Sequence[str]) -> dict[str, int]:
        """Return the port of its hub for each robot of an ordered list, none without hubs."""
        last = len(self._ports) - 1
        return {
            name: self._ports[min(robot // HUB_SIZE, last)]
            for robot, name in enumerate(names if self._ports else ())
        }

    def destroy(self) -> None:
        """Leave the graph, except with the process's own node."""
        for node in {*self._nodes, self.gallery} - {self._own}:
            context = node.context
            node.destroy_node()
            rclpy.try_shutdown(context=context)


def _node(name: str, own: Node) -> Node:
    """Return a bare node in a participant of its own."""
    context = Context()
    rclpy.init(context=context, signal_handler_options=SignalHandlerOptions.NO)
    return Node(
        name,
        namespace=own.get_namespace(),
        context=context,
        use_global_arguments=False,
        enable_rosout=False,
        start_parameter_services=False,
        parameter_overrides=[Parameter("start_type_description_service", value=False)],
    )


def _discovery_ports() -> set[int]:
    """Return the ports on which this process listens for announcements of participants.

    Raises:
        ConfigError: If it listens elsewhere than our profile says: Fast DDS has discarded the
            profile and would connect to anybody on the network.
    """
    sockets = [item.laddr for item in psutil.Process().net_connections("udp4")]
    ports = {socket.port for socket in sockets if ros_env.is_discovery_port(socket.port)}
    own = ros_env.bound_address()
    strange = [socket for socket in sockets if socket.port in ports and socket.ip != own]
    if own and strange:
        raise ConfigError(
            f"DDS listens on {strange[0].ip}:{strange[0].port} instead of {own}; it did not take"
            f" the profile {os.environ[ros_env.PROFILES]}"
        )
    return ports
