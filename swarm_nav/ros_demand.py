"""Servers that exist only once somebody looks for them.

Nine of a navigator's ten action servers and most of its services are used by few robots of a large
swarm, and never by most. Each of them costs every process that knows the robot, so that announcing
them all takes longer than everything else when a large swarm starts. What is wanted shows in the
graph: a client announces itself, and then waits until its server is there.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from rclpy.expand_topic_name import expand_topic_name
from rclpy.node import Node

LOOK_PERIOD = 0.5  # [s] of wall time between two looks for clients


@dataclass(slots=True)
class Offer:
    """What can be created, and the services that its clients look for."""

    services: Sequence[str]
    create: Callable[[], object]


class OnDemand:
    """Creates what is offered when its first client appears, or at once."""

    def __init__(self, node: Node, is_eager: bool) -> None:
        """Take the node to look from; an eager one creates at once."""
        self._node = node
        self._is_eager = is_eager
        self._offers: list[Offer] = []
        self._due = 0.0

    def offer(self, services: Sequence[str], create: Callable[[], object]) -> None:
        """Offer something.

        Args:
            services: Names, relative to the node's namespace, of which a client asks for it.
            create: Called once, when it is wanted.
        """
        if self._is_eager:
            create()
            return
        name, space = self._node.get_name(), self._node.get_namespace()
        full = [expand_topic_name(service, name, space) for service in services]
        self._offers.append(Offer(full, create))

    def offer_action(self, name: str, create: Callable[[], object]) -> None:
        """Offer an action server."""
        self.offer([f"{name}/_action/send_goal"], create)

    def look(self, now: float) -> None:
        """Create what has got a client; `now` is wall time."""
        if not self._offers or now < self._due:
            return
        self._due = now + LOOK_PERIOD
        wanted = [offer for offer in self._offers if self._has_client(offer)]
        for offer in wanted:
            self._offers.remove(offer)
            offer.create()

    def _has_client(self, offer: Offer) -> bool:
        with self._node.handle:
            count = self._node.handle.get_count_clients
            return any(count(service) for service in offer.services)
