"""A process that takes part in orders: its node, its signs of life and its loop."""

from __future__ import annotations

import contextlib
import time
from collections.abc import Callable, Sequence
from typing import Any, Protocol

from rclpy.node import Node

from swarm_commander.mission.order_channel import OrderChannel
from swarm_common.middleware.rclpy_compat import SafeExecutor, join_graph
from swarm_common.middleware.rejections import Rejections
from swarm_common.middleware.ros_poll import PolledTopic, Waiter, drain
from swarm_common.process.messages import MISSION, Alive, MissionCommand
from swarm_common.process.pipes import EventWriter, StartedProcess, leave
from swarm_mission.orders.radio import OrderRadio

TURN_PERIOD = 0.05  # [s] of wall time at most between two turns, and between rare messages
MOST_TOPICS = 64  # that are waited for at once
BEAT_PERIOD = 2.0  # [s] of wall time between two signs of life


class OrderParty(Protocol):
    """Party of a process: what it decides and sends in a tick."""

    @property
    def topics(self) -> Sequence[PolledTopic]:
        """Topics that bring what the present tick lacks."""

    def turn(self) -> None:
        """Decide on each tick that may begin: hear, decide, send and report."""

    def beat(self) -> None:
        """Do what is to be done from time to time."""

    def obey(self, command: MissionCommand) -> None:
        """Obey swarm-up."""


Maker = Callable[[dict[str, Any], Node, OrderChannel, EventWriter, Rejections], OrderParty]


def run_party(about: str, kind: str, make: Maker) -> None:
    """Run the process of a party until SIGTERM.

    Args:
        kind: First part of the node's name; `number` of the configuration is the second.
    """
    child = StartedProcess(about, MISSION)
    config, events = child.config, child.events
    node = join_graph(f"{kind}_{config['number']}")
    executor = SafeExecutor()
    executor.add_node(node)
    rejections = Rejections(events, node.get_logger().warning)
    parties: dict[str, list[str]] = config["parties"]
    senders = [name for names in parties.values() for name in names]
    radio = OrderRadio(config["loss"], config["delay"], config["seed"], senders=senders)
    channel = OrderChannel(node, radio, rejections, config["party"], parties)
    party = make(config, node, channel, events, rejections)
    waiter = Waiter(node.context, MOST_TOPICS)
    beat_at = rare_at = 0.0
    with contextlib.suppress(BrokenPipeError):
        while not child.is_stopping:
            waiter.wait(party.topics, TURN_PERIOD)
            if time.monotonic() >= rare_at:
                rare_at = time.monotonic() + TURN_PERIOD
                drain(executor)
                for command in child.commands():
                    party.obey(command)
                rejections.tell(time.monotonic())
            party.turn()
            if time.monotonic() - beat_at > BEAT_PERIOD:
                beat_at = time.monotonic()
                events.write(Alive())
                party.beat()
        party.beat()
        rejections.flush()
    leave()
