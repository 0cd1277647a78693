"""Servers and topics that exist only once somebody looks for them, or that come after the start.

Nine of a navigator's ten action servers and most of its services are used by few robots of a large
swarm, and never by most. Each of them costs every process that knows the robot, so that announcing
them all takes longer than everything else when a large swarm starts. What is wanted shows in the
graph: a client announces itself, and then waits until its server is there. The graph is asked only
after it has changed.

In a small swarm they all come, subscriptions at once, the others one after the other once the swarm
has begun, as together they take as long as all the rest of a robot's start.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

from rclpy.expand_topic_name import expand_topic_name
from rclpy.node import Node

LOOK_PERIOD = 0.5  # [s] of wall time between two looks for clients
LOOK_NAMES = 24  # names of which one look counts the clients; the others have the next turns
START_TIME = 10.0  # [s] of wall time after which a swarm that has not begun is not waited for


@dataclass(slots=True)
class Offer:
    """A thing that can be created, and the services or topics that its clients look for."""

    names: Sequence[str]
    create: Callable[[], object]
    count: str = "clients"  # or subscribers, publishers: who asks for it


class _Queue(deque[Offer]):
    """Offers whose clients are counted in portions; the front is next."""

    unseen = 0  # offers at the front that were not counted since the graph changed

    def take_wanted(self, has_client: Callable[[Offer], bool]) -> Iterator[Offer]:
        """Count the clients of a portion, and take out the offers that have some."""
        looked = 0
        while self.unseen and looked < LOOK_NAMES:
            offer = self.popleft()
            self.unseen -= 1
            looked += len(offer.names)
            if has_client(offer):
                yield offer
            else:
                self.append(offer)


class OnDemand:
    """Creates what is offered when its first client appears, or soon after the start."""

    def __init__(self, node: Node, is_eager: bool) -> None:
        """Start without offers.

        Args:
            is_eager: Whether all but rare offers come without a client, soon after the start.
        """
        self._node = node
        self._is_eager = is_eager
        self._soon = _Queue()  # come in any case
        self._offers = _Queue()  # come with a client
        self._due = 0.0
        self._is_new = False  # there is an offer since the last look
        self._started: float | None = None

    def offer(
        self, services: Sequence[str], create: Callable[[], object], *, is_rare: bool = False
    ) -> None:
        """Offer something.

        Args:
            services: Names, relative to the node's namespace, of which a client asks for it.
            is_rare: Whether it needs a client in a small swarm, too.
        """
        self._add(Offer(self._full(services), create), is_rare)

    def offer_topics(self, topics: Sequence[str], create: Callable[[], object]) -> None:
        """Offer publishers of topics, which come together; see `offer`.

        Args:
            topics: Names, relative to the node's namespace, of which a subscriber asks for them.
        """
        self._add(Offer(self._full(topics), create, "subscribers"), False)

    def offer_input(
        self, topic: str, create: Callable[[], object], *, is_rare: bool = False
    ) -> None:
        """Offer a subscription of a topic, before all offers so far; in a small swarm it comes now.

        What forbids places or speeds has to be known before a goal is, also after a restart.

        Args:
            topic: Name, relative to the node's namespace, of which a publisher asks for it.
            is_rare: Whether it needs a publisher in a small swarm, too.
        """
        if self._is_eager and not is_rare:
            create()
        else:
            self._offers.appendleft(Offer(self._full([topic]), create, "publishers"))
            self._is_new = True

    def _full(self, names: Sequence[str]) -> list[str]:
        name, space = self._node.get_name(), self._node.get_namespace()
        return [expand_topic_name(relative, name, space) for relative in names]

    def _add(self, offer: Offer, is_rare: bool) -> None:
        (self._soon if self._is_eager and not is_rare else self._offers).append(offer)
        self._is_new = True

    def offer_actions(
        self, names: Sequence[str], create: Callable[[], object], *, is_rare: bool = False
    ) -> None:
        """Offer action servers, which come together; see `offer`.

        Args:
            names: Names of the actions, relative to the node's namespace.
            is_rare: Whether they need a client in a small swarm, too.
        """
        self.offer([f"{name}/_action/send_goal" for name in names], create, is_rare=is_rare)

    def look(self, now: float, *, has_begun: bool, has_changed: bool) -> None:
        """Create the next offer that needs no client, or what has got one.

        Args:
            now: [s] of wall time.
            has_begun: Whether all robots of the swarm are there.
            has_changed: Whether the graph has changed since the last look.
        """
        if has_changed or self._is_new:
            self._is_new = False
            for offers in (self._soon, self._offers):
                offers.unseen = len(offers)
        if self._started is None:
            self._started = now
        if self._soon and (has_begun or now - self._started > START_TIME):
            self._soon.popleft().create()
            self._soon.unseen = max(0, self._soon.unseen - 1)
            return
        if now < self._due:
            return
        self._due = now + LOOK_PERIOD
        for offers in (self._soon, self._offers):
            for offer in offers.take_wanted(self._has_client):
                offer.create()

    def _has_client(self, offer: Offer) -> bool:
        with self._node.handle:
            count = getattr(self._node.handle, f"get_count_{offer.count}")
            return any(count(name) for name in offer.names)
