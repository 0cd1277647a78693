"""Reading and writing of maps in Nav2's format: a YAML file beside a greyscale image.

The rules are those of nav2_map_server (map_io.cpp): modes trinary, scale and raw, `negate`,
thresholds, alpha, rotated origins.
"""

from __future__ import annotations

import math
import re
from pathlib import Path
from typing import Any

import numpy as np
import yaml
from numpy.typing import NDArray

from swarm_common.files.map_image import TOP, MapImage, read_image
from swarm_common.files.resources import file_of, share_directory
from swarm_common.files.yaml_io import read_yaml
from swarm_common.model.errors import MapError, MapImageError, close_names
from swarm_common.model.grid import OCCUPIED, UNKNOWN, Grid

WORLD_FILE = "world.sdf"
MAP_FILE = "map.yaml"  # beside a user's world
MODES = ("trinary", "scale", "raw")
REQUIRED = ("image", "resolution", "origin")
OPTIONAL = {"mode": "trinary", "negate": "0", "occupied_thresh": "0.65", "free_thresh": "0.25"}
NUMBER = re.compile(r"[-+]?(\d+\.?\d*|\.\d+)([eE][-+]?\d+)?")
INTEGER = re.compile(r"[-+]?(0x[0-9a-fA-F]+|\d+)")
TRUE, FALSE = ("y", "yes", "true", "on"), ("n", "no", "false", "off")
MIN_RESOLUTION, MAX_RESOLUTION = 0.001, 10.0  # [m] per pixel
MAX_PLACE = 100_000.0  # [m] of the origin
GREY_FREE, GREY_UNKNOWN, GREY_OCCUPIED = 254, 205, 0


def map_path(name: str) -> Path:
    """Return where the map that ships with a world is, whether it exists or not."""
    return share_directory() / "maps" / f"{name}.yaml"


def map_of_world(world: Path) -> Path | None:
    """Return the map of a world file: ours, or `map.yaml` beside a `world.sdf`; or None."""
    folder = world.absolute().parent
    if world.name != WORLD_FILE:
        return None
    if folder.resolve() == (share_directory() / "worlds" / folder.name).resolve():
        path = map_path(folder.name)
    else:
        path = folder / MAP_FILE
    return path if path.is_file() else None


def load_map(path: str | Path) -> Grid:
    """Return the map that a Nav2 map file describes; keys that Nav2 ignores are ignored.

    Values are read as its yaml-cpp reads them, quoted or not. A rotated origin is kept as it is;
    `Grid.upright` turns such a map.

    Args:
        path: YAML file; `~/` in front means home, as it does to map_server.
    """
    path = file_of(str(path))
    written = read_yaml(path, MapError, as_written=("*", "origin.*"))
    data = OPTIONAL | written
    _check_keys(written, path)
    resolution = _number(data["resolution"], f"{path}: resolution")
    if resolution <= 0.0:
        raise MapError(f"{path}: resolution is {resolution}; it must be positive [m per pixel]")
    origin = data["origin"]
    if not isinstance(origin, list) or len(origin) != 3:
        raise MapError(f"{path}: origin [x, y, yaw] is {origin!r}; expected a list of 3 numbers")
    x, y, yaw = (_number(value, f"{path}: origin [x, y, yaw]") for value in origin)
    if not (MIN_RESOLUTION <= resolution <= MAX_RESOLUTION) or max(abs(x), abs(y)) > MAX_PLACE:
        raise MapError(
            f"{path}: resolution {resolution} m, origin ({x}, {y}); expected {MIN_RESOLUTION} to "
            f"{MAX_RESOLUTION} m per pixel, within {MAX_PLACE:g} m"
        )
    image = read_image(_image_path(path, data["image"]))
    return Grid(_cells(image, data, path)[::-1].copy(), resolution, x, y, yaw)


def save_map(grid: Grid, path: str | Path) -> None:
    """Write a grid as a YAML file and a PGM of the same name beside it.

    Args:
        grid: Cells between free and occupied become free.

    Raises:
        OSError: If a file cannot be written.
    """
    path = Path(path)
    grey = np.full(grid.cells.shape, GREY_FREE, np.uint8)
    grey[grid.cells == OCCUPIED] = GREY_OCCUPIED
    grey[grid.cells == UNKNOWN] = GREY_UNKNOWN
    _write_image(path, grey)
    path.write_text(
        f"image: {path.stem}.pgm\nmode: trinary\nresolution: {grid.resolution:g}\n"
        f"origin: [{grid.origin_x:.12g}, {grid.origin_y:.12g}, {float(grid.origin_yaw)!r}]\n"
        "negate: 0\noccupied_thresh: 0.65\nfree_thresh: 0.196\n",
        encoding="utf-8",
    )


def save_mask(mask: Grid, path: Path, **more: Any) -> None:
    """Write a filter mask of Nav2, as a YAML file and a PGM of the same name beside it.

    Args:
        mask: Cells from 0 to 100.
        more: Further keys of the file.
    """
    _write_image(path, mask.cells.astype(np.uint8))
    keys = {
        "image": f"{path.stem}.pgm", "mode": "raw", "resolution": mask.resolution,
        "origin": [mask.origin_x, mask.origin_y, 0.0], "negate": 0, "occupied_thresh": 0.65,
        "free_thresh": 0.196, "type": 0, "base": 0.0, "multiplier": 1.0,
    }  # fmt: skip
    path.write_text(yaml.safe_dump(keys | more, sort_keys=False), encoding="utf-8")


def _write_image(path: Path, pixels: NDArray[np.uint8]) -> None:
    """Write a PGM beside a map file; row 0 is the lowest y."""
    height, width = pixels.shape
    head = f"P5\n{width} {height}\n255\n".encode()
    path.with_suffix(".pgm").write_bytes(head + pixels[::-1].tobytes())


def _check_keys(data: dict[str, Any], path: Path) -> None:
    """Refuse a file without a key that it needs, or with one that is misspelt."""
    missing = [key for key in REQUIRED if key not in data]
    if missing:
        raise MapError(f"{path} lacks {', '.join(missing)}")
    free = [key for key in OPTIONAL if key not in data]
    for key in data.keys() - {*REQUIRED, *OPTIONAL}:
        meant = close_names(key, free, 1)
        if meant:
            raise MapError(f"{path}: unknown key '{key}'; did you mean '{meant[0]}'?")


def _number(value: object, what: str) -> float:
    if not isinstance(value, str) or not NUMBER.fullmatch(value.strip()):
        raise MapError(f"{what} is {value!r}; expected a number")
    number = float(value)
    if not math.isfinite(number):
        raise MapError(f"{what} is {value}; expected a number")
    return number


def _is_true(value: object, what: str) -> bool:
    """Return an integer or a truth value, which yaml-cpp writes in lower, upper or title case."""
    text = value.strip() if isinstance(value, str) else ""
    if INTEGER.fullmatch(text):
        return text.lstrip("+-0xX") != ""
    if text in (text.lower(), text.upper(), text.capitalize()) and text.lower() in TRUE + FALSE:
        return text.lower() in TRUE
    raise MapError(f"{what} is {value!r}; expected 0 or 1")


def _cells(image: MapImage, data: dict[str, Any], path: Path) -> NDArray[np.int8]:
    mode = str(data["mode"]).lower()
    if mode not in MODES:
        raise MapError(f"{path}: mode is {data['mode']!r}; expected one of {', '.join(MODES)}")
    low = _number(data["free_thresh"], f"{path}: free_thresh")
    high = _number(data["occupied_thresh"], f"{path}: occupied_thresh")
    is_negated = _is_true(data["negate"], f"{path}: negate")
    if not 0.0 <= low <= high <= 1.0:
        raise MapError(
            f"{path}: free_thresh {low}, occupied_thresh {high}; "
            "expected 0 <= free_thresh <= occupied_thresh <= 1"
        )
    shade = image.shade(with_alpha=mode == "trinary")  # Nav2 averages alpha in here only
    if mode == "raw":  # Nav2 does not negate here
        values = np.floor(shade * 255.0 + 0.5)
        return np.where(values <= OCCUPIED, values, UNKNOWN).astype(np.int8)
    occupancy = shade if is_negated else 1.0 - shade
    between = np.full(shade.shape, UNKNOWN, np.int8)
    if mode == "scale" and high > low:
        between = np.rint((occupancy - low) / (high - low) * 100.0).clip(0, 100).astype(np.int8)
    cells = np.where(occupancy > high, OCCUPIED, np.where(occupancy < low, 0, between))
    if mode == "scale" and image.alpha is not None:
        cells[image.alpha < TOP] = UNKNOWN
    return cells.astype(np.int8)


def _image_path(path: Path, name: object) -> Path:
    if not isinstance(name, str) or not name or "\0" in name:
        raise MapError(f"{path}: image is {name!r}; expected a file name")
    image = path.parent / file_of(name)  # an absolute name replaces the folder
    if not image.is_file():
        raise MapImageError(f"{path}: image '{name}' is missing; looked for {image}")
    return image
