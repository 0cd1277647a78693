"""Floor plans as pictures: dark is wall, green spots are stations, a blue area is the start."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from swarm_common.model.errors import ConfigError
from swarm_common.model.records import Mask
from swarm_map.floor_plan import WALL_COLOR, FloorPlan, Thing
from swarm_sim.scene.scene import Box

MAX_PIXELS = 4_000_000
MAX_BOXES = 20_000
DARK = 100  # of 255; a pixel all of whose colours are below is a wall
VIVID = 60  # of 255 by which a colour must stand out
SMALL = 4  # pixels; smaller spots of colour are noise
SPAWN_PITCH = 1.2  # [m]


@dataclass(frozen=True, slots=True, kw_only=True)
class PlanScale:
    """How large a picture is.

    Attributes:
        resolution: [m] per pixel.
        origin: x, y [m] of the lower left corner; None puts the picture's middle at (0, 0).
        wall_height: [m]
    """

    resolution: float = 0.05
    origin: tuple[float, float] | None = None
    wall_height: float = 2.5

    def __post_init__(self) -> None:
        if not 0.001 <= self.resolution <= 1.0:
            raise ConfigError(f"--resolution is {self.resolution}; expected 0.001 to 1 m per pixel")
        if not 0.01 <= self.wall_height <= 100.0:
            raise ConfigError(f"--wall-height is {self.wall_height}; expected 0.01 to 100 m")


def load_picture(path: Path, scale: PlanScale) -> FloorPlan:
    """Return the plan in a picture.

    Raises:
        ConfigError: If it cannot be read, is too large, or shows no wall.
    """
    pixels = _pixels(path)[::-1].astype(np.int16)  # row 0 is the lowest y
    height, width = pixels.shape[:2]
    left, low = scale.origin or (
        -width * scale.resolution / 2.0,
        -height * scale.resolution / 2.0,
    )
    red, green, blue = np.moveaxis(pixels, 2, 0)
    walls = pixels.max(axis=2) < DARK
    if not walls.any():
        raise ConfigError(
            f"{path}: no pixel is dark; walls are pixels whose colours are all below {DARK} of 255"
        )
    size = scale.resolution
    boxes = rectangles(walls, path)
    things = tuple(
        Thing(
            f"wall_{index}",
            Box((_round(columns * size), _round(rows * size), scale.wall_height)),
            _round(left + (column + columns / 2.0) * size),
            _round(low + (row + rows / 2.0) * size),
            color=WALL_COLOR,
        )
        for index, (row, column, rows, columns) in enumerate(boxes, 1)
    )
    sites: dict[str, Any] = {}
    stations = _spots((green - np.maximum(red, blue)) > VIVID)
    if stations:
        yaws = _lane_yaws(walls, stations)
        sites["stations"] = {
            f"station_{index}": [_round(left + c * size), _round(low + r * size), _round(yaw)]
            for index, ((r, c), yaw) in enumerate(zip(stations, yaws, strict=True), 1)
        }
    spawn = (blue - np.maximum(red, green)) > VIVID
    if spawn.any():
        rows, columns = np.nonzero(spawn)
        sites["spawn"] = {
            "x_min": _round(left + (columns.min() + 0.5) * size),
            "y_min": _round(low + (rows.min() + 0.5) * size),
            "x_max": _round(left + (columns.max() + 0.5) * size),
            "y_max": _round(low + (rows.max() + 0.5) * size),
            "pitch": SPAWN_PITCH,
        }
    return FloorPlan(path.stem, things, sites)


def rectangles(mask: Mask, path: Path) -> list[tuple[int, int, int, int]]:
    """Return rectangles (row, column, rows, columns) that cover a mask without overlap.

    From the lowest left pixel on, each is as long as it can be, then as wide, along the rows or
    the columns, whichever covers more.
    """
    left = mask.copy()
    found = []
    for row, column in np.argwhere(mask):
        if not left[row, column]:
            continue
        flat = _grown(left, row, column)
        tall = _grown(left.T, column, row)[::-1]
        rows, columns = flat if flat[0] * flat[1] >= tall[0] * tall[1] else tall
        left[row : row + rows, column : column + columns] = False
        found.append((int(row), int(column), int(rows), int(columns)))
        if len(found) > MAX_BOXES:
            raise ConfigError(
                f"{path}: the walls make more than {MAX_BOXES} boxes; draw them with straight "
                "lines along the axes, or take a smaller picture"
            )
    return found


def _grown(left: Mask, row: int, column: int) -> tuple[int, int]:
    """Return rows and columns of the rectangle that grows along its row first."""
    line = np.append(left[row, column:], False)
    columns = int(np.argmin(line))
    block = left[row:, column : column + columns].all(axis=1)
    rows = int(np.argmin(np.append(block, False)))
    return rows, columns


def _spots(mask: Mask) -> list[tuple[float, float]]:
    """Return the middles (row, column) of connected spots, from the top left on."""
    from scipy import ndimage

    labels, count = ndimage.label(mask, structure=np.ones((3, 3)))
    spots = []
    for index in range(1, count + 1):
        rows, columns = np.nonzero(labels == index)
        if len(rows) >= SMALL:
            spots.append((float(rows.mean()) + 0.5, float(columns.mean()) + 0.5))
    return sorted(spots, key=lambda spot: (-round(spot[0]), spot[1]))


def _lane_yaws(walls: Mask, spots: list[tuple[float, float]]) -> list[float]:
    """Return the keep-right direction at each spot: the nearest wall is on the right."""
    from scipy import ndimage

    nearest = ndimage.distance_transform_edt(~walls, return_distances=False, return_indices=True)
    yaws = []
    for row, column in spots:
        r, c = nearest[:, int(row), int(column)]
        away = math.atan2(int(row) - r, int(column) - c)
        yaws.append(math.remainder(away - math.pi / 2.0, math.tau))
    return yaws


def _pixels(path: Path) -> NDArray[np.uint8]:
    from PIL import Image

    try:
        with Image.open(path) as opened:
            if opened.width * opened.height > MAX_PIXELS:
                raise ConfigError(
                    f"{path}: {opened.width} x {opened.height} pixels; expected at most "
                    f"{MAX_PIXELS:.0e}"
                )
            flat = Image.new("RGBA", opened.size, "white")  # transparent pixels are floor
            flat.alpha_composite(opened.convert("RGBA"))
            return np.asarray(flat.convert("RGB"))
    except (OSError, ValueError, SyntaxError, Image.DecompressionBombError) as cause:
        raise ConfigError(f"{path}: cannot read the picture: {cause}") from cause


def _round(value: float) -> float:
    return round(float(value), 6) + 0.0
