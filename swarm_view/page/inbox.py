"""Messages of a page's own script: its size, a click on the time line, keys (see `page.js`)."""

from __future__ import annotations

import json
from collections.abc import Callable
from typing import Any

from swarm_view.scene.viser_compat import id_on_page, run_script

LONGEST = 2000  # characters of a message
Receive = Callable[[str, Any], None]  # called with the kind of a message and its value


class Inbox:
    """A hidden text field that the script of one page writes to."""

    def __init__(self, client: Any, receive: Receive) -> None:
        """Let messages come; `receive` is called on viser's threads."""
        self._receive = receive
        field = client.gui.add_text("", "", visible=False)
        field.on_update(self._on_update)
        run_script(client, f"window.swarm.begin({json.dumps(id_on_page(field))})")

    def _on_update(self, event: Any) -> None:
        message = parse(event.target.value)
        if message is not None:
            self._receive(*message)


def parse(text: str) -> tuple[str, Any] | None:
    """Return kind and value of a message; None if it is not a message."""
    if len(text) > LONGEST:
        return None
    try:
        message = json.loads(text)
    except (ValueError, RecursionError):
        return None
    if not isinstance(message, dict) or not isinstance(message.get("kind"), str):
        return None
    return message["kind"], message.get("value")


def numbers(value: Any, count: int) -> tuple[float, ...] | None:
    """Return a message's finite numbers; None if it has others."""
    if not isinstance(value, list) or len(value) != count:
        return None
    if not all(isinstance(item, int | float) and abs(item) < 1e9 for item in value):
        return None
    return tuple(float(item) for item in value)
