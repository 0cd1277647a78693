"""DDS profiles of a swarm on several hosts: one address to bind to, peers by unicast only."""

from __future__ import annotations

import xml.etree.ElementTree as ElementTree
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from swarm_common.middleware.ros_env import PROFILES, newcomer_ids, unicast_port
from swarm_common.model.errors import ConfigError

NAMESPACE = "http://www.eprosima.com"
TEMPLATE = Path(__file__).resolve().parent / "fastdds.xml"
FOREIGN = (PROFILES, "FASTDDS_DEFAULT_PROFILES_FILE", "ROS_DISCOVERY_SERVER")
WORLD_IDS = 40  # ids on the world's host that tools announce themselves to
# The same for navigators, which are many: world, mission, host server, and tools. In a large swarm
# the world's host tells each navigator which participants to announce itself to.
WORLD_IDS_OF_ROBOTS = 16
HELPERS = (0, 1)  # ids on a robots' host before its navigators': host client and distributor
MOST_PROCESSES = 90  # navigators' on one host: Fast DDS gives out about 100 ids, tools need some
# Longer than the silence of a host that is tolerated: DDS itself repeats what was sent meanwhile.
LEASE = 60  # [s]
# Of DDS itself; it sends larger messages in parts, and repeats lost parts. Datagrams
# of up to 64 kB would be fragmented by IP: with one fragment the whole is lost, some firewalls drop
# them all, and where the MTU is smaller than both ends believe, nothing large ever arrives.
DATAGRAM = 1300  # bytes
# Announcements go to every id that is possible, and the kernel of the other host answers those to
# ports that nobody listens on. Each second they were half of what 20 robots sent at real time.
ANNOUNCEMENT = 3  # [s]


@dataclass(frozen=True, slots=True)
class Peers:
    """The participants that a participant announces itself to."""

    address: str  # of the host
    ids: tuple[int, ...] | None = None  # participant ids on it; None for all that are possible


def profile(own_address: str, peers: Sequence[Peers], domain: int) -> str:
    """Return the profile of participants that bind to one address and use no multicast."""
    root = ElementTree.parse(TEMPLATE).getroot()
    _only(root, "interfaceWhiteList/d:address").text = own_address
    transport = _only(root, "transport_descriptor")
    ElementTree.SubElement(transport, f"{{{NAMESPACE}}}maxMessageSize").text = str(DATAGRAM)
    _only(root, "leaseDuration/d:sec").text = str(LEASE)
    _only(root, "leaseAnnouncement/d:sec").text = str(ANNOUNCEMENT)
    known = _only(root, "initialPeersList")
    known.clear()
    for each in peers:
        for port in [None] if each.ids is None else [unicast_port(domain, i) for i in each.ids]:
            _add_locator(known, each.address, port)
    ElementTree.register_namespace("", NAMESPACE)
    return ElementTree.tostring(root, encoding="unicode", xml_declaration=True)


def _only(root: ElementTree.Element, path: str) -> ElementTree.Element:
    found = root.findall(f".//d:{path}", {"d": NAMESPACE})
    if len(found) != 1:
        raise ValueError(f"{TEMPLATE} has {len(found)} elements {path}; expected one")
    return found[0]


def _add_locator(known: ElementTree.Element, address: str, port: int | None) -> None:
    """Add a peer; without a port all participant ids of the host are sought."""
    make = ElementTree.SubElement
    udp = make(make(known, f"{{{NAMESPACE}}}locator"), f"{{{NAMESPACE}}}udpv4")
    if port is not None:
        make(udp, f"{{{NAMESPACE}}}port").text = str(port)
    make(udp, f"{{{NAMESPACE}}}address").text = address


def peers_of_tools(own_address: str, world_address: str) -> list[Peers]:
    """Return the peers of a tool that looks at the graph from one of its hosts.

    Args:
        world_address: IPv4 address of the world's host; may be the same.
    """
    own = Peers(own_address)
    if world_address == own_address:
        return [own]
    return [own, Peers(world_address, tuple(range(WORLD_IDS)))]


def peers_of_robots(own_address: str, world_address: str, processes: int) -> list[Peers]:
    """Return the peers of navigators: the world's host, and newcomers on their own.

    Robots need not know each other in DDS: their beacons go through the world's radio.

    Args:
        processes: Number of processes with the navigators of this host.
    """
    if world_address == own_address:
        return [Peers(own_address)]
    own = (*HELPERS, *newcomer_ids(len(HELPERS) + processes))
    return [Peers(own_address, own), Peers(world_address, tuple(range(WORLD_IDS_OF_ROBOTS)))]


def foreign_setting(environment: Mapping[str, str]) -> str:
    """Return the variable by which the user replaces our DDS profile; empty if there is none."""
    for name in FOREIGN:
        value = environment.get(name, "")
        if value and Path(value) != TEMPLATE:
            return name
    return ""


def check_environment(environment: Mapping[str, str]) -> None:
    """Refuse settings of DDS by the user that a profile of ours would contradict.

    Raises:
        ConfigError: If there are some.
    """
    name = foreign_setting(environment)
    if name:
        raise ConfigError(
            f"{name} is set to {environment[name]}; with --role the addresses come from --bind and"
            " --connect: unset it"
        )
