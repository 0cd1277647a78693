"""The user's browser."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Mapping

DISPLAYS = ("DISPLAY", "WAYLAND_DISPLAY")


def has_display(environment: Mapping[str, str] = os.environ) -> bool:
    """True if this terminal can open a window."""
    return any(environment.get(name) for name in DISPLAYS)


def open_page(url: str) -> None:
    """Open a page, from a process of its own: some browsers return only when they are closed."""
    nothing = subprocess.DEVNULL
    subprocess.Popen(
        [sys.executable, "-m", "webbrowser", url],
        stdin=nothing,
        stdout=nothing,
        stderr=nothing,
        start_new_session=True,
    )
