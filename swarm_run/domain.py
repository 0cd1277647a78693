"""One swarm per ROS domain, since two would have the same names; its owner takes requests."""

from __future__ import annotations

import contextlib
import functools
import json
import os
import socket
import struct
import sys
from collections.abc import Mapping

from swarm_common.model.errors import ConfigError, NoSwarmError
from swarm_common.process.messages import (
    USER,
    RestartNavigator,
    UnknownMessageError,
    decode,
    encode,
)
from swarm_run.robots.swarm_watch import SwarmPatience, domain_address, has_swarm

LONGEST = 4096  # [bytes] of a request or an answer
SPEECH_LIMIT = 0.2  # [s] of wall time for a request to arrive
HIGHEST_DOMAIN = 232  # the ports of a higher one would not fit below 65536


def domain_id(environment: Mapping[str, str] = os.environ) -> int:
    """Return the ROS domain that the environment asks for.

    Args:
        environment: ROS_DOMAIN_ID counts; 0 where it is not set.

    Raises:
        ConfigError: If ROS_DOMAIN_ID is not a domain.
    """
    text = environment.get("ROS_DOMAIN_ID", "") or "0"
    if not text.isdecimal() or int(text) > HIGHEST_DOMAIN:
        raise ConfigError(f"ROS_DOMAIN_ID is '{text}'; expected a number 0..{HIGHEST_DOMAIN}")
    return int(text)


def check_swarm(domain: int) -> None:
    """Raise an error if there can be no swarm in the domain.

    Raises:
        NoSwarmError: If there is none.
    """
    if has_swarm(domain) is False:
        raise NoSwarmError(domain)


def patience_for(domain: int) -> SwarmPatience:
    """Return how long to wait for a domain's swarm; what it waits for is printed to stderr."""
    return SwarmPatience(domain, functools.partial(has_swarm, domain), _tell)


def _tell(line: str) -> None:
    sys.stderr.write(f"{line}\n")
    sys.stderr.flush()


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
            self._socket.bind(domain_address(domain))
        except OSError:
            self._socket.close()
            raise ConfigError(
                f"ROS domain {domain} is in use by another swarm on this machine;"
                f" stop it, or choose another domain: ROS_DOMAIN_ID={(domain + 1) % 100} swarm-up …"
            ) from None
        self._socket.listen()
        self._socket.setblocking(False)

    @classmethod
    def of(cls, descriptor: int) -> DomainLock:
        """Return the claim of a process that handed its descriptor on to this one."""
        lock = cls.__new__(cls)
        lock._socket = socket.socket(fileno=descriptor)
        lock._socket.set_inheritable(False)
        lock._socket.setblocking(False)
        return lock

    def fileno(self) -> int:
        """Return the descriptor that becomes readable when a request arrives."""
        return self._socket.fileno()

    def take(self) -> Request | None:
        """Return the next request; None if there is none, or it was refused."""
        try:
            connection, _ = self._socket.accept()
        except OSError:
            return None
        connection.settimeout(SPEECH_LIMIT)
        with contextlib.suppress(OSError, ValueError):
            line = connection.recv(LONGEST)
            try:
                if _user_of(connection) not in (os.getuid(), 0):
                    raise ConfigError("the swarm belongs to another user, who alone may do that")
                return Request(connection, decode(line, USER))
            except (ConfigError, UnknownMessageError) as error:
                _answer(connection, f"swarm-up: {error}", is_done=False)
        connection.close()
        return None

    def release(self) -> None:
        """Give the domain back."""
        self._socket.close()


class Request:
    """A request of another process of the same user to `swarm-up`.

    Attributes:
        command: What is to be done.
    """

    def __init__(self, connection: socket.socket, command: RestartNavigator) -> None:
        self.command = command
        self._connection = connection

    def answer(self, message: str, *, is_done: bool) -> None:
        """Answer and close the connection; the client may be gone.

        Args:
            is_done: Whether what was asked for is done; otherwise the message says why not.
        """
        _answer(self._connection, message, is_done=is_done)
        self._connection.close()


def _answer(connection: socket.socket, message: str, *, is_done: bool) -> None:
    with contextlib.suppress(OSError):
        connection.sendall(json.dumps({"is_done": is_done, "message": message}).encode())


def ask(domain: int, command: RestartNavigator, limit: float) -> str:
    """Ask the `swarm-up` of a domain for something; return its answer.

    Args:
        limit: [s] of wall time to wait.

    Raises:
        ConfigError: If there is no swarm, it does not answer, or it refuses.
    """
    with socket.socket(socket.AF_UNIX, socket.SOCK_STREAM) as connection:
        connection.settimeout(limit)
        try:
            connection.connect(domain_address(domain))
            connection.sendall(encode(command))
            answer = json.loads(connection.recv(LONGEST))
        except (OSError, ValueError) as error:
            raise ConfigError(
                f"no swarm-up on this host answers in ROS domain {domain} ({error})"
            ) from None
    if not answer["is_done"]:
        raise ConfigError(str(answer["message"]))
    return str(answer["message"])


def _user_of(connection: socket.socket) -> int:
    """Return the user id of the process at the other end."""
    layout = struct.Struct("3i")  # pid, uid, gid; see unix(7)
    data = connection.getsockopt(socket.SOL_SOCKET, socket.SO_PEERCRED, layout.size)
    return int(layout.unpack(data)[1])
