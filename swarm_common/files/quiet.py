"""Libraries that write on the terminal what our own messages say better."""

from __future__ import annotations

import logging


def quiet_trimesh() -> None:
    """Keep trimesh from printing exceptions that it handles (a missing texture, a bad file)."""
    logging.getLogger("trimesh").setLevel(logging.CRITICAL + 1)
