"""Versions 2.1 and 3.0 on the wire: bytes to messages and back.

Inside the package messages are those of 2.1. Those of 3.0 have other names for the same, and a few
fields more or less.
"""

from __future__ import annotations

import contextlib
from collections.abc import Mapping
from dataclasses import dataclass, field
from datetime import UTC, datetime
from itertools import pairwise
from typing import Any, TypeVar

import msgspec

from swarm_vda5050.actions import OF_3, OFFERED, ActionOffer
from swarm_vda5050.faults import ActiveError, OrderFault, OrderRejectedError
from swarm_vda5050.messages import (
    BlockingType,
    DriveOrder,
    Error,
    Header,
    InstantActions,
    OrderAction,
    Responses,
    VehicleState,
    ZoneSetMessage,
)

LARGEST = 1_000_000  # bytes of a message that is read
INCOMING: dict[str, type[Header]] = {  # by topic
    "order": DriveOrder,
    "instantActions": InstantActions,
    "zoneSet": ZoneSetMessage,
    "responses": Responses,
}
VERSIONS = {"2.1": "2.1.0", "3.0": "3.0.0"}  # as asked for and as in headers
Kind = TypeVar("Kind", bound=Header)
_FROM_3 = {  # names of 3.0 in orders and actions
    "nodeDescriptor": "nodeDescription",
    "edgeDescriptor": "edgeDescription",
    "actionDescriptor": "actionDescription",
    "maximumSpeed": "maxSpeed",
    "maximumMobileRobotHeight": "maxHeight",
    "minimumLoadHandlingDeviceHeight": "minHeight",
    "corridorReferencePoint": "corridorRefPoint",
}
_TO_3 = {  # names of 3.0 in states
    "agvPosition": "mobileRobotPosition",
    "positionInitialized": "localized",
    "batteryState": "powerSupply",
    "batteryCharge": "stateOfCharge",
    "actionDescription": "actionDescriptor",
    "resultDescription": "actionResult",
    "infoDescription": "infoDescriptor",
    "eStop": "activeEmergencyStop",
}
_SHEET_TO_3 = {  # names of 3.0 in factsheets
    "agvKinematic": "mobileRobotKinematics",
    "agvClass": "mobileRobotClass",
    "maxLoadMass": "maximumLoadMass",
    "speedMin": "minimumSpeed",
    "speedMax": "maximumSpeed",
    "accelerationMax": "maximumAcceleration",
    "decelerationMax": "maximumDeceleration",
    "heightMin": "minimumHeight",
    "heightMax": "maximumHeight",
    "maxStringLens": "maximumStringLengths",
    "msgLen": "maximumMessageLength",
    "idLen": "maximumIdLength",
    "maxArrayLens": "maximumArrayLengths",
    "minOrderInterval": "minimumOrderInterval",
    "minStateInterval": "minimumStateInterval",
    "agvActions": "mobileRobotActions",
    "agvGeometry": "mobileRobotGeometry",
    "set": "envelope2dId",
    "polygonPoints": "vertices",
}


@dataclass(frozen=True, slots=True)
class Identity:
    """Who a robot is for the fleet control."""

    manufacturer: str  # in topics and headers
    serial: str  # name of the robot
    version: str  # `2.1` or `3.0`

    @property
    def major(self) -> int:
        """2 or 3."""
        return int(self.version[0])

    def topic(self, name: str) -> str:
        """Return a topic of the robot.

        Args:
            name: Like `order`.
        """
        return f"uagv/v{self.major}/{self.manufacturer}/{self.serial}/{name}"

    @property
    def offered(self) -> Mapping[str, ActionOffer]:
        """Actions of the version."""
        return OFFERED if self.major == 2 else OF_3

    @property
    def topics(self) -> list[str]:
        """Topics of the version that the robot listens to, like `order`."""
        return list(INCOMING)[: 2 if self.major == 2 else None]

    @property
    def broken(self) -> str:
        """The connectionState of a robot that is gone."""
        return "CONNECTIONBROKEN" if self.major == 2 else "CONNECTION_BROKEN"


@dataclass(slots=True)
class Dialect:
    """Reads and writes the messages of one robot."""

    identity: Identity  # identity of the robot
    _sent: dict[str, int] = field(default_factory=dict)  # headerIds, by topic

    def read(self, topic: str, data: bytes) -> Header:
        """Return a message of the fleet control.

        Args:
            topic: A key of `INCOMING`.

        Raises:
            OrderRejectedError: If it is none, or not for this robot.
        """
        return self._read(data, INCOMING[topic])

    def write(self, topic: str, content: Mapping[str, Any] | VehicleState) -> bytes:
        """Return a message with its header.

        Args:
            topic: Like `state`; each counts its headerIds.
        """
        fields = msgspec.to_builtins(content)
        if isinstance(content, VehicleState):
            if self.identity.major == 2:
                instant = fields.pop("instantActionStates")
                fields["actionStates"] = [*fields["actionStates"], *instant]
        if self.identity.major == 3:
            fields = _renamed(fields, _SHEET_TO_3 if topic == "factsheet" else _TO_3)
            if topic == "visualization":
                fields["referenceStateHeaderId"] = self._sent.get("state", 1) - 1
        number = self._sent.get(topic, 0)
        self._sent[topic] = number + 1
        return msgspec.json.encode(self._header(number) | fields)

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

    def _read(self, data: bytes, kind: type[Kind]) -> Kind:
        if len(data) > LARGEST:
            raise _invalid(f"{len(data)} bytes; at most {LARGEST} are read", data[:0])
        try:
            if self.identity.major == 2:
                message = msgspec.json.decode(data, type=kind)
            else:
                content = _with_node_ids(_from_3(msgspec.json.decode(data)))
                message = msgspec.convert(content, kind)
        except (msgspec.MsgspecError, ValueError, RecursionError, OverflowError) as error:
            raise _invalid(str(error) or type(error).__name__, data) from None
        self._check_header(message)
        if self.identity.major == 2:
            _check_blocking(message)
        return message

    def _check_header(self, message: Header) -> None:
        own = self.identity
        if not message.version.startswith(f"{own.major}."):
            text = f"version is '{message.version:.20}'; this robot speaks {own.version}"
            raise OrderRejectedError(OrderFault.VALIDATION, text, parameter="version")
        for name, found, expected in (
            ("manufacturer", message.manufacturer, own.manufacturer),
            ("serialNumber", message.serial_number, own.serial),
        ):
            if found != expected:
                text = f"{name} is '{found:.80}'; this robot is '{expected}'"
                raise OrderRejectedError(OrderFault.VALIDATION, text, parameter=name)


def _actions_of(message: Header) -> tuple[OrderAction, ...]:
    if isinstance(message, DriveOrder):
        return tuple(message.actions)
    return message.actions if isinstance(message, InstantActions) else ()


def _check_blocking(message: Header) -> None:
    for action in _actions_of(message):
        if action.blocking_type is BlockingType.SINGLE:
            text = "the blockingType SINGLE is of version 3.0"
            raise OrderRejectedError(OrderFault.VALIDATION, text, actionId=action.action_id)


def _invalid(message: str, data: bytes) -> OrderRejectedError:
    """Return the error for a message that cannot be read, with the order it names if it does."""
    references: dict[str, str] = {}
    with contextlib.suppress(msgspec.MsgspecError, ValueError, RecursionError):
        content = msgspec.json.decode(data)
        if isinstance(content, dict):
            names = ("headerId", "orderId", "orderUpdateId")
            references = {key: str(content[key])[:80] for key in names if key in content}
    return OrderRejectedError(OrderFault.VALIDATION, message, **references)


def _from_3(content: Any) -> Any:
    """Return a message of 3.0 with the names of 2.1."""
    if isinstance(content, list):
        return [_from_3(each) for each in content]
    if not isinstance(content, dict):
        return content
    result = {
        _FROM_3.get(key, key): value if key == "actionParameters" else _from_3(value)
        for key, value in content.items()
    }
    if result.pop("retriable", False) is True:
        raise OrderRejectedError(
            OrderFault.UNSUPPORTED, "retriable actions are not supported", parameter="retriable"
        )
    ellipse = result.get("allowedDeviationXY")
    if isinstance(ellipse, dict):  # the circle inside it
        axes = [ellipse[axis] for axis in ("a", "b") if isinstance(ellipse.get(axis), int | float)]
        if len(axes) != 2 or set(ellipse) != {"a", "b", "theta"}:
            raise _invalid(f"allowedDeviationXY is {ellipse!r:.80}; expected a, b, theta", b"")
        result["allowedDeviationXY"] = min(axes)
    result.pop("reachOrientationBeforeEntering", None)  # no heading is to be reached
    if result.get("corridorRefPoint") == "KINEMATIC_CENTER":
        result["corridorRefPoint"] = "KINEMATICCENTER"
    return result


def _with_node_ids(content: Any) -> Any:
    with contextlib.suppress(AttributeError, KeyError, TypeError):  # what is no order is told later
        for edge, (start, end) in zip(content["edges"], pairwise(content["nodes"]), strict=False):
            edge.setdefault("startNodeId", start["nodeId"])
            edge.setdefault("endNodeId", end["nodeId"])
    return content


def _renamed(content: Any, names: Mapping[str, str]) -> Any:
    if isinstance(content, list | tuple):
        return [_renamed(each, names) for each in content]
    if isinstance(content, dict):
        return {names.get(key, key): _renamed(value, names) for key, value in content.items()}
    return content
