"""Process of one station with orders, or of a dispatcher; it knows what it hears on `/orders`.

python -m swarm_commander.mission.station CONFIG.json --event-fd N
"""

from __future__ import annotations

import contextlib
import json
import os
import signal
import time
from typing import Any

import msgspec
import rclpy

from swarm_commander.mission.order_channel import OrderChannel
from swarm_common.files.sites_io import load_sites
from swarm_common.middleware.rclpy_compat import SafeExecutor
from swarm_common.middleware.rejections import Rejections
from swarm_common.process.messages import Alive, OrdersReported, StationDone
from swarm_common.process.pipes import EventWriter, child_options
from swarm_mission.mission import load_mission
from swarm_mission.orders.dispatch import DISPATCHER, DispatcherAgent, load_dispatcher
from swarm_mission.orders.messages import Announcement, Envelope
from swarm_mission.orders.radio import OrderRadio
from swarm_mission.orders.station_agent import StationAgent

TURN_PERIOD = 0.1  # [s] of wall time at most between two turns
BEAT_PERIOD = 2.0  # [s] of wall time between two signs of life
HELLO_PERIOD = 0.5  # [s] of wall time between two announcements before the world runs


class StationProcess:
    """The party of this process: a station, or the dispatcher."""

    def __init__(self, config: dict[str, Any], channel: OrderChannel, events: EventWriter) -> None:
        """Make the party.

        Args:
            config: As `RunPlan.station_configs` writes it.

        Raises:
            ConfigError: If the mission is unusable.
        """
        plan = load_mission(config["mission"]).with_groups(load_sites(config["sites"])).orders
        assert plan is not None
        dispatcher = load_dispatcher(plan.dispatch)
        self._name: str = config["station"]
        self._channel = channel
        self._events = events
        self._beat_at = self._hello_at = 0.0
        self._is_done = False
        self._station: StationAgent | None = None
        self._dispatcher: DispatcherAgent | None = None
        if self._name == DISPATCHER and dispatcher is not None:
            self._dispatcher = DispatcherAgent(dispatcher)
        else:
            orders = plan.orders_from(self._name, config["seed"])
            is_central = dispatcher is not None
            self._station = StationAgent(self._name, orders, awaits_dispatcher=is_central)

    def turn(self) -> None:
        """Hear, decide, send and report."""
        now, channel = time.monotonic(), self._channel
        if now - self._beat_at > BEAT_PERIOD:
            self._beat_at = now
            self._events.write(Alive())
        if channel.tick == 0:
            if self._station is not None and now - self._hello_at > HELLO_PERIOD:
                self._hello_at = now
                channel.send([Envelope(self._name, "", Announcement(self._name, ()))])
            return
        party = self._station or self._dispatcher
        assert party is not None
        for message in channel.receive([self._name])[self._name]:
            party.receive(message, channel.tick)
        channel.send(party.tick(channel.tick))
        if self._station is not None:
            self._report(self._station)

    def _report(self, station: StationAgent) -> None:
        if station.events:
            self._events.write(OrdersReported([msgspec.to_builtins(e) for e in station.events]))
            station.events.clear()
        if station.is_over and not self._is_done:
            self._is_done = True
            self._events.write(StationDone(self._name))


def main() -> None:
    """Run until SIGTERM."""
    options = child_options("A station with orders")
    config = json.loads(options.config.read_text(encoding="utf-8"))
    events = EventWriter(options.event_fd)
    rclpy.init(signal_handler_options=rclpy.SignalHandlerOptions.NO)
    number = config["number"]
    node = rclpy.create_node(
        f"station_{number}", enable_rosout=False, start_parameter_services=False
    )
    stopping: list[int] = []
    signal.signal(signal.SIGTERM, lambda signal_number, _: stopping.append(signal_number))
    executor = SafeExecutor()
    executor.add_node(node)
    rejections = Rejections(events, node.get_logger().warning)
    radio = OrderRadio(config["loss"], config["delay"], config["seed"])
    process = StationProcess(config, OrderChannel(node, radio, rejections), events)
    with contextlib.suppress(BrokenPipeError):
        while not stopping:
            executor.spin_once(timeout_sec=TURN_PERIOD)
            process.turn()
            rejections.tell(time.monotonic())
        rejections.flush()
    os._exit(0)  # with all of its entities at once


if __name__ == "__main__":
    main()
