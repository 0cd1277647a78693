"""Colours that people with any colour vision can tell apart (Okabe and Ito)."""

from __future__ import annotations

from functools import cache

RGB = tuple[int, int, int]

STATES: dict[str, RGB] = {
    "driving": (0, 114, 178),
    "holding": (230, 159, 0),
    "waiting": (213, 94, 0),
    "yielding": (204, 121, 167),
    "recovering": (240, 228, 66),
    "pausing": (86, 180, 233),
    "idle": (150, 150, 150),
    "inactive": (60, 60, 60),
}
UNKNOWN: RGB = (255, 255, 255)
SCAN: RGB = (213, 94, 0)
PLAN: RGB = (0, 114, 178)
LOCAL_PLAN: RGB = (86, 180, 233)
HELD: RGB = (0, 158, 115)
WANTED: RGB = (240, 228, 66)
INTENT: RGB = (140, 140, 140)
FOOTPRINT: RGB = (0, 158, 115)
PARTICLES: RGB = (204, 121, 167)
GOAL: RGB = (0, 158, 115)
TRAIL: RGB = (120, 150, 180)


def state_color(state: str) -> RGB:
    """Return the colour of a robot's state."""
    return STATES.get(state, UNKNOWN)


def css(color: RGB) -> str:
    """Return a colour for HTML."""
    return "#{:02x}{:02x}{:02x}".format(*color)


@cache
def linear(color: RGB) -> RGB:
    """Return a colour as viser's batches of meshes want it: they take sRGB for linear."""
    red, green, blue = (round(255 * (value / 255) ** 2.2) for value in color)
    return red, green, blue
