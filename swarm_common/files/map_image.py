"""Images of maps as Nav2's map_server sees them: brightness of each pixel, and its opacity.

nav2_map_server reads images by GraphicsMagick with 16 bits per channel: 8-bit values are spread,
the mean of the colours is cut to a whole number, and alpha is kept apart. Binary and text PGM are
read here, other types by Pillow.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from swarm_common.model.errors import MapImageError

TOP = 65535  # of a channel
MAX_PIXELS = 100_000_000


@dataclass(frozen=True, slots=True)
class MapImage:
    """Pixels, the first row at the top."""

    colors: NDArray[np.uint16]  # uint16 (height, width, channels): grey, or red, green, blue
    # uint16 (height, width), 65535 is opaque; None if the image has no transparency
    alpha: NDArray[np.uint16] | None = None

    def shade(self, with_alpha: bool = False) -> NDArray[np.float64]:
        """Return the brightness of each pixel from 0 to 1.

        Args:
            with_alpha: Whether opacity counts as a colour beside red, green and blue.
        """
        sums = self.colors.sum(axis=2, dtype=np.int64) * (3 // self.colors.shape[2])
        count = 3
        if with_alpha and self.alpha is not None:
            sums, count = sums + self.alpha, 4
        shades: NDArray[np.float64] = (sums // count) / TOP
        return shades


def read_image(image: Path) -> MapImage:
    """Return the pixels in a file."""
    try:
        data = image.read_bytes()
    except OSError as cause:
        raise MapImageError(f"cannot read {image}: {cause}") from cause
    if data[:2] in (b"P5", b"P2"):
        return MapImage(_read_pgm(data, image)[:, :, None])
    return _read_with_pillow(image)


def _read_pgm(data: bytes, image: Path) -> NDArray[np.uint16]:
    words, position = _pgm_header(data, image)
    try:
        width, height, top = (int(word) for word in words)
    except ValueError as cause:
        raise MapImageError(f"{image}: the PGM header is malformed: {words}") from cause
    if width <= 0 or height <= 0 or not 0 < top <= TOP:
        raise MapImageError(f"{image}: the PGM header says {width} x {height} pixels up to {top}")
    _check_size(width, height, image)
    if data[:2] == b"P5":
        body = data[position + 1 :]
        wide = np.frombuffer(body, ">u2" if top > 255 else "u1", len(body) // (1 + (top > 255)))
    else:
        try:
            wide = np.array(data[position:].split(), dtype=np.int64)
        except (ValueError, OverflowError) as cause:
            raise MapImageError(f"{image}: a pixel is not a number: {cause}") from cause
    if len(wide) < width * height:
        raise MapImageError(
            f"{image}: the header says {width} x {height} pixels, the file holds {len(wide)}"
        )
    pixels = wide[: width * height].reshape(height, width).astype(np.float64)
    return np.rint(pixels * (TOP / top)).clip(0, TOP).astype(np.uint16)


def _pgm_header(data: bytes, image: Path) -> tuple[list[bytes], int]:
    """Return width, height and largest value as written, and where the header ends."""
    words: list[bytes] = []
    position = 2
    while len(words) < 3:
        while position < len(data) and data[position : position + 1].isspace():
            position += 1
        if position >= len(data):
            raise MapImageError(f"{image}: the PGM header is cut off")
        if data[position : position + 1] == b"#":
            position = data.find(b"\n", position) + 1 or len(data)
            continue
        start = position
        while position < len(data) and not data[position : position + 1].isspace():
            position += 1
        words.append(data[start:position])
    return words, position


def _read_with_pillow(image: Path) -> MapImage:
    from PIL import Image

    try:
        with Image.open(image) as opened:
            _check_size(opened.width, opened.height, image)
            return _from_pillow(opened)
    except (OSError, ValueError, SyntaxError, Image.DecompressionBombError) as cause:
        raise MapImageError(f"{image}: cannot read the image: {cause}") from cause


def _from_pillow(opened: Any) -> MapImage:
    if opened.mode in ("I", "F") or opened.mode.startswith("I;"):  # 16 bits of grey
        grey = np.asarray(opened).astype(np.float64)
        return MapImage(np.rint(grey).clip(0, TOP).astype(np.uint16)[:, :, None])
    has_alpha = "A" in opened.getbands() or "transparency" in opened.info
    pixels = np.asarray(opened.convert("RGBA")).astype(np.uint16) * np.uint16(257)
    return MapImage(pixels[..., :3], pixels[..., 3] if has_alpha else None)


def _check_size(width: int, height: int, image: Path) -> None:
    if width * height > MAX_PIXELS:
        raise MapImageError(
            f"{image}: {width} x {height} pixels; expected at most {MAX_PIXELS:.0e} in all"
        )
