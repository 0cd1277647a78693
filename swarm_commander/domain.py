"""One swarm per ROS domain: two would answer to the same names."""

from __future__ import annotations

import os
import socket
from collections.abc import Mapping

from swarm_common.errors import ConfigError

HIGHEST_DOMAIN = 232  # the ports of a higher one would not fit below 65536


def domain_id(environment: Mapping[str, str] = os.environ) -> int:
    """Return the ROS domain that the environment asks for.

    Raises:
        ConfigError: If ROS_DOMAIN_ID is no domain.
    """
    text = environment.get("ROS_DOMAIN_ID", "") or "0"
    if not text.isdecimal() or int(text) > HIGHEST_DOMAIN:
        raise ConfigError(f"ROS_DOMAIN_ID is '{text}'; expected a number 0..{HIGHEST_DOMAIN}")
    return int(text)


class DomainLock:
    """Claim on a ROS domain that ends with the process, however it ends.

    It is a socket in Linux's abstract namespace: no file that could be left behind.
    """

    def __init__(self, domain: int) -> None:
        """Claim the domain.

        Raises:
            ConfigError: If another swarm has it.
        """
        self._socket = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM)
        try:
            self._socket.bind(_address(domain))
        except OSError:
            self._socket.close()
            raise ConfigError(
                f"ROS domain {domain} is in use by another swarm on this machine;"
                f" stop it, or choose another domain: ROS_DOMAIN_ID={(domain + 1) % 100} swarm-up …"
            ) from None
        self._socket.listen()

    def release(self) -> None:
        """Give the domain back."""
        self._socket.close()


def _address(domain: int) -> str:
    return f"\0swarm-up-domain-{domain}"
