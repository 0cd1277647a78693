"""The MQTT connection of one robot: a client with a last will, which reconnects by itself."""

from __future__ import annotations

import os
import queue
import socket
import ssl
import threading
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from enum import Enum
from typing import Any, NamedTuple

import paho.mqtt.client as mqtt
from paho.mqtt.enums import CallbackAPIVersion

KEEP_ALIVE = 15  # [s] of silence after which the broker asks whether the client is there
RECONNECT = (1, 8)  # [s] between two tries, least and most
PASSWORD = "SWARM_VDA5050_PASSWORD"  # variable that holds it


@dataclass(frozen=True, slots=True)
class Address:
    """Where the broker is, and who we are for it."""

    host: str  # name or address
    port: int  # TCP port
    user: str = ""  # empty for none
    is_secure: bool = False  # whether to use TLS
    ca: str = ""  # file of the certificates to trust; empty for the system's

    def __str__(self) -> str:
        return f"{'mqtts' if self.is_secure else 'mqtt'}://{self.host}:{self.port}"


class BrokerEventKind(Enum):
    """Kind of an event from the broker."""

    CONNECTED = "connected"
    REFUSED = "refused"
    MESSAGE = "message"


class BrokerEvent(NamedTuple):
    """Something that came from the broker."""

    kind: BrokerEventKind
    topic: str
    payload: bytes
    is_retained: bool = False  # whether the broker kept it from before the subscription


class Link:
    """One client; its network thread only fills `inbox`."""

    def __init__(
        self,
        address: Address,
        topics: Sequence[str],
        will: Callable[[], tuple[str, bytes]] | None,
        name: str,
    ) -> None:
        """Prepare a client; `open` connects it.

        Args:
            will: Returns topic and payload of the last will; None for a client without one.
            name: Name of the robot, for the client's id.
        """
        self.inbox: queue.SimpleQueue[BrokerEvent] = queue.SimpleQueue()
        self._address = address
        self._topics = topics
        self._will = will
        self._name = name
        self._client: mqtt.Client | None = None

    @property
    def is_open(self) -> bool:
        """Whether the broker hears us."""
        return self._client is not None and self._client.is_connected()

    def open(self) -> None:
        """Connect, now or as soon as there is a broker."""
        if self._client is not None:
            return
        client_id = f"{self._name}-{os.getpid()}"
        client = mqtt.Client(CallbackAPIVersion.VERSION2, client_id=client_id)
        if self._address.user:
            client.username_pw_set(self._address.user, os.environ.get(PASSWORD, ""))
        if self._address.is_secure:
            client.tls_set(self._address.ca or None, tls_version=ssl.PROTOCOL_TLS_CLIENT)
        if self._will is not None:
            topic, payload = self._will()
            client.will_set(topic, payload, qos=1, retain=True)
        client.reconnect_delay_set(*RECONNECT)
        client.on_connect = self._on_connect
        client.on_connect_fail = self._on_connect_fail
        client.on_message = self._on_message
        client.connect_async(self._address.host, self._address.port, KEEP_ALIVE)
        client.loop_start()
        self._client = client

    def publish(self, topic: str, payload: bytes, *, is_kept: bool = False) -> None:
        """Send a message; without a connection it is lost, unless it is kept.

        Args:
            is_kept: Whether it is retained, and sent with QoS 1.
        """
        if self._client is not None and (is_kept or self._client.is_connected()):
            self._client.publish(topic, payload, qos=1 if is_kept else 0, retain=is_kept)

    def close(self, topic: str, payload: bytes) -> None:
        """Send a last message, and disconnect."""
        client, self._client = self._client, None
        if client is not None:
            if client.is_connected():
                client.publish(topic, payload, qos=1, retain=True).wait_for_publish(2.0)
            client.disconnect()
            client.loop_stop()

    def cut(self) -> None:
        """Break the connection, so that the broker publishes the last will."""
        client, self._client = self._client, None
        if client is not None:
            threading.Thread(target=_break, args=(client,), daemon=True).start()

    def _on_connect(
        self, client: mqtt.Client, _data: Any, _flags: Any, reason: Any, _properties: Any
    ) -> None:
        if reason.is_failure:
            self.inbox.put(BrokerEvent(BrokerEventKind.REFUSED, "", str(reason).encode()))
            return
        client.subscribe([(topic, 1) for topic in self._topics])
        self.inbox.put(BrokerEvent(BrokerEventKind.CONNECTED, "", b""))

    def _on_connect_fail(self, _client: mqtt.Client, _data: Any) -> None:
        self.inbox.put(BrokerEvent(BrokerEventKind.REFUSED, "", b"nobody answers"))

    def _on_message(self, _client: mqtt.Client, _data: Any, message: mqtt.MQTTMessage) -> None:
        kind, payload = BrokerEventKind.MESSAGE, bytes(message.payload)
        self.inbox.put(BrokerEvent(kind, message.topic, payload, bool(message.retain)))


def _break(client: mqtt.Client) -> None:
    connection = client.socket()
    if isinstance(connection, socket.socket):
        connection.shutdown(socket.SHUT_RDWR)
    client.loop_stop()
