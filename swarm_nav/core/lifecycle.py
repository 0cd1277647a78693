"""Lifecycle of a navigator as Nav2's lifecycle manager sees it, as a table."""

from __future__ import annotations

TRANSITIONS: dict[str, dict[str, str]] = {
    "unconfigured": {
        "startup": "active",
        "configure": "inactive",
        "reset": "unconfigured",
        "shutdown": "finalized",
    },
    "inactive": {
        "startup": "active",
        "resume": "active",
        "pause": "inactive",
        "cleanup": "unconfigured",
        "reset": "unconfigured",
        "shutdown": "finalized",
    },
    "active": {
        "startup": "active",
        "resume": "active",
        "pause": "inactive",
        "reset": "unconfigured",
        "shutdown": "finalized",
    },
    # unlike in Nav2 a shut-down robot can be started again: its node lives on
    "finalized": {"startup": "active", "shutdown": "finalized"},
}


class Lifecycle:
    """State of the whole navigator: amcl, bt_navigator and all others change together."""

    def __init__(self) -> None:
        self.state = "unconfigured"

    @property
    def is_active(self) -> bool:
        """Whether the robot takes goals and drives."""
        return self.state == "active"

    def apply(self, command: str) -> bool:
        """Carry out a command if the present state knows it; otherwise nothing changes.

        Args:
            command: Name of a transition in `TRANSITIONS`, like `startup` or `pause`.

        Returns:
            False if the state does not know the command.
        """
        target = TRANSITIONS[self.state].get(command)
        if target is None:
            return False
        self.state = target
        return True
