"""Which labels are shown, and where, so that none covers another one."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product

import numpy as np
from numpy.typing import NDArray

from swarm_common.model.records import FloatArray
from swarm_view.scene.views import Camera

LETTER_WIDTH, LETTER_HEIGHT = 7.6, 20.0  # [px] of viser's labels at a scale of 1
PADDING = 10.0  # [px]
INSIDE = 0.85  # of a mark's radius: a label may touch its rim
Marks = tuple[FloatArray, FloatArray]  # places (m, 3) in map, and radii (m,) [m]
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
    """A label that is to be shown."""

    name: str  # unique
    texts: tuple[str, ...]  # what it says, the longest first; the last one is short
    place: FloatArray  # (3,) in map
    gap: float = 0.0  # [m] that it keeps from there


@dataclass(frozen=True, slots=True)
class PlacedLabel:
    """A label as it is shown."""

    text: str  # what it says
    anchor: str  # viser's name of the side at its place
    place: FloatArray  # (3,) in map


def arrange(
    wishes: Sequence[LabelWish], camera: Camera, scale: float = 1.0, marks: Marks | None = None
) -> dict[str, PlacedLabel]:
    """Return the labels that find room, by name; of two in one place the first one stays.

    A label that has to cover the mark of a robot is as short as possible.
    """
    if not wishes:
        return {}
    _, right, down = camera.axes
    places = np.array([wish.place for wish in wishes])
    pixels, depths = camera.project(places)
    sizes = camera.sizes(places)
    blocked = _boxes_of(marks, camera)
    taken = np.zeros((len(wishes), 4))
    placed: dict[str, PlacedLabel] = {}
    for wish, (x, y), depth, size in zip(
        wishes, pixels.tolist(), depths.tolist(), sizes.tolist(), strict=True
    ):
        if depth <= 0.0:
            continue
        gap = 2.0 * wish.gap
        options = list(product(wish.texts, ANCHORS))
        boxes = np.array(
            [_box(text, off, (x, y), gap / size, scale) for text, (_, *off) in options]
        )
        is_free = ~_overlap(boxes, taken[: len(placed)])
        is_clear = is_free & ~_overlap(boxes, blocked)
        if not is_clear.any():
            is_clear[-len(ANCHORS) :] = is_free[-len(ANCHORS) :]
        if not is_clear.any():
            continue
        best = int(np.argmax(is_clear))
        text, (anchor, off_x, off_y) = options[best]
        taken[len(placed)] = boxes[best]
        place = wish.place + gap * (off_x * right + off_y * down)
        placed[wish.name] = PlacedLabel(text, anchor, place)
    return placed


def _box(
    text: str, off: Sequence[float], pixel: tuple[float, float], gap: float, scale: float
) -> tuple[float, float, float, float]:
    """Return left, top, right, bottom [px] of a label beside a pixel."""
    width, height = scale * (LETTER_WIDTH * len(text) + PADDING), scale * LETTER_HEIGHT
    x, y = pixel[0] + off[0] * (gap + width), pixel[1] + off[1] * (gap + height)
    return x - 0.5 * width, y - 0.5 * height, x + 0.5 * width, y + 0.5 * height


def _boxes_of(marks: Marks | None, camera: Camera) -> FloatArray:
    """Return left, top, right, bottom [px] (m, 4) of the discs on the floor."""
    if marks is None or not len(marks[0]):
        return np.zeros((0, 4))
    places, radii = marks
    pixels, depths = camera.project(places)
    ahead, _, _ = camera.axes
    wide = INSIDE * radii / camera.sizes(places)
    high = abs(float(ahead[2])) * wide
    boxes = np.column_stack([pixels - np.column_stack([wide, high]), pixels])
    boxes[:, 2:] += np.column_stack([wide, high])
    return boxes[depths > 0.0]


def _overlap(boxes: FloatArray, others: FloatArray) -> NDArray[np.bool_]:
    """Return for each box (n, 4) whether it covers part of any of the others (m, 4)."""
    one, other = boxes[:, None], others[None]
    apart = (one[..., :2] >= other[..., 2:]) | (other[..., :2] >= one[..., 2:])
    is_covering: NDArray[np.bool_] = np.logical_not(np.logical_or(apart[..., 0], apart[..., 1]))
    return np.asarray(np.any(is_covering, axis=1))
