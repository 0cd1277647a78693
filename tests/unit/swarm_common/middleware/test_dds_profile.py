"""Profiles for several hosts: one address, peers by unicast, nothing else."""

import xml.etree.ElementTree as ElementTree

import pytest

from swarm_common.middleware import dds_profile
from swarm_common.middleware.addresses import (
    address_of,
    address_towards,
    own_address,
    own_addresses,
)
from swarm_common.middleware.ros_env import unicast_port
from swarm_common.model.errors import ConfigError
from swarm_common.process.compiled_code import DECIDING, edition

SPACE = {"d": dds_profile.NAMESPACE}


def profile(own, peers):
    return ElementTree.fromstring(dds_profile.profile(own, peers, 3))


def texts(root, path):
    return [str(node.text) for node in root.iterfind(f".//d:{path}", SPACE)]


def test_only_the_named_addresses_occur_and_no_datagram_needs_ip_fragments():
    own, world = "10.0.0.2", "10.0.0.1"
    root = profile(own, dds_profile.peers_of_tools(own, world))
    assert texts(root, "interfaceWhiteList/d:address") == [own]
    assert set(texts(root, "address")) == {own, world}
    assert texts(root, "useBuiltinTransports") == ["false"]
    assert texts(root, "type") == ["UDPv4"]
    assert texts(root, "leaseDuration/d:sec") == [str(dds_profile.LEASE)]
    # Beacons of all robots were 5 to 15 fragments: one that was lost cost them all.
    (size,) = texts(profile(own, dds_profile.peers_of_tools(own, world)), "maxMessageSize")
    heads, mtu_of_a_tunnel = 28, 1400  # of IPv4 and UDP
    assert int(size) + heads <= mtu_of_a_tunnel


def test_robots_look_for_the_world_and_not_for_each_other():
    own, world = "10.0.0.2", "10.0.0.1"
    root = profile(own, dds_profile.peers_of_robots(own, world, 50))
    found = [
        (str(node.findtext("d:address", "", SPACE)), int(node.findtext("d:port", "0", SPACE)))
        for node in root.iterfind(".//d:initialPeersList/d:locator/d:udpv4", SPACE)
    ]
    at_world = [port for address, port in found if address == world]
    first = unicast_port(3, 0)
    assert at_world == [first + 2 * i for i in range(dds_profile.WORLD_IDS_OF_ROBOTS)]
    ids = [(port - first) // 2 for address, port in found if address == own]
    assert ids == [0, 1, *range(52, 68)]  # agent, distributor, newcomers


def test_both_roles_on_one_host():
    root = profile("127.0.0.1", dds_profile.peers_of_robots("127.0.0.1", "127.0.0.1", 3))
    assert texts(root, "initialPeersList//d:address") == ["127.0.0.1"]
    assert texts(root, "initialPeersList//d:port") == []


@pytest.mark.parametrize("host", ["224.0.0.1", "0.0.0.0", "x" * 70])
def test_addresses_of_no_host(host):
    with pytest.raises(ConfigError, match="--connect"):
        address_of(host)


def test_an_edition_depends_on_the_code_and_addresses_are_this_hosts():
    assert edition() == edition()
    assert edition(["swarm_common"]) != edition()
    assert "swarm_commander" in DECIDING  # both sides of what hosts say to each other
    assert own_addresses()["127.0.0.1"] == "lo"
    assert own_address("lo") == own_address("127.0.0.1") == "127.0.0.1"
    assert address_of("localhost") == address_towards("127.0.0.1") == "127.0.0.1"
    with pytest.raises(ConfigError, match="this host has no such address"):
        own_address("203.0.113.77")
