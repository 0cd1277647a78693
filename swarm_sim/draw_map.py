"""Command that draws a world's map: `python -m swarm_sim.draw_map WORLD -o maps/`."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

import numpy as np

from swarm_common.errors import SwarmError
from swarm_common.grid import Grid
from swarm_common.map_io import save_map
from swarm_sim.raster import draw_grid
from swarm_sim.scene import Scene
from swarm_sim.sdf import load_world
from swarm_sim.section import FloatArray, section_between

SCAN_HEIGHT = 0.132  # [m] above ground of a TurtleBot3 waffle's scan plane


def draw_world(scene: Scene, height: float = SCAN_HEIGHT, resolution: float = 0.05) -> Grid:
    """Return the map that a LiDAR at this height would make of a world."""
    section = section_between(scene.fixed, height, height)
    return draw_grid(section, accessible_points(scene), resolution)


def accessible_points(scene: Scene) -> FloatArray:
    """Return the points (n, 2) that robots must be able to reach: stations and circuits."""
    points = [(pose.x, pose.y) for pose in scene.sites.stations.values()]
    for circuit in scene.sites.circuits.values():
        points.extend(circuit)
    return np.array(points, dtype=np.float64).reshape(-1, 2)


def main(arguments: list[str] | None = None) -> int:
    """Draw the map of one world; return the exit code."""
    parser = argparse.ArgumentParser(prog="draw_map", description=main.__doc__)
    parser.add_argument("world", help="name in worlds/ or path of an SDF file")
    parser.add_argument("-o", "--output", type=Path, default=Path("."), help="folder to write to")
    parser.add_argument("--height", type=float, default=SCAN_HEIGHT, help="of the cut [m]")
    parser.add_argument("--resolution", type=float, default=0.05, help="[m] per cell")
    options = parser.parse_args(arguments)
    try:
        scene = load_world(options.world)
        grid = draw_world(scene, options.height, options.resolution)
        options.output.mkdir(parents=True, exist_ok=True)
        save_map(grid, options.output / f"{scene.name}.yaml")
    except (SwarmError, OSError) as error:
        sys.stderr.write(f"{error}\n")
        return 2
    return 0


if __name__ == "__main__":
    sys.exit(main())
