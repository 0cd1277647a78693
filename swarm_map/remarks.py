"""Remarks for the author of a floor plan on the world made of it, and the record of them."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from math import hypot
from pathlib import Path
from typing import Any

import numpy as np

from swarm_common.files.sites_io import load_sites
from swarm_common.files.yaml_io import read_yaml
from swarm_describe.robots.loading import load_robot
from swarm_describe.worlds.scene import GROUND_GAP, Scene
from swarm_map.floor_plan import FloorPlan
from swarm_map.world_writer import ROBOT
from swarm_sim.scene.section import section_between

TALLEST = 1000.0  # [m]
MOST_STATIONS = 12  # that are told with their places
SAME = 0.5  # [m] between a station and the one of the same name before


def size_of(scene: Scene) -> tuple[float, float]:
    """Return how far the obstacles of a world reach [m], along x and y."""
    x_min, y_min, x_max, y_max = section_between(scene.bodies, GROUND_GAP, TALLEST).bounds()
    return x_max - x_min, y_max - y_min


def stations_in_words(scene: Scene) -> str:
    """Return the stations of a world with their places."""
    stations = scene.sites.stations
    words = [f"{name} at ({pose.x:.1f}, {pose.y:.1f})" for name, pose in stations.items()]
    more = [f"{len(words) - MOST_STATIONS} more"] if len(words) > MOST_STATIONS else []
    return ", ".join([*words[:MOST_STATIONS], *more])


def close_stations(scene: Scene) -> Iterator[str]:
    """Yield a sentence if robots at two stations would touch each other."""
    from scipy.spatial import cKDTree

    names = [*scene.sites.stations]
    points = [(pose.x, pose.y) for pose in scene.sites.stations.values()]
    spec = load_robot(ROBOT)
    width = 2.0 * spec.circumscribed_radius
    pairs = cKDTree(points).query_pairs(width) if points else set()
    if pairs:
        gap, a, b = min((hypot(*np.subtract(points[a], points[b])), a, b) for a, b in pairs)
        more = f"; so are {len(pairs) - 1} more pairs" if len(pairs) > 1 else ""
        yield (
            f"{names[a]} and {names[b]} are only {gap:.2f} m apart{more}: two robots do not fit "
            f"there at a time (a {spec.model} is {width:.2f} m across)"
        )


def with_known_stations(plan: FloorPlan, sites_file: Path) -> FloorPlan:
    """Return a picture's plan with names and headings of the same places in `sites.yaml`."""
    new: dict[str, Any] = dict(plan.sites.get("stations", {}))
    old = load_sites(sites_file).stations
    gaps = sorted(
        (hypot(pose.x - x, pose.y - y), name, before)
        for name, (x, y, _) in new.items()
        for before, pose in old.items()
    )
    kept: dict[str, str] = {}  # old names by new ones
    for gap, name, before in gaps:
        if gap <= SAME and name not in kept and before not in kept.values():
            kept[name] = before
    free = (name for name in new if name not in kept.values())
    stations = {}
    for name, (x, y, yaw) in new.items():
        if name in kept:
            stations[kept[name]] = [x, y, old[kept[name]].yaw]
        else:
            stations[next(free)] = [x, y, yaw]
    written = read_yaml(sites_file, may_be_empty=True)
    others = {key: value for key, value in written.items() if key not in (*plan.sites, "stations")}
    named = [name for name in stations if name in kept.values()]
    if not named and not others:
        return plan
    note = f"kept of {sites_file}: {', '.join([*named, *others])}"
    sites = {**plan.sites, **({"stations": stations} if stations else {}), **others}
    return replace(plan, sites=sites, notes=(*plan.notes, note))
