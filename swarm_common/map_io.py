"""Reading and writing of maps in Nav2's format: a YAML file beside a greyscale image.

The rules are those of nav2_map_server (map_io.cpp): modes trinary, scale and raw, `negate`,
thresholds, alpha. Binary and text PGM are read here, other image types by Pillow.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from swarm_common.errors import MapError
from swarm_common.grid import OCCUPIED, UNKNOWN, Grid
from swarm_common.resources import share_directory
from swarm_common.yaml_io import number, numbers, read_yaml

MODES = ("trinary", "scale", "raw")
OPTIONAL = {"mode": "trinary", "negate": 0, "occupied_thresh": 0.65, "free_thresh": 0.25}
GREY_FREE, GREY_UNKNOWN, GREY_OCCUPIED = 254, 205, 0


def map_path(name: str) -> Path:
    """Return where the map that ships with a world is, whether it exists or not."""
    return share_directory() / "maps" / f"{name}.yaml"


def load_map(path: str | Path) -> Grid:
    """Return the map that a Nav2 map file describes; keys that Nav2 ignores are ignored.

    Raises:
        MapError: If the file or its image is missing or unusable.
    """
    path = Path(path)
    data = OPTIONAL | read_yaml(path, MapError)
    missing = [key for key in ("image", "resolution", "origin") if key not in data]
    if missing:
        raise MapError(f"{path} lacks {', '.join(missing)}")
    resolution = number(data["resolution"], f"{path}: resolution", MapError)
    if resolution <= 0.0:
        raise MapError(f"{path}: resolution is {resolution}; it must be positive [m per pixel]")
    x, y, yaw = numbers(data["origin"], 3, f"{path}: origin [x, y, yaw]", MapError)
    if yaw != 0.0:
        raise MapError(
            f"{path}: origin is rotated by {yaw} rad; only maps with yaw 0 are supported"
        )
    grey, alpha = _read_image(path, data["image"])
    return Grid(_cells(grey, alpha, data, path)[::-1].copy(), resolution, x, y)


def save_map(grid: Grid, path: str | Path) -> None:
    """Write a grid as `<path>` and a PGM of the same name beside it."""
    path = Path(path)
    grey = np.full(grid.cells.shape, GREY_FREE, np.uint8)
    grey[grid.cells == OCCUPIED] = GREY_OCCUPIED
    grey[grid.cells == UNKNOWN] = GREY_UNKNOWN
    head = f"P5\n{grid.width} {grid.height}\n255\n".encode()
    path.with_suffix(".pgm").write_bytes(head + grey[::-1].tobytes())
    path.write_text(
        f"image: {path.stem}.pgm\nmode: trinary\nresolution: {grid.resolution:g}\n"
        f"origin: [{grid.origin_x:.9g}, {grid.origin_y:.9g}, 0.0]\n"
        "negate: 0\noccupied_thresh: 0.65\nfree_thresh: 0.196\n",
        encoding="utf-8",
    )


def _cells(
    grey: NDArray[np.uint8], alpha: NDArray[np.uint8] | None, data: dict[str, Any], path: Path
) -> NDArray[np.int8]:
    mode = data["mode"]
    if mode not in MODES:
        raise MapError(f"{path}: mode is {mode!r}; expected one of {', '.join(MODES)}")
    low = number(data["free_thresh"], f"{path}: free_thresh", MapError)
    high = number(data["occupied_thresh"], f"{path}: occupied_thresh", MapError)
    if not 0.0 <= low <= high <= 1.0:
        raise MapError(
            f"{path}: free_thresh {low}, occupied_thresh {high}; "
            "expected 0 <= free_thresh <= occupied_thresh <= 1"
        )
    if data["negate"] not in (0, 1):
        raise MapError(f"{path}: negate is {data['negate']!r}; expected 0 or 1")
    if mode == "raw":  # Nav2 does not negate here
        return np.where(grey <= 100, grey, UNKNOWN).astype(np.int8)
    shade = grey / 255.0
    if mode == "trinary" and alpha is not None:  # Nav2 counts alpha as a fourth colour here
        shade = (3.0 * shade + alpha / 255.0) / 4.0
    occupancy = shade if data["negate"] else 1.0 - shade
    between = np.full(grey.shape, UNKNOWN, np.int8)
    if mode == "scale" and high > low:
        between = np.rint(100.0 * (occupancy - low) / (high - low)).clip(0, 100).astype(np.int8)
    cells = np.where(occupancy > high, OCCUPIED, np.where(occupancy < low, 0, between))
    if mode == "scale" and alpha is not None:
        cells[alpha < 255] = UNKNOWN
    return cells.astype(np.int8)


def _read_image(path: Path, name: object) -> tuple[NDArray[np.uint8], NDArray[np.uint8] | None]:
    if not isinstance(name, str) or not name:
        raise MapError(f"{path}: image is {name!r}; expected a file name")
    image = path.parent / name  # an absolute name replaces the folder
    if not image.is_file():
        raise MapError(f"{path}: image '{name}' is missing; looked for {image}")
    data = image.read_bytes()
    if data[:2] in (b"P5", b"P2"):
        return _read_pgm(data, image), None
    return _read_with_pillow(image)


def _read_pgm(data: bytes, image: Path) -> NDArray[np.uint8]:
    words: list[bytes] = []
    position = 2
    while len(words) < 3:
        end = data.find(b"\n", position)
        if end < 0 and position >= len(data):
            raise MapError(f"{image}: the PGM header is cut off")
        while position < len(data) and data[position : position + 1].isspace():
            position += 1
        if data[position : position + 1] == b"#":
            position = data.find(b"\n", position) + 1 or len(data)
            continue
        start = position
        while position < len(data) and not data[position : position + 1].isspace():
            position += 1
        words.append(data[start:position])
    try:
        width, height, top = (int(word) for word in words)
    except ValueError as cause:
        raise MapError(f"{image}: the PGM header is malformed: {words}") from cause
    if data[:2] == b"P5":
        body = data[position + 1 :]
        wide = np.frombuffer(body, ">u2" if top > 255 else "u1", len(body) // (1 + (top > 255)))
    else:
        wide = np.array(data[position:].split(), dtype=np.int64)
    if width <= 0 or height <= 0 or not 0 < top < 65536 or len(wide) < width * height:
        raise MapError(
            f"{image}: the header says {width} x {height} pixels up to {top}, "
            f"the file holds {len(wide)}"
        )
    pixels = wide[: width * height].reshape(height, width).astype(np.float64)
    return np.rint(pixels * (255.0 / top)).clip(0, 255).astype(np.uint8)


def _read_with_pillow(image: Path) -> tuple[NDArray[np.uint8], NDArray[np.uint8] | None]:
    try:
        from PIL import Image
    except ImportError as cause:
        raise MapError(
            f"{image}: only PGM can be read without Pillow; pip install pillow"
        ) from cause
    try:
        with Image.open(image) as opened:
            has_alpha = "A" in opened.getbands() or "transparency" in opened.info
            pixels = np.asarray(opened.convert("RGBA"))
    except OSError as cause:
        raise MapError(f"{image}: cannot read the image: {cause}") from cause
    # Nav2 averages the colours without weights.
    grey = np.rint(pixels[..., :3].mean(axis=2)).astype(np.uint8)
    return grey, pixels[..., 3] if has_alpha else None
