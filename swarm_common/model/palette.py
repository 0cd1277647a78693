"""The colours of README, terminal, report and viewer, and what each state of a robot means.

The hues are those of Okabe and Ito (2008), which people with any colour vision can tell apart.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

RGB = tuple[int, int, int]

BLUE: RGB = (0, 114, 178)
ORANGE: RGB = (230, 159, 0)
GREEN: RGB = (0, 158, 115)
VERMILLION: RGB = (213, 94, 0)
SKY: RGB = (86, 180, 233)
PINK: RGB = (204, 121, 167)
YELLOW: RGB = (240, 228, 66)
BLACK: RGB = (0, 0, 0)
HUES = (BLUE, ORANGE, GREEN, VERMILLION, SKY, PINK, YELLOW, BLACK)
VIOLET: RGB = (120, 94, 200)
GREY: RGB = (170, 170, 170)
DARK_GREY: RGB = (90, 90, 90)
WHITE: RGB = (255, 255, 255)


@dataclass(frozen=True, slots=True)
class Look:
    """Appearance of a robot's state."""

    color: RGB  # its colour everywhere
    letter: str  # in the terminal, where there is no room for the word
    meaning: str  # what it says of the robot, for a legend


PAUSING, BY_HAND, CHARGING = "pausing", "driven by hand", "charging"
# States of a robot that is busy, but not under way: its goal is where it is.
BUSY_STATES = (PAUSING, BY_HAND)

# In the order of legends.
LOOKS: dict[str, Look] = {
    "driving": Look(BLUE, "d", "on its way to a goal"),
    "holding": Look(ORANGE, "h", "its station is taken: it circles or parks until its turn"),
    "waiting": Look(VERMILLION, "w", "stands on its way: a robot or an obstacle is in front of it"),
    "yielding": Look(PINK, "y", "makes way for a robot with priority"),
    "recovering": Look(YELLOW, "r", "lost or stuck: it turns, backs up or plans anew"),
    PAUSING: Look(GREEN, "p", "at a station, being served"),
    CHARGING: Look(VIOLET, "c", "at a charging station until its battery holds enough"),
    BY_HAND: Look(SKY, "t", "somebody drives it with the keys"),
    "idle": Look(GREY, ".", "has no goal"),
    "inactive": Look(DARK_GREY, "-", "its navigator is not active yet, or shut down"),
    "dead": Look(BLACK, "X", "its navigator has died"),
}
STATES: dict[str, RGB] = {state: look.color for state, look in LOOKS.items()}
UNKNOWN = WHITE
SCAN, PLAN, LOCAL_PLAN = VERMILLION, BLUE, SKY
HELD, WANTED = GREEN, YELLOW
INTENT: RGB = (140, 140, 140)
FOOTPRINT, PARTICLES, GOAL = GREEN, PINK, GREEN
TRAIL: RGB = (120, 150, 180)


def state_color(state: str) -> RGB:
    """Return the colour of a robot's state."""
    return STATES.get(state, UNKNOWN)


def css(color: RGB) -> str:
    """Return a colour for HTML, plots and terminals, like `#0072b2`."""
    return "#{:02x}{:02x}{:02x}".format(*color)


@cache
def linear(color: RGB) -> RGB:
    """Return a colour as viser's batches of meshes want it: they take sRGB for linear."""
    red, green, blue = (round(255 * (value / 255) ** 2.2) for value in color)
    return red, green, blue
