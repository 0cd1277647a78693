"""Process of one station with orders, or of a dispatcher; it knows what it hears on `/orders`.

python -m swarm_commander.mission.station CONFIG.json --event-fd N --control-fd M
"""

from __future__ import annotations

import time
from collections.abc import Sequence
from typing import Any

import msgspec

from swarm_commander.mission.order_channel import OrderChannel
from swarm_commander.mission.order_party import run_party
from swarm_common.files.sites_io import load_sites
from swarm_common.middleware.ros_poll import PolledTopic
from swarm_common.process.messages import MissionCommand, OrdersReported, StationDone
from swarm_common.process.pipes import EventWriter
from swarm_mission.mission import load_mission
from swarm_mission.orders.dispatch import DISPATCHER, DispatcherAgent, load_dispatcher
from swarm_mission.orders.station_agent import StationAgent


class StationProcess:
    """The party of this process: a station, or the dispatcher."""

    def __init__(self, config: dict[str, Any], channel: OrderChannel, events: EventWriter) -> None:
        """Make the party.

        Args:
            config: Configuration as `RunPlan.station_configs` writes it.

        Raises:
            ConfigError: If the mission is unusable.
        """
        plan = load_mission(config["mission"]).with_groups(load_sites(config["sites"])).orders
        assert plan is not None
        dispatcher = load_dispatcher(plan.dispatch)
        self._name: str = config["station"]
        self._channel = channel
        self._events = events
        self._is_done = False
        self._station: StationAgent | None = None
        self._dispatcher: DispatcherAgent | None = None
        if self._name == DISPATCHER and dispatcher is not None:
            self._dispatcher = DispatcherAgent(dispatcher)
        else:
            orders = plan.orders_from(self._name, config["seed"])
            is_central = dispatcher is not None
            self._station = StationAgent(self._name, orders, awaits_dispatcher=is_central)

    @property
    def topics(self) -> Sequence[PolledTopic]:
        """Topics that bring what the present tick lacks."""
        return self._channel.topics

    def turn(self) -> None:
        """Decide on each tick that may begin: hear, decide, send and report."""
        self._channel.poll()
        while self._channel.can_begin(time.monotonic()):
            self._decide()

    def _decide(self) -> None:
        channel = self._channel
        party = self._station or self._dispatcher
        assert party is not None
        for message in channel.receive([self._name])[self._name]:
            party.receive(message, channel.tick)
        sent = party.tick(channel.tick)
        if self._station is not None:
            self._report(self._station)
        channel.send(sent, is_over=self._station is None or self._station.is_over)
        channel.tick += 1

    def beat(self) -> None:
        """Do nothing: `turn` reports at once."""

    def obey(self, command: MissionCommand) -> None:
        """Do nothing: a station knows robots by what they say."""

    def _report(self, station: StationAgent) -> None:
        if station.events:
            self._events.write(OrdersReported([msgspec.to_builtins(e) for e in station.events]))
            station.events.clear()
        if station.is_over and not self._is_done:
            self._is_done = True
            self._events.write(StationDone(self._name))


if __name__ == "__main__":
    run_party(
        "A station with orders",
        "station",
        lambda config, node, channel, events, rejections: StationProcess(config, channel, events),
    )
