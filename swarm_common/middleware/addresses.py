"""Addresses of this machine and of others: what a server listens on, what hosts bind to."""

from __future__ import annotations

import ipaddress
import socket

import psutil

from swarm_common.model.errors import ConfigError

HIGHEST_PORT = 65535
DISCARD = 9  # port for asking the kernel for a way; nothing is sent to it


def check_address(host: str, port: int) -> None:
    """Refuse an address that cannot be listened on, before anything is started.

    Args:
        port: TCP; 0 for a free one.

    Raises:
        ConfigError: If it is taken, not of this machine, or impossible.
    """
    check_port(port)
    try:
        family, *_, address = socket.getaddrinfo(host, port, type=socket.SOCK_STREAM)[0]
        with socket.socket(family, socket.SOCK_STREAM) as probe:
            probe.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
            probe.bind(address)
    except OSError as error:
        raise ConfigError(
            f"the viewer cannot listen on {host}:{port}: {error.strerror};"
            " choose another --port (0 for a free one)"
        ) from None


def check_port(port: int) -> None:
    """Refuse a number that is not a TCP port.

    Raises:
        ConfigError: If it is none.
    """
    if not 0 <= port <= HIGHEST_PORT:
        raise ConfigError(f"--port is {port}; expected 1 to {HIGHEST_PORT}, or 0 for a free one")


def own_addresses() -> dict[str, str]:
    """Return the IPv4 addresses of this host, and the interface of each."""
    return {
        entry.address: interface
        for interface, entries in psutil.net_if_addrs().items()
        for entry in entries
        if entry.family is socket.AF_INET
    }


def own_address(text: str) -> str:
    """Return the address that --bind names: an IPv4 address of this host, or its interface."""
    known = own_addresses()
    if text in known:
        return text
    of_interface = [address for address, interface in known.items() if interface == text]
    if len(of_interface) == 1:
        return of_interface[0]
    listed = ", ".join(f"{address} ({interface})" for address, interface in known.items())
    if of_interface:
        raise ConfigError(f"--bind {text}: the interface has several addresses: {listed}; name one")
    raise ConfigError(f"--bind {text}: this host has no such address; it has {listed or 'none'}")


def address_of(host: str) -> str:
    """Return the IPv4 address of a host by name or address."""
    try:
        found = socket.getaddrinfo(host, None, socket.AF_INET, socket.SOCK_DGRAM)[0][4][0]
    except (OSError, UnicodeError) as error:
        reason = getattr(error, "strerror", None) or error
        raise ConfigError(f"--connect {host}: no IPv4 address found: {reason}") from None
    address = ipaddress.IPv4Address(str(found))
    if address.is_multicast or address.is_unspecified:
        raise ConfigError(f"--connect {host}: {address} is not the address of one host")
    return str(address)


def address_towards(address: str) -> str:
    """Return the own address from which this host reaches another; nothing is sent."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        try:
            probe.connect((address, DISCARD))
        except OSError as error:
            raise ConfigError(
                f"--connect {address}: this host has no way to it ({error.strerror});"
                " check the network, or the address"
            ) from None
        return str(probe.getsockname()[0])
