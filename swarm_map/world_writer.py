"""Writing of worlds: SDF, sites and map of a floor plan, in one folder."""

from __future__ import annotations

import json
import tempfile
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any
from xml.sax.saxutils import quoteattr

import yaml

from swarm_common.files.layout_io import LAYOUT_FILE
from swarm_common.files.map_io import MAP_FILE, save_map
from swarm_common.model.errors import ConfigError
from swarm_common.model.grid import COARSEST
from swarm_common.model.shapes import Box, Cylinder
from swarm_describe.robots.loading import load_robot
from swarm_describe.worlds.reader import load_world
from swarm_describe.worlds.scene import Scene
from swarm_describe.worlds.world_file import SITES_FILE, WORLD_FILE
from swarm_map.floor_plan import FloorPlan, Thing
from swarm_sim.maps.check import check_sites
from swarm_sim.maps.draw_map import SCAN_HEIGHT, draw_world, reach_of

ROBOT = "turtlebot3_waffle"  # that must fit at every station
SDF_VERSION = "1.7"
GROUND = """    <model name="ground_plane">
      <static>true</static>
      <link name="link">
        <collision name="collision">
          <geometry><plane><normal>0 0 1</normal><size>200 200</size></plane></geometry>
        </collision>
      </link>
    </model>
"""
MODEL = """    <model name={name}>
      <static>{static}</static>
      <pose>{pose}</pose>
      <link name="link">{inertial}
        <collision name="collision">
          <geometry>{geometry}</geometry>{surface}
        </collision>
        <visual name="visual">
          <geometry>{geometry}</geometry>
          <material><diffuse>{color}</diffuse></material>
        </visual>
      </link>
    </model>
"""
INERTIAL = """
        <inertial>
          <mass>{mass:g}</mass>
          <inertia>
            <ixx>{x:.6g}</ixx><iyy>{y:.6g}</iyy><izz>{z:.6g}</izz>
            <ixy>0</ixy><ixz>0</ixz><iyz>0</iyz>
          </inertia>
        </inertial>"""
SURFACE = """
          <surface><friction><ode><mu>{mu:g}</mu><mu2>{mu:g}</mu2></ode></friction></surface>"""


def write_world(plan: FloorPlan, folder: Path, resolution: float = 0.05) -> Scene:
    """Write `world.sdf`, `sites.yaml` and `map.yaml` with its image; return the world as read.

    They are written beside the folder first: it changes only if all of them are usable. Cells of
    the map have `resolution` [m], or less if navigation needs it.
    """
    home = next(parent for parent in folder.absolute().parents if parent.is_dir())
    try:
        with tempfile.TemporaryDirectory(dir=home, prefix=f".{folder.name}-") as name:
            draft = Path(name) / folder.name
            scene = _write(plan, draft, resolution)
            folder.mkdir(parents=True, exist_ok=True)
            for file in draft.iterdir():
                file.replace(folder / file.name)
    except OSError as cause:
        raise ConfigError(f"cannot write {folder}: {cause}") from cause
    return replace(scene, file=folder / WORLD_FILE)


def _write(plan: FloorPlan, folder: Path, resolution: float) -> Scene:
    folder.mkdir()
    (folder / WORLD_FILE).write_text(sdf_text(plan), encoding="utf-8")
    (folder / SITES_FILE).write_text(sites_text(plan.sites), encoding="utf-8")
    if plan.layout is not None:
        text = json.dumps(plan.layout, indent=1)
        (folder / LAYOUT_FILE).write_text(text, encoding="utf-8")
    scene = load_world(folder / WORLD_FILE)
    robot = load_robot(ROBOT)
    check_sites(scene, robot)
    resolution, reach = min(resolution, COARSEST), reach_of([robot])
    save_map(draw_world(scene, SCAN_HEIGHT, resolution, reach=reach), folder / MAP_FILE)
    return scene


def sdf_text(plan: FloorPlan) -> str:
    """Return the SDF of a plan."""
    models = "".join(_model(thing) for thing in plan.things)
    return (
        f'<?xml version="1.0"?>\n<sdf version="{SDF_VERSION}">\n'
        f"  <world name={quoteattr(plan.name)}>\n{GROUND}{models}  </world>\n</sdf>\n"
    )


def sites_text(sites: Mapping[str, Any]) -> str:
    """Return `sites.yaml`: one line per station, place or point."""
    lines = ["# Places in the map frame: [x, y, yaw]."]
    for key, value in sites.items():
        if isinstance(value, dict) and key != "spawn":
            lines.append(f"{key}:")
            for name, item in value.items():
                text = yaml.safe_dump(name, width=10_000, allow_unicode=True).partition("\n")[0]
                lines.append(f"  {text}: {_flow(item)}")
        elif isinstance(value, list):
            lines.append(f"{key}:")
            lines += [f"  - {_flow(item)}" for item in value]
        else:
            lines.append(f"{key}: {_flow(value)}")
    return "\n".join(lines) + "\n"


def _flow(value: object) -> str:
    return yaml.safe_dump(value, default_flow_style=True, width=10_000, sort_keys=False).strip()


def _model(thing: Thing) -> str:
    shape, is_loose = thing.shape, thing.mass is not None
    if isinstance(shape, Box):
        x, y, height = shape.size
        geometry = f"<box><size>{x:.9g} {y:.9g} {height:.9g}</size></box>"
    else:
        height = shape.length
        sizes = f"<radius>{shape.radius:.9g}</radius><length>{height:.9g}</length>"
        geometry = f"<cylinder>{sizes}</cylinder>"
    z = thing.z + height / 2.0
    return MODEL.format(
        name=quoteattr(thing.name),
        static="false" if is_loose else "true",
        pose=f"{thing.x:.9g} {thing.y:.9g} {z:.9g} 0 0 {thing.yaw:.9g}",
        inertial=_inertial(thing) if is_loose else "",
        geometry=geometry,
        surface=SURFACE.format(mu=thing.friction) if is_loose else "",
        color=" ".join(f"{part:g}" for part in thing.color),
    )


def _inertial(thing: Thing) -> str:
    mass = thing.mass or 0.0
    if isinstance(thing.shape, Cylinder):
        across = mass * (3.0 * thing.shape.radius**2 + thing.shape.length**2) / 12.0
        return INERTIAL.format(mass=mass, x=across, y=across, z=mass * thing.shape.radius**2 / 2.0)
    x, y, z = (edge * edge for edge in thing.shape.size)
    scale = mass / 12.0
    return INERTIAL.format(mass=mass, x=scale * (y + z), y=scale * (x + z), z=scale * (x + y))
