"""Differences between a map and the world that it should show: counted, named and drawn."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from swarm_common.model.errors import MapError
from swarm_common.model.grid import FREE, OCCUPIED, UNKNOWN, Grid
from swarm_common.model.records import Mask
from swarm_describe.worlds.scene import Scene
from swarm_sim.maps.raster import draw_on
from swarm_sim.scene.section import section_between

TOLERANCE = 0.1  # [m] by which an obstacle may be displaced on the map
MAX_SHARE = 0.02  # of the occupied cells that may disagree
PLACES = 3  # named in the message
MAX_SHIFT = 3.0  # [m] largest shift that is tried for the hint
PICTURE_SIZE = 1000  # [px] of the longer side, about
LEGEND_HEIGHT = 24  # [px]
COLORS = {  # of Okabe and Ito, told apart by the colour-blind, too
    "agreed": (60, 60, 60),
    "only the world": (213, 94, 0),
    "only the map": (0, 114, 178),
    "unknown": (205, 205, 205),
}


@dataclass(frozen=True, slots=True)
class MapDifference:
    """A map compared with a world on the map's cells."""

    grid: Grid  # the map, upright
    truth: Mask  # where the world has obstacles
    drawn: Mask  # where the map has them
    missing: Mask  # obstacles of the world where the map is free all around
    invented: Mask  # obstacles of the map with none of the world's near them
    outside: str  # remark on obstacles of the world off the map; empty if there are none

    @property
    def total(self) -> int:
        """Occupied cells of both."""
        return int(self.truth.sum() + self.drawn.sum())

    @property
    def wrong(self) -> int:
        """Cells that disagree."""
        return int(self.missing.sum() + self.invented.sum())

    @property
    def share(self) -> float:
        """Share of the occupied cells that disagree."""
        return self.wrong / max(1, self.total)

    def agrees(self, max_share: float = MAX_SHARE) -> bool:
        """Return whether the map shows the world well enough.

        Args:
            max_share: Largest share of the occupied cells that may disagree.
        """
        return self.outside == "" and (self.total == 0 or self.wrong <= max_share * self.total)

    def describe(self) -> str:
        """Return how much disagrees, where, and by which shift the map would fit."""
        return (
            f"{self.wrong} of {self.total} occupied cells ({100.0 * self.share:.0f} %) disagree"
            f"{self.outside}"
            + _places(self.missing, self.grid, "the world has an obstacle that the map lacks")
            + _places(self.invented, self.grid, "the map has an obstacle that the world lacks")
            + _hint(self.truth, self.drawn, self.grid)
        )

    def save_picture(self, path: Path) -> None:
        """Draw the comparison as a PNG."""
        from PIL import Image, ImageDraw

        scale = max(1, round(PICTURE_SIZE / max(self.drawn.shape)))
        pixels = np.full((*self.drawn.shape, 3), 255, np.uint8)
        pixels[self.grid.cells == UNKNOWN] = COLORS["unknown"]
        pixels[self.truth | self.drawn] = COLORS["agreed"]
        pixels[_thickened(self.missing, scale)] = COLORS["only the world"]
        pixels[_thickened(self.invented, scale)] = COLORS["only the map"]
        drawing = Image.fromarray(pixels[::-1]).resize(
            (scale * self.grid.width, scale * self.grid.height), Image.Resampling.NEAREST
        )
        width = max(drawing.width, 130 * len(COLORS))
        sheet = Image.new("RGB", (width, drawing.height + LEGEND_HEIGHT), "white")
        sheet.paste(drawing, (0, LEGEND_HEIGHT))
        draw = ImageDraw.Draw(sheet)
        for index, (name, color) in enumerate(COLORS.items()):
            draw.rectangle((130 * index + 6, 6, 130 * index + 18, 18), fill=color)
            draw.text((130 * index + 24, 6), name, fill="black")
        try:
            sheet.save(path, format="PNG")
        except OSError as cause:
            raise MapError(f"cannot write the picture {path}: {cause}") from cause


def compare(
    scene: Scene, grid: Grid, height: float, reach: tuple[float, float] | None = None
) -> MapDifference:
    """Compare a map with the obstacles of a world that stay where they are.

    A cell disagrees if the world has an obstacle there and the map says free, with no occupied
    cell within `TOLERANCE`, or if the map has an obstacle with none of the world's near it. Cells
    are those of navigation, `grid.COARSEST`, or the map's if they are smaller; within one of its
    own cells a coarse map may put an obstacle where it likes.

    Args:
        height: [m] above ground of the plane that the map shows.
        reach: Heights between which robots can touch something; the map may show that, too.
    """
    own_cell = grid.resolution
    grid = grid.upright().refined()
    section = section_between(scene.fixed, height, height)
    shape = (grid.height, grid.width)
    lattice = (grid.resolution, grid.origin_x, grid.origin_y)
    truth = draw_on(shape, *lattice, section).cells == OCCUPIED
    drawn = grid.cells == OCCUPIED
    near = max(1, round(TOLERANCE / grid.resolution))
    allowed = truth
    if reach is not None:
        touched = section_between(scene.fixed, *reach)
        allowed = truth | (draw_on(shape, *lattice, touched).cells == OCCUPIED)
    coarse = max(near, round(own_cell / grid.resolution))
    return MapDifference(
        grid=grid,
        truth=truth,
        drawn=drawn,
        missing=truth & (grid.cells == FREE) & ~grown(drawn, near),
        invented=drawn & ~grown(allowed, coarse),
        outside=_outside(section.bounds(), grid),
    )


def _outside(bounds: tuple[float, float, float, float], grid: Grid) -> str:
    """Return a remark on obstacles that lie off the map, empty if there are none."""
    x_min, y_min, x_max, y_max = bounds
    slack = TOLERANCE + grid.resolution
    right, top = grid.center_of(grid.height - 1, grid.width - 1)
    if (
        x_min >= grid.origin_x - slack
        and y_min >= grid.origin_y - slack
        and x_max <= right + slack
        and y_max <= top + slack
    ):
        return ""
    return (
        f"; the world's obstacles reach from ({x_min:.2f}, {y_min:.2f}) to "
        f"({x_max:.2f}, {y_max:.2f}), the map only from "
        f"({grid.origin_x:.2f}, {grid.origin_y:.2f}) to ({right:.2f}, {top:.2f})"
    )


def _places(mask: Mask, grid: Grid, what: str) -> str:
    """Return where most of a mask's cells are, by squares of 1 m."""
    if not mask.any():
        return ""
    rows, columns = np.nonzero(mask)
    x = grid.origin_x + (columns + 0.5) * grid.resolution
    y = grid.origin_y + (rows + 0.5) * grid.resolution
    squares, inverse, counts = np.unique(
        np.column_stack([np.floor(x), np.floor(y)]), axis=0, return_inverse=True, return_counts=True
    )
    worst = np.argsort(-counts, kind="stable")[:PLACES]
    spots = [
        f"({x[inverse.ravel() == i].mean():.2f}, {y[inverse.ravel() == i].mean():.2f})"
        for i in worst
    ]
    return f"; {what} around {', '.join(spots)}" + (" ..." if len(squares) > PLACES else "")


def _hint(truth: Mask, drawn: Mask, grid: Grid) -> str:
    """Return by which shift the map would fit best, if that is much better than none."""
    size = (2 * grid.height, 2 * grid.width)
    spectrum = np.fft.rfft2(truth, size) * np.conj(np.fft.rfft2(drawn, size))
    overlap = np.fft.irfft2(spectrum, size)
    reach = int(MAX_SHIFT / grid.resolution)
    best, shift = overlap[0, 0], (0, 0)
    for row in range(-min(reach, grid.height - 1), min(reach, grid.height - 1) + 1):
        columns = np.arange(-min(reach, grid.width - 1), min(reach, grid.width - 1) + 1)
        values = overlap[row, columns]
        index = int(np.argmax(values))
        if values[index] > best + 0.5:
            best, shift = values[index], (row, int(columns[index]))
    if shift == (0, 0) or best < 0.5 * drawn.sum():
        return ""
    x, y = shift[1] * grid.resolution, shift[0] * grid.resolution
    return f"; the map would fit if it were moved by ({x:+.2f}, {y:+.2f}) m"


def grown(mask: Mask, reach: int) -> Mask:
    """Return a mask grown by `reach` cells in the eight directions."""
    from scipy.ndimage import maximum_filter  # slow to import

    grown: Mask = maximum_filter(mask, 2 * reach + 1, mode="constant")
    return grown


def _thickened(mask: Mask, scale: int) -> Mask:
    return grown(mask, 1) if scale < 3 else mask
