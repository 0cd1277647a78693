"""Differences between messages of simulation_interfaces 1.x and 2.x."""

from __future__ import annotations

from typing import Any

RESOURCES = ("entity_resource", "world_resource")


def resource_in(message: Any) -> Any:
    """Return the part of a message that has `uri`: a field, or in 1.x often the message itself."""
    return next((getattr(message, name) for name in RESOURCES if hasattr(message, name)), message)
