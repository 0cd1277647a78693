"""A node of our own that looks at the graph without joining in more than it must."""

from __future__ import annotations

import contextlib
import os
import signal
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from types import FrameType
from typing import TypeVar

import rclpy
import rclpy.executors
from rclpy.node import Node
from rclpy.parameter import Parameter
from rclpy.signals import SignalHandlerOptions

from swarm_common.model.errors import SwarmError
from swarm_common.model.robot_names import natural

NamesAndTypes = list[tuple[str, list[str]]]
Facts = TypeVar("Facts")

PREFIX = "_ros2cli"
POLL = 0.02  # [s]
QUIET = 0.3  # [s] without news after which the graph counts as known
QUIET_PER_NODE = 0.01  # [s] more for each node in the graph
LEAST = 1.3  # [s] before that: every participant announces itself once a second
LONGEST = 60.0  # [s] while there is news: 100 robots on a busy machine
MOST = 5.0  # [s] to wait for something; Fast DDS by itself announces every 3 s
NODES_TOPIC = "ros_discovery_info"  # on which each participant says which nodes it has
SOCKETS = Path("/proc/net/udp")  # of this host, see proc(5)
FIRST_PORT, PORTS = 7400, 250  # of domain 0, and for each domain
UNICAST = 10  # port of a domain for the discovery of its first participant; two each
UNKNOWN_NODE = "_NODE_NAME_UNKNOWN_"  # of an endpoint that is known before its node is


@contextlib.contextmanager
def open_node(name: str | None = None, *, sim_time: bool = False) -> Iterator[Node]:
    """Create a node, hidden unless named, without parameter services and without a log topic.

    With `sim_time` its clock is `/clock`.
    """
    context = rclpy.Context()
    rclpy.init(context=context, signal_handler_options=SignalHandlerOptions.NO)
    node = Node(
        name or f"{PREFIX}_{os.getpid()}",
        context=context,
        enable_rosout=False,
        start_parameter_services=False,
        parameter_overrides=[Parameter("use_sim_time", value=sim_time)],
    )
    try:
        yield node
    finally:
        node.destroy_node()
        context.try_shutdown()


def settle(node: Node) -> None:
    """Wait until discovery brings nothing new."""
    settled(node, lambda: (node.get_topic_names_and_types(), node_names(node, hidden=True)))


def settled(
    node: Node, read: Callable[[], Facts], is_whole: Callable[[Facts], bool] = lambda _: True
) -> Facts:
    """Return the state of the graph once it stays the same and `is_whole`.

    Topics, endpoints and nodes of one participant become known one after the other, on a busy
    machine with gaps.
    """
    start = changed = time.monotonic()
    facts = read()
    while True:
        time.sleep(POLL)
        now = time.monotonic()
        if (news := read()) != facts:
            facts, changed = news, now
        is_quiet = now - changed > QUIET + QUIET_PER_NODE * len(node.get_node_names())
        is_calm = now - start > LEAST and is_quiet and _knows_nodes(node) and is_whole(facts)
        is_late = now - start > (MOST if is_quiet else LONGEST)
        if is_calm or is_late:
            return facts


def _knows_nodes(node: Node) -> bool:
    publishers = node.get_publishers_info_by_topic(NODES_TOPIC, no_mangle=True)
    least = max(2, participants_here(node.context.get_domain_id()))
    return least <= len(publishers) <= len(node.get_node_names())


def participants_here(domain: int) -> int:
    """Return how many participants this host has in a domain, by the ports that they listen on.

    Each takes the next free port for discovery, see the RTPS specification, 9.6.2.3. On a busy
    machine one that runs may need longer to announce itself than any quiet time.
    """
    first = FIRST_PORT + PORTS * domain
    found = set()
    with contextlib.suppress(OSError):
        for line in SOCKETS.read_text(encoding="utf-8").splitlines()[1:]:
            offset = int(line.split()[1].rpartition(":")[2], 16) - first
            if UNICAST <= offset < PORTS and not offset % 2:
                found.add(offset)
    return len(found)


def wait_for(condition: Callable[[], bool], timeout: float = MOST) -> bool:
    """Wait until a condition holds; return whether it does."""
    is_late = deadline(timeout)
    while not condition():
        if is_late():
            return False
        time.sleep(POLL)
    return True


def deadline(seconds: float) -> Callable[[], bool]:
    """Return a condition that holds once some time has passed."""
    end = time.monotonic() + seconds
    return lambda: time.monotonic() > end


INTERRUPTS: list[int] = []  # signals so far, beside the exception, which rclpy may swallow


def watch_interrupts() -> None:
    """Record Ctrl-C from now on."""

    def record(number: int, _: FrameType | None) -> None:
        INTERRUPTS.append(number)
        raise KeyboardInterrupt

    signal.signal(signal.SIGINT, record)


def spin(node: Node, until: Callable[[], bool]) -> None:
    """Serve a node's callbacks until a condition holds."""
    executor = rclpy.executors.SingleThreadedExecutor(context=node.context)
    executor.add_node(node)
    try:
        while not until():
            if INTERRUPTS:
                raise KeyboardInterrupt
            executor.spin_once(timeout_sec=0.1)
    finally:
        executor.remove_node(node)
        executor.shutdown(timeout_sec=0)


def is_hidden(name: str) -> bool:
    """Tell whether a name has a part that starts with an underscore."""
    return any(part.startswith("_") for part in name.split("/"))


def visible(rows: NamesAndTypes, *, hidden: bool) -> NamesAndTypes:
    """Return the rows that are shown: all of them, or those whose names are not hidden."""
    return [(name, types) for name, types in rows if hidden or not is_hidden(name)]


def absolute(name: str) -> str:
    """Return a topic, service, action or node name with a leading slash."""
    return name if name.startswith("/") else f"/{name}"


def topic_type(node: Node, topic: str, timeout: float = MOST) -> str | None:
    """Return the type of a topic, None if nobody is known to use it in time."""
    return _type_of(topic, lambda: node.get_topic_names_and_types(), timeout)


def service_type(node: Node, service: str) -> str | None:
    """Return the type of a service, None if nobody is known to offer it in time."""
    return _type_of(service, lambda: node.get_service_names_and_types(), MOST)


def _type_of(name: str, listing: Callable[[], NamesAndTypes], timeout: float) -> str | None:
    types: list[str] = []

    def is_known() -> bool:
        types[:] = dict(listing()).get(name, [])
        return bool(types)

    wait_for(is_known, timeout)
    if len(types) > 1:
        raise SwarmError(f"'{name}' has more than one type: [{', '.join(types)}]")
    return types[0] if types else None


def node_names(node: Node, *, hidden: bool = False) -> list[str]:
    """Return the full names of all nodes but this one, sorted, doubles included."""
    names = [
        f"{namespace.rstrip('/')}/{name}"
        for name, namespace in node.get_node_names_and_namespaces()
    ]
    own = node.get_fully_qualified_name()
    return sorted(name for name in names if name != own and (hidden or not is_hidden(name)))


def require_node(node: Node, name: str) -> str:
    """Return a node's full name once it has been discovered."""
    full = absolute(name)
    if wait_for(lambda: full in node_names(node, hidden=True), MOST):
        return full
    names = node_names(node)
    namespace = full.rpartition("/")[0]
    known = [name for name in names if name.rpartition("/")[0] == namespace]
    if not known:  # not a robot either
        robots = {name.split("/")[1] for name in names if name.count("/") == 2}
        known = sorted(robots, key=natural)
    listed = f"there are {', '.join(known)}" if known else "no node is running"
    raise SwarmError(f"Node not found: {full}; {listed}")


def print_names(rows: NamesAndTypes, *, types: bool, count: bool) -> None:
    """Print names, with types or as a number, as all list verbs do."""
    if count:
        print(len(rows))
        return
    for name, kinds in sorted(rows):
        print(f"{name} [{', '.join(kinds)}]" if types else name)


def print_found(
    listing: Callable[[Node], NamesAndTypes], kind: str, *, count: bool, hidden: bool
) -> None:
    """Print the names that have a type, or how many there are, as all find verbs do."""
    with open_node() as node:
        rows = visible(settled(node, lambda: listing(node)), hidden=hidden)
    print_names([(name, types) for name, types in rows if kind in types], types=False, count=count)
