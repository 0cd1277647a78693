"""Floor plans as pictures: dark is wall, green spots are stations, a blue area is the start.

A `stations.csv` beside the picture gives stations colours of their own, and names.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from swarm_common.model.errors import ConfigError
from swarm_common.model.records import Mask
from swarm_common.model.shapes import Box
from swarm_map.floor_plan import WALL_COLOR, FloorPlan, Thing, rounded
from swarm_map.station_list import FILE as STATIONS_FILE
from swarm_map.station_list import StationMark, read_marks

MAX_PIXELS = 4_000_000
MAX_BOXES = 20_000
DARK = 100  # of 255; a pixel all of whose colours are below is a wall
VIVID = 60  # of 255 by which a colour must stand out
SMALL = 4  # pixels; smaller green spots are noise
DOT = 3  # pixels; blue that is no longer and no wider is noise
SPECK = 0.3  # [m]; a dark spot of less than the square of this is no wall, but text or noise ...
SPECK_REACH = 2.0 * SPECK  # [m] ... if it also reaches no further than this
RING = 2  # pixels around a green spot within which a wall touches it
SPAWN_PITCH = 1.2  # [m]
RULE = "green spots are stations, a blue area is where the robots start"

Point = tuple[float, float]


@dataclass(frozen=True, slots=True, kw_only=True)
class PlanScale:
    """How large a picture is."""

    resolution: float = 0.05  # [m] per pixel
    # x, y [m] of the lower left corner; None puts the picture's middle at (0, 0)
    origin: tuple[float, float] | None = None
    wall_height: float = 2.5  # [m]
    drop: float = 0.0  # [m]; dark spots that reach no further are left out

    def __post_init__(self) -> None:
        if not 0.001 <= self.resolution <= 1.0:
            raise ConfigError(f"--resolution is {self.resolution}; expected 0.001 to 1 m per pixel")
        if not 0.01 <= self.wall_height <= 100.0:
            raise ConfigError(f"--wall-height is {self.wall_height}; expected 0.01 to 100 m")
        if not 0.0 <= self.drop <= 5.0:
            raise ConfigError(f"--drop is {self.drop}; expected 0 to 5 m")


def load_picture(path: Path, scale: PlanScale) -> FloorPlan:
    """Return the plan in a picture."""
    pixels = _pixels(path)[::-1].astype(np.int16)  # row 0 is the lowest y
    height, width = pixels.shape[:2]
    left, low = scale.origin or (-width * scale.resolution / 2.0, -height * scale.resolution / 2.0)
    red, green, blue = np.moveaxis(pixels, 2, 0)
    walls = pixels.max(axis=2) < DARK
    if not walls.any():
        raise ConfigError(
            f"{path}: no pixel is dark; walls are pixels whose colours are all below {DARK} of 255"
        )
    raster = WallRaster(path, walls, scale.resolution, left, low)
    remarks = raster.drop_specks(scale.drop)
    place = raster.place
    things = raster.things(scale.wall_height)
    sites: dict[str, Any] = {}
    marks = {mark: mark.mask(pixels) for mark in read_marks(path)}
    unmarked = ~np.any([np.zeros_like(walls), *marks.values()], axis=0)
    greens = _spots(((green - np.maximum(red, blue)) > VIVID) & unmarked)
    named, groups = _named_spots(marks, path)
    greens = [*named.values(), *greens]
    words = [*(f"spot of {name}" for name in named), *["green spot"] * len(greens)]
    for spot, what in zip(greens, words, strict=False):
        if _parts_a_wall(spot, walls):
            x, y = place(spot.middle)
            raise ConfigError(
                f"{path}: the {what} at ({x:.2f}, {y:.2f}) lies on a wall: two opposite sides of it"
                " are dark; move it to the floor, or make it smaller"
            )
    stations = [spot.middle for spot in greens]
    if stations:
        yaws = _lane_yaws(walls, stations)
        free = (f"station_{index}" for index in itertools.count(1))
        names = [*named, *itertools.islice(free, len(stations) - len(named))]
        sites["stations"] = {
            name: [*place(station), rounded(yaw)]
            for name, station, yaw in zip(names, stations, yaws, strict=True)
        }
    if groups:
        sites["groups"] = groups
    spawn = ((blue - np.maximum(red, green)) > VIVID) & unmarked
    _drop(spawn, DOT)
    if spawn.any():
        rows, columns = np.nonzero(spawn)
        x_min, y_min = place((rows.min() + 0.5, columns.min() + 0.5))
        x_max, y_max = place((rows.max() + 0.5, columns.max() + 0.5))
        sites["spawn"] = {"x_min": x_min, "y_min": y_min, "x_max": x_max, "y_max": y_max}
        sites["spawn"]["pitch"] = SPAWN_PITCH
    notes = []
    if not sites:
        notes.append(f"neither green nor blue in {path}: {RULE}")
    return FloorPlan(path.stem, things, sites, (*notes, *remarks))


def _named_spots(
    marks: Mapping[StationMark, Mask], path: Path
) -> tuple[dict[str, _Spot], dict[str, list[str]]]:
    """Return the spots of marks by the names of their stations, and groups of several.

    Raises:
        ConfigError: If a mark has no spot, or a name is taken.
    """
    named: dict[str, _Spot] = {}
    groups: dict[str, list[str]] = {}
    for mark, mask in marks.items():
        spots = _spots(mask)
        if not spots:
            raise ConfigError(
                f"{path}: no spot is {mark.text}, as {mark.name} is in {STATIONS_FILE}"
            )
        several = [f"{mark.name}_{index}" for index in range(1, len(spots) + 1)]
        names = several if len(spots) > 1 else [mark.name]
        if len(spots) > 1:
            groups[mark.name] = names
        for name, spot in zip(names, spots, strict=True):
            if name in named:
                raise ConfigError(f"{path}: two stations are called '{name}'; see {STATIONS_FILE}")
            named[name] = spot
    return named, groups


@dataclass(frozen=True, slots=True)
class WallRaster:
    """Walls as pixels."""

    path: Path  # of the picture, for messages
    walls: Mask  # (height, width); row 0 is the lowest y
    size: float  # [m] of a pixel
    left: float  # [m] x of the lower left corner
    low: float  # [m] y of it

    def place(self, spot: Point) -> Point:
        """Return x, y [m] of a row and column."""
        return rounded(self.left + spot[1] * self.size), rounded(self.low + spot[0] * self.size)

    def things(self, height: float) -> tuple[Thing, ...]:
        """Return the boxes that the walls are, `height` [m] tall."""
        return tuple(
            Thing(
                f"wall_{index}",
                Box((rounded(columns * self.size), rounded(rows * self.size), height)),
                *self.place((row + rows / 2.0, column + columns / 2.0)),
                color=WALL_COLOR,
            )
            for index, (row, column, rows, columns) in enumerate(
                rectangles(self.walls, self.path), 1
            )
        )

    def drop_specks(self, drop: float) -> list[str]:
        """Clear dark spots no longer and no wider than `drop` [m]; return notes on small ones."""
        dropped = _drop(self.walls, drop / self.size + 1e-6)
        if not self.walls.any():
            raise ConfigError(f"{self.path}: --drop {drop:g} leaves no wall")
        notes = []
        if dropped:
            x, y = self.place(max(dropped, key=lambda spot: max(spot.mask.shape)).middle)
            notes.append(
                f"left out as no longer and no wider than {drop:g} m: {len(dropped)} dark spots, "
                f"the largest at ({x:.1f}, {y:.1f})"
            )
        specks = _specks(self.walls, self.size)
        if specks:
            x, y = self.place(max(specks, key=lambda speck: speck.pixels).middle)
            notes.append(
                f"specks smaller than {SPECK:g} x {SPECK:g} m that are obstacles now (text? "
                f"noise?): {len(specks)}, the largest at ({x:.1f}, {y:.1f}); "
                "look at map.pgm; --drop leaves out what is small"
            )
        return notes


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
    line = np.append(left[row, column:], False)
    columns = int(np.argmin(line))
    block = left[row:, column : column + columns].all(axis=1)
    rows = int(np.argmin(np.append(block, False)))
    return rows, columns


@dataclass(frozen=True, slots=True)
class _Spot:
    """Connected pixels."""

    middle: Point  # row and column
    pixels: int  # number of them
    row: int  # of the lowest left corner of `mask` in the picture
    column: int  # likewise
    mask: Mask  # which pixels of the rectangle around the spot belong to it


def _connected(mask: Mask) -> Iterator[_Spot]:
    """Yield the connected parts of a mask."""
    from scipy import ndimage

    labels, _ = ndimage.label(mask, structure=np.ones((3, 3)))
    for index, window in enumerate(ndimage.find_objects(labels), 1):
        own = labels[window] == index
        rows, columns = np.nonzero(own)
        row, column = int(window[0].start), int(window[1].start)
        middle = (row + float(rows.mean()) + 0.5, column + float(columns.mean()) + 0.5)
        yield _Spot(middle, len(rows), row, column, own)


def _spots(mask: Mask) -> list[_Spot]:
    spots = [spot for spot in _connected(mask) if spot.pixels >= SMALL]
    return sorted(spots, key=lambda spot: (-round(spot.middle[0]), spot.middle[1]))


def _drop(mask: Mask, most: float) -> list[_Spot]:
    """Clear, and return, the parts of a mask that are at most so many pixels long and wide."""
    found = [spot for spot in _connected(mask) if max(spot.mask.shape) <= most]
    for spot in found:
        rows, columns = spot.mask.shape
        mask[spot.row : spot.row + rows, spot.column : spot.column + columns] &= ~spot.mask
    return found


def _specks(walls: Mask, size: float) -> list[_Spot]:
    """Return the dark parts that are too small for walls, in pixels of `size` [m]."""
    return [
        spot
        for spot in _connected(walls)
        if spot.pixels * size**2 < SPECK**2 and max(spot.mask.shape) * size <= SPECK_REACH
    ]


def _parts_a_wall(spot: _Spot, walls: Mask) -> bool:
    """Whether a wall goes on, along an axis, on both sides of the middle of a spot."""
    from scipy import ndimage

    rows, columns = spot.mask.shape
    near = ndimage.binary_dilation(np.pad(spot.mask, RING), np.ones((3, 3)), RING)
    padded = np.pad(walls, RING)
    dark = near & padded[spot.row :, spot.column :][: rows + 2 * RING, : columns + 2 * RING]
    for lines in (dark, dark.T):
        count, length = lines.shape
        middle = lines[count // 3 : count - count // 3]
        if (middle[:, : length // 2].any(axis=1) & middle[:, length // 2 :].any(axis=1)).any():
            return True
    return False


def _lane_yaws(walls: Mask, spots: list[Point]) -> list[float]:
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
