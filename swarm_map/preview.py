"""A picture of a world for its author: walls, stations with names and headings, the start."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np

from swarm_common.files.map_io import MAP_FILE, load_map
from swarm_common.model.errors import ConfigError
from swarm_common.model.grid import OCCUPIED, Grid
from swarm_common.model.sites import SpawnArea, SpawnAreas
from swarm_describe.worlds.scene import Scene

FILE = "preview.png"
LONGER_SIDE = 1000  # pixels, about
WALL, STATION, START = (60, 60, 60), (0, 130, 60), (0, 90, 200)


def write_preview(scene: Scene) -> Path:
    """Draw a world beside its file; return the picture.

    Raises:
        ConfigError: If it cannot be written.
    """
    from PIL import Image, ImageDraw

    grid = load_map(scene.file.with_name(MAP_FILE))
    scale = max(1, round(LONGER_SIDE / max(grid.cells.shape)))
    pixels = np.full((*grid.cells.shape, 3), 255, np.uint8)
    pixels[grid.cells == OCCUPIED] = WALL
    size = (scale * grid.width, scale * grid.height)
    image = Image.fromarray(pixels[::-1]).resize(size, Image.Resampling.NEAREST)
    draw = ImageDraw.Draw(image)
    spawn = scene.sites.spawn
    areas = spawn.areas if isinstance(spawn, SpawnAreas) else (spawn,)
    for area in areas:
        if isinstance(area, SpawnArea):
            corners = (area.x_min, area.y_max), (area.x_max, area.y_min)
            draw.rectangle(
                [_at(grid, scale, *corner) for corner in corners], outline=START, width=2
            )
    for name, pose in scene.sites.stations.items():
        x, y = _at(grid, scale, pose.x, pose.y)
        radius = max(4, round(0.2 / grid.resolution * scale))
        draw.ellipse((x - radius, y - radius, x + radius, y + radius), fill=STATION)
        tip = x + 2 * radius * math.cos(pose.yaw), y - 2 * radius * math.sin(pose.yaw)
        draw.line((x, y, *tip), fill=STATION, width=2)
        draw.text((x + radius + 3, y - 6), name, fill="black", stroke_width=2, stroke_fill="white")
    path = scene.file.with_name(FILE)
    try:
        image.save(path, format="PNG")
    except OSError as cause:
        raise ConfigError(f"cannot write the picture {path}: {cause}") from cause
    return path


def _at(grid: Grid, scale: int, x: float, y: float) -> tuple[float, float]:
    column = (x - grid.origin_x) / grid.resolution
    row = grid.height - (y - grid.origin_y) / grid.resolution
    return scale * column, scale * row
