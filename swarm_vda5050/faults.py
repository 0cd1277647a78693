"""The errors that a robot reports, with their names and levels in both versions."""

from __future__ import annotations

from collections.abc import Mapping
from enum import Enum
from typing import NamedTuple, Protocol

from swarm_common.model.errors import SwarmError

WARNING, URGENT, FATAL, CRITICAL = "WARNING", "URGENT", "FATAL", "CRITICAL"


class OrderFault(Enum):
    """Name and level in 2.1, name and level in 3.0."""

    VALIDATION = ("validationError", WARNING, "VALIDATION_FAILURE", WARNING)
    UNSUPPORTED = ("orderError", WARNING, "UNSUPPORTED_PARAMETER", CRITICAL)
    UNKNOWN_ACTION = ("orderError", WARNING, "INVALID_ORDER_ACTION", WARNING)
    OUTDATED = ("orderUpdateError", WARNING, "OUTDATED_ORDER_UPDATE", WARNING)
    SAME_UPDATE = ("orderUpdateError", WARNING, "SAME_ORDER_UPDATE_ID", WARNING)
    NO_CONTINUATION = ("orderUpdateError", WARNING, "VALIDATION_FAILURE", WARNING)
    MEMORY = ("orderUpdateError", WARNING, "INSUFFICIENT_MEMORY", URGENT)
    CANCELLED = ("orderUpdateError", WARNING, "ORDER_UPDATE_FOLLOWING_CANCEL", WARNING)
    OTHER_ORDER = ("orderError", WARNING, "OTHER_ORDER_ACTIVE", WARNING)
    USED_ORDER = ("orderError", WARNING, "VALIDATION_FAILURE", WARNING)
    START_FAR = ("noRouteError", WARNING, "START_NODE_OUT_OF_RANGE", WARNING)
    NO_ROUTE = ("noRouteError", WARNING, "NO_ROUTE_TO_TARGET", WARNING)
    UNKNOWN_MAP = ("noRouteError", WARNING, "UNKNOWN_MAP_ID", WARNING)
    NOT_AVAILABLE = ("orderError", WARNING, "MOBILE_ROBOT_NOT_AVAILABLE", WARNING)
    NO_ORDER = ("noOrderToCancel", WARNING, "NO_ORDER_TO_CANCEL", WARNING)
    DUPLICATE_MAP = ("instantActionError", WARNING, "DUPLICATE_MAP", WARNING)
    INSTANT = ("instantActionError", WARNING, "INVALID_INSTANT_ACTION", WARNING)
    UNREACHABLE = ("noRouteError", FATAL, "NODE_UNREACHABLE", CRITICAL)
    ZONE_SET = ("validationError", WARNING, "DUPLICATE_ZONE_SET", WARNING)
    BLOCKED_ZONE = ("drivingError", FATAL, "BLOCKED_ZONE_VIOLATION", CRITICAL)
    RELEASE_LOST = ("drivingError", FATAL, "RELEASE_LOST", CRITICAL)
    OUTSIDE = ("drivingError", FATAL, "OUTSIDE_OF_CORRIDOR", CRITICAL)
    ACTION = ("actionError", WARNING, "ACTION_FAILED", WARNING)
    LOCALIZATION = ("localizationError", FATAL, "LOCALIZATION_ERROR", FATAL)
    DRIVING = ("drivingError", WARNING, "DRIVING_INTERRUPTED", WARNING)

    def name_in(self, major: int) -> str:
        """Return the errorType of a version.

        Args:
            major: 2 or 3.
        """
        return self.value[0] if major == 2 else self.value[2]

    def level_in(self, major: int) -> str:
        """Return the errorLevel of a version."""
        return self.value[1] if major == 2 else self.value[3]


class OrderRejectedError(SwarmError):
    """A message of the fleet control is rejected.

    Attributes:
        fault: The error to report.
        references: What it is about, by key like `nodeId`.
    """

    def __init__(self, fault: OrderFault, message: str, **references: object) -> None:
        self.fault = fault
        self.references = {key: str(value) for key, value in references.items()}
        super().__init__(message)


class AnyFault(Protocol):
    """Something that an error is about."""

    def name_in(self, major: int) -> str:
        """Return the errorType of a version."""

    def level_in(self, major: int) -> str:
        """Return the errorLevel of a version."""


class ActiveError(NamedTuple):
    """An error that is active."""

    fault: AnyFault
    message: str
    references: Mapping[str, str]
