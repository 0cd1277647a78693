"""Which labels are shown, and where, so that none covers another one."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product

import numpy as np

from swarm_common.model.records import FloatArray
from swarm_view.scene.views import Camera

LETTER_WIDTH, LETTER_HEIGHT = 7.6, 20.0  # [px] of viser's labels at a scale of 1
PADDING = 10.0  # [px]
Box = tuple[float, float, float, float]  # left, top, right, bottom [px]
# Where a label may be put at its place, the best one first: anchor, and the part of its own size
# by which its middle is off (right, down).
ANCHORS = (
    ("bottom-center", 0.0, -0.5),
    ("top-center", 0.0, 0.5),
    ("center-left", 0.5, 0.0),
    ("center-right", -0.5, 0.0),
)


@dataclass(frozen=True, slots=True)
class LabelWish:
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
class PlacedLabel:
    """A label as it is shown.

    Attributes:
        text: What it says.
        anchor: viser's name of the side at its place.
        place: (3,) in map.
    """

    text: str
    anchor: str
    place: FloatArray


def arrange(
    wishes: Sequence[LabelWish], camera: Camera, scale: float = 1.0
) -> dict[str, PlacedLabel]:
    """Return the labels that find room, by name; of two in one place the first one stays.

    Args:
        wishes: The most important one first.
        camera: Of the page.
        scale: Of the font.
    """
    if not wishes:
        return {}
    _, right, down = camera.axes
    places = np.array([wish.place for wish in wishes])
    pixels, depths = camera.project(places)
    sizes = camera.sizes(places)
    taken: list[Box] = []
    placed: dict[str, PlacedLabel] = {}
    for wish, (x, y), depth, size in zip(
        wishes, pixels.tolist(), depths.tolist(), sizes.tolist(), strict=True
    ):
        if depth <= 0.0:
            continue
        gap = 2.0 * wish.gap
        for text, (anchor, off_x, off_y) in product(wish.texts, ANCHORS):
            width = scale * (LETTER_WIDTH * len(text) + PADDING)
            height = scale * LETTER_HEIGHT
            left = x + off_x * (gap / size + width) - 0.5 * width
            top = y + off_y * (gap / size + height) - 0.5 * height
            box = left, top, left + width, top + height
            if not any(_overlap(box, other) for other in taken):
                place = wish.place + gap * (off_x * right + off_y * down)
                placed[wish.name] = PlacedLabel(text, anchor, place)
                taken.append(box)
                break
    return placed


def _overlap(one: Box, other: Box) -> bool:
    return (
        one[0] < other[2] and other[0] < one[2] and one[1] < other[3] and other[1] < one[3]
    )  # fmt: skip
