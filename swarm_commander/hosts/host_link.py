"""Parts that both ends of the line between the world's host and a robots' host share."""

from __future__ import annotations

import contextlib
import os
import time
from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from typing import Any, Generic

import msgspec
from rclpy.node import Node

from swarm_common.middleware.rclpy_compat import SafeExecutor, join_graph
from swarm_common.middleware.secret import VARIABLE
from swarm_common.process.messages import Event, Kind
from swarm_common.process.pipes import EventWriter, StartedProcess, leave

FAREWELL = 4.0  # [s] of wall time for the hosts to say that they know of the end
TURN = 0.1  # [s]


class LinkEnd(ABC, Generic[Kind]):
    """One end of the line: hears swarm-up of its host, and the other end."""

    def __init__(self, events: EventWriter) -> None:
        self._events = events

    @property
    @abstractmethod
    def is_through(self) -> bool:
        """Whether the other end knows that this one leaves."""

    @abstractmethod
    def receive_command(self, command: Kind) -> None:
        """Obey swarm-up."""

    @abstractmethod
    def turn(self, now: float) -> None:
        """Do what is due at wall time `now`."""

    @abstractmethod
    def leave(self) -> None:
        """Begin to say farewell."""

    @abstractmethod
    def close(self) -> None:
        """Say the last words, after the farewell or without an answer to it."""

    def _pass_on(self, events: Sequence[Event]) -> None:
        for event in events:
            self._events.write(event)


def serve(
    name_of: Callable[[dict[str, Any]], str],
    make: Callable[[Node, dict[str, Any], EventWriter, str], LinkEnd[Kind]],
    decoder: msgspec.json.Decoder[Kind],
) -> None:
    """Be a process with one end of the line until SIGTERM, then say farewell.

    Args:
        name_of: Gives the node's name, from the process's configuration.
        make: Makes the end, with the secret that the hosts share.
    """
    secret = os.environ.pop(VARIABLE)
    child = StartedProcess("Link between hosts", decoder)
    node = join_graph(name_of(child.config), "sim")
    executor = SafeExecutor()
    executor.add_node(node)
    end = make(node, child.config, child.events, secret)
    deadline = float("inf")
    with contextlib.suppress(BrokenPipeError):
        while time.monotonic() < deadline:
            executor.spin_once(timeout_sec=TURN)
            for command in child.commands():
                end.receive_command(command)
            if child.is_stopping and deadline == float("inf"):
                deadline = time.monotonic() + FAREWELL
                end.leave()
            end.turn(time.monotonic())
            if child.is_stopping and end.is_through:
                break
        end.close()
    leave()
