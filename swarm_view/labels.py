"""Which labels are shown, and where, so that none covers another one."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product

import numpy as np

from swarm_common.model.records import FloatArray
from swarm_view.views import Camera

LETTER_WIDTH, LETTER_HEIGHT = 7.6, 20.0  # [px] of viser's labels at a scale of 1
PADDING = 10.0  # [px]
# Where a label may be put at its place, the best one first: anchor, and the part of its own size
# by which its middle is off (right, down).
ANCHORS = (
    ("bottom-center", 0.0, -0.5),
    ("top-center", 0.0, 0.5),
    ("center-left", 0.5, 0.0),
    ("center-right", -0.5, 0.0),
)


@dataclass(frozen=True, slots=True)
class Wish:
    """A label that is to be shown.

    Attributes:
        name: Unique.
        texts: What it says, the longest first; the last one is short.
        place: (3,) in map.
        gap: [m] that it keeps from there.
    """

    name: str
    texts: tuple[str, ...]
    place: FloatArray
    gap: float = 0.0


@dataclass(frozen=True, slots=True)
class Placed:
    """A label as it is shown.

    Attributes:
        text: What it says.
        anchor: viser's name of the side at its place.
        place: (3,) in map.
    """

    text: str
    anchor: str
    place: FloatArray


def arrange(wishes: Sequence[Wish], camera: Camera, scale: float = 1.0) -> dict[str, Placed]:
    """Return the labels that find room, by name; of two in one place the first one stays.

    Args:
        wishes: The most important one first.
        camera: Of the page.
        scale: Of the font.
    """
    _, right, down = camera.axes
    taken = np.zeros((0, 4))
    placed: dict[str, Placed] = {}
    for wish in wishes:
        for text, (anchor, *off) in product(wish.texts, ANCHORS):
            place = wish.place + 2.0 * wish.gap * (off[0] * right + off[1] * down)
            (pixel,), (depth,) = camera.project(place[None])
            size = scale * np.array([LETTER_WIDTH * len(text) + PADDING, LETTER_HEIGHT])
            middle = pixel + size * off
            box = np.concatenate([middle - 0.5 * size, middle + 0.5 * size])
            if depth > 0.0 and _is_free(box, taken):
                placed[wish.name] = Placed(text, anchor, place)
                taken = np.vstack([taken, box])
                break
    return placed


def _is_free(box: FloatArray, taken: FloatArray) -> bool:
    """Return whether a box (4,) overlaps none of the others (n, 4)."""
    left, top, right, bottom = taken.T
    apart = (left >= box[2]) | (right <= box[0]) | (top >= box[3]) | (bottom <= box[1])
    return bool(apart.all())
