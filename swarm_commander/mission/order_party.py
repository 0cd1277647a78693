"""A process that takes part in orders: its node, its signs of life and its loop."""

from __future__ import annotations

import contextlib
import json
import os
import signal
import time
from collections.abc import Callable
from typing import Any, Protocol

import rclpy
from rclpy.node import Node

from swarm_commander.mission.order_channel import OrderChannel
from swarm_common.middleware.rclpy_compat import SafeExecutor
from swarm_common.middleware.rejections import Rejections
from swarm_common.process.messages import MISSION, Alive, MissionCommand
from swarm_common.process.pipes import EventWriter, MessageReader, child_options
from swarm_mission.orders.radio import OrderRadio

TURN_PERIOD = 0.1  # [s] of wall time at most between two turns
BEAT_PERIOD = 2.0  # [s] of wall time between two signs of life


class OrderParty(Protocol):
    """What such a process is about."""

    def turn(self) -> None:
        """Hear, decide, send and report."""

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
    options = child_options(about)
    config = json.loads(options.config.read_text(encoding="utf-8"))
    events = EventWriter(options.event_fd)
    commands = MessageReader(options.control_fd, MISSION)
    rclpy.init(signal_handler_options=rclpy.SignalHandlerOptions.NO)
    node = rclpy.create_node(
        f"{kind}_{config['number']}", enable_rosout=False, start_parameter_services=False
    )
    stopping: list[int] = []
    signal.signal(signal.SIGTERM, lambda number, _: stopping.append(number))
    executor = SafeExecutor()
    executor.add_node(node)
    rejections = Rejections(events, node.get_logger().warning)
    radio = OrderRadio(config["loss"], config["delay"], config["seed"])
    channel = OrderChannel(node, radio, rejections)
    party = make(config, node, channel, events, rejections)
    beat_at = 0.0
    with contextlib.suppress(BrokenPipeError):
        while not stopping:
            executor.spin_once(timeout_sec=TURN_PERIOD)
            for command in commands.read():
                party.obey(command)
            party.turn()
            if time.monotonic() - beat_at > BEAT_PERIOD:
                beat_at = time.monotonic()
                events.write(Alive())
                party.beat()
            rejections.tell(time.monotonic())
        party.beat()
        rejections.flush()
    os._exit(0)  # with all of its entities at once
