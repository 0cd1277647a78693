"""`stations.csv` beside a picture: which colour marks which station, or group of stations."""

from __future__ import annotations

import csv
import re
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from swarm_common.files.convert import convert
from swarm_common.model.errors import ConfigError
from swarm_common.model.records import Mask
from swarm_common.model.schema import Name

FILE = "stations.csv"
HEAD = ["color", "name"]
NEAR = 24  # of 255 in each channel that a pixel may be off
DARKEST = 100  # of 255; a colour below in all channels is a wall
RULE = "expected lines like #ff8000,loader below the heading color,name"


@dataclass(frozen=True, slots=True)
class StationMark:
    """A colour and what it marks."""

    color: tuple[int, int, int]  # red, green, blue, of 255
    name: str

    @property
    def text(self) -> str:
        """The colour as it is written."""
        return "#" + "".join(f"{part:02x}" for part in self.color)

    def mask(self, pixels: NDArray[np.int16]) -> Mask:
        """Return the pixels (height, width) that have the colour."""
        away = np.abs(pixels - np.array(self.color, np.int16)).max(axis=2)
        return np.asarray(away <= NEAR, np.bool_)


def read_marks(picture: Path) -> list[StationMark]:
    """Return the marks of the stations of a picture; none without a `stations.csv` beside it.

    Raises:
        ConfigError: If it is malformed, or two marks cannot be told apart.
    """
    path = picture.with_name(FILE)
    if not path.is_file():
        return []
    try:
        rows = list(csv.reader(path.read_text(encoding="utf-8-sig").splitlines()))
    except (OSError, UnicodeDecodeError, csv.Error) as cause:
        raise ConfigError(f"cannot read {path}: {cause}") from cause
    lines = [(count, [cell.strip() for cell in row]) for count, row in enumerate(rows, 1) if row]
    if not lines or lines[0][1] != HEAD:
        raise ConfigError(f"{path}: {RULE}")
    marks: list[StationMark] = []
    for count, cells in lines[1:]:
        where = f"{path}, line {count}"
        if len(cells) != 2 or not re.fullmatch(r"#[0-9a-fA-F]{6}", cells[0]):
            raise ConfigError(f"{where} is {','.join(cells)!r}; {RULE}")
        red, green, blue = (int(cells[0][at : at + 2], 16) for at in (1, 3, 5))
        mark = StationMark((red, green, blue), convert(cells[1], Name, f"{where}: the name"))
        if max(mark.color) < DARKEST:
            raise ConfigError(f"{where}: {mark.text} is as dark as a wall; take a lighter colour")
        for other in marks:
            _check_apart(mark, other, where)
        marks.append(mark)
    return marks


def _check_apart(mark: StationMark, other: StationMark, where: str) -> None:
    if mark.name == other.name:
        raise ConfigError(f"{where}: the name '{mark.name}' occurs twice")
    if np.abs(np.subtract(mark.color, other.color)).max() <= 2 * NEAR:
        raise ConfigError(
            f"{where}: {mark.text} is too much like {other.text}; take colours that differ by more"
            f" than {2 * NEAR} of 255 in red, green or blue"
        )
