"""Messages of a version on the wire: bytes to messages and back, by the tables of the standard."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from datetime import UTC, datetime
from typing import Any

import msgspec

from swarm_vda5050.actions import OFFERED, ActionOffer
from swarm_vda5050.faults import ActiveError, OrderFault, OrderRejectedError
from swarm_vda5050.messages import (
    DriveOrder,
    Error,
    Header,
    InstantActions,
    Responses,
    VehicleState,
    ZoneSet,
    ZoneSetMessage,
)
from swarm_vda5050.reading import FieldError, Reader, written
from swarm_vda5050.simulated_faults import SIMULATED
from swarm_vda5050.standard import INCOMING, INTERFACES, VERSIONS

LARGEST = 1_000_000  # bytes of a message that is read
MESSAGES: dict[str, type[Header]] = {  # of the fleet control, by topic
    "order": DriveOrder,
    "instantActions": InstantActions,
    "zoneSet": ZoneSetMessage,
    "responses": Responses,
}
NAMES = ("headerId", "orderId", "orderUpdateId")  # of a message that cannot be read


@dataclass(frozen=True, slots=True)
class Identity:
    """Who a robot is for the fleet control."""

    manufacturer: str  # in topics and headers
    serial: str  # name of the robot
    version: str  # like `2.1`
    interface: str = ""  # first level of topics; empty for the version's

    @property
    def major(self) -> int:
        """2 or 3."""
        return int(self.version[0])

    def topic(self, name: str) -> str:
        """Return a topic of the robot.

        Args:
            name: Like `order`.
        """
        interface = self.interface or INTERFACES[self.version]
        return f"{interface}/v{self.major}/{self.manufacturer}/{self.serial}/{name}"

    @property
    def offered(self) -> Mapping[str, ActionOffer]:
        """Actions of the version."""
        return OFFERED[self.version] | SIMULATED

    @property
    def topics(self) -> list[str]:
        """Topics of the version that the robot listens to, like `order`."""
        return [name for name, versions in INCOMING.items() if self.version in versions]


@dataclass(slots=True)
class Dialect:
    """Reads and writes the messages of one robot.

    Attributes:
        forgiven: What was wrong in the message read last, and taken all the same.
    """

    identity: Identity  # identity of the robot
    is_lenient: bool = False  # whether what can be understood is taken although it is wrong
    forgiven: list[str] = field(default_factory=list)
    _sent: dict[str, int] = field(default_factory=dict)  # headerIds, by topic

    def read(self, topic: str, data: bytes) -> Header:
        """Return a message of the fleet control.

        Args:
            topic: A key of `MESSAGES`.

        Raises:
            OrderRejectedError: If it is none, or not for this robot.
        """
        reader = Reader(self.identity.version, is_lenient=self.is_lenient)
        self.forgiven = reader.forgiven
        content: Any = None
        try:
            if len(data) > LARGEST:
                raise FieldError(f"{len(data)} bytes; at most {LARGEST} are read")
            content = msgspec.json.decode(data)
            message = msgspec.convert(reader.record(content, topic), MESSAGES[topic])
            self._check_receiver(message)
        except (msgspec.MsgspecError, FieldError, ValueError, RecursionError) as error:
            known = content if isinstance(content, dict) else {}
            names = {key: str(known[key])[:80] for key in NAMES if key in known}
            text = f"{topic}: {str(error) or type(error).__name__}"
            raise OrderRejectedError(OrderFault.VALIDATION, text, topic=topic, **names) from None
        return message

    def zone_set(self, data: bytes) -> ZoneSet:
        """Return the zone set in a file: that of a message, with or without the rest of it.

        Raises:
            FieldError: If it is none.
        """
        reader = Reader(self.identity.version, is_lenient=self.is_lenient)
        try:
            content = msgspec.json.decode(data)
            inner = content.get("zoneSet", content) if isinstance(content, dict) else content
            return msgspec.convert(reader.record(inner, "zones"), ZoneSet)
        except (msgspec.MsgspecError, ValueError, RecursionError) as error:
            raise FieldError(f"the file is no zone set: {error}") from None

    def write(self, topic: str, content: Mapping[str, Any] | VehicleState) -> bytes:
        """Return a message with its header.

        Args:
            topic: Like `state`; each counts its headerIds.
            content: Fields by their names inside the package.
        """
        fields = msgspec.to_builtins(content)
        if topic == "state" and self.identity.major == 2:
            fields["actionStates"] = [*fields["actionStates"], *fields["instantActionStates"]]
        number = self._sent.get(topic, 0)
        self._sent[topic] = number + 1
        fields = {
            "referenceStateHeaderId": self._sent.get("state", 1) - 1,
            **self._header(number),
            **fields,
        }
        return msgspec.json.encode(written(fields, topic, self.identity.version))

    def error(self, report: ActiveError) -> Error:
        """Return an error of the version."""
        major = self.identity.major
        references = tuple(
            {"referenceKey": key, "referenceValue": value}
            for key, value in report.references.items()
        )
        content = {
            "errorType": report.fault.name_in(major),
            "errorLevel": report.fault.level_in(major),
            "errorDescription": report.message,
            "errorReferences": references,
        }
        return msgspec.convert(content, Error)

    def _header(self, number: int) -> dict[str, Any]:
        now = datetime.now(UTC).isoformat(timespec="milliseconds")
        return {
            "headerId": number,
            "timestamp": now.replace("+00:00", "Z"),
            "version": VERSIONS[self.identity.version],
            "manufacturer": self.identity.manufacturer,
            "serialNumber": self.identity.serial,
        }

    def _check_receiver(self, message: Header) -> None:
        own = self.identity
        if not message.version.startswith(f"{own.major}."):
            raise FieldError(f"version is '{message.version:.20}'; this robot speaks {own.version}")
        for name, found, expected in (
            ("manufacturer", message.manufacturer, own.manufacturer),
            ("serialNumber", message.serial_number, own.serial),
        ):
            if found != expected:
                raise FieldError(f"{name} is '{found:.80}'; this robot is '{expected}'")
