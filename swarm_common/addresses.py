"""Addresses that a server is to listen on."""

from __future__ import annotations

import socket

from swarm_common.errors import ConfigError

HIGHEST_PORT = 65535


def check_address(host: str, port: int) -> None:
    """Refuse an address that cannot be listened on, before anything is started.

    Raises:
        ConfigError: If it is taken, not of this machine, or impossible.
    """
    if not 0 <= port <= HIGHEST_PORT:
        raise ConfigError(f"--port is {port}; expected 1 to {HIGHEST_PORT}, or 0 for a free one")
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
