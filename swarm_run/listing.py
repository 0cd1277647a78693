"""Output of `swarm-up --list`: the worlds, missions, robots and fleets that come with us."""

from __future__ import annotations

from collections.abc import Callable

from swarm_common.files.map_io import load_map
from swarm_common.files.resources import resource_names, share_directory
from swarm_common.files.sites_io import load_sites
from swarm_common.files.yaml_io import read_yaml
from swarm_describe.robots.fleet import fleet_names, load_fleet
from swarm_describe.robots.loading import load_robot
from swarm_describe.robots.source import robot_names
from swarm_mission.mission import mission_names, mission_path

ABOUT = ("description",)  # a text as written


def listing() -> str:
    """Return a section of each kind, with one line for each name."""
    return "\n\n".join(
        _section(kind, names(), about)
        for kind, names, about in (
            ("world", world_names, _world),
            ("mission", mission_names, _mission),
            ("robot", robot_names, _robot),
            ("fleet", fleet_names, _fleet),
        )
    )


def world_names() -> list[str]:
    """Return the names of the worlds."""
    return resource_names("world", "world.sdf")


def _section(kind: str, names: list[str], about: Callable[[str], str]) -> str:
    width = max(map(len, names))
    return "\n".join([f"--{kind}", *(f"  {name:<{width}}  {about(name)}" for name in names)])


def _world(name: str) -> str:
    path = share_directory() / "worlds" / name / "sites.yaml"
    about = read_yaml(path, may_be_empty=True, as_written=ABOUT).get("description") or ""
    grid = load_map(share_directory("maps") / "maps" / f"{name}.yaml")
    height, width = (count * grid.resolution for count in grid.cells.shape)
    stations = len(load_sites(path).stations)
    return f"{width:.0f} x {height:.0f} m, {stations} stations: {about}"


def _mission(name: str) -> str:
    return str(read_yaml(mission_path(name), as_written=ABOUT).get("description") or "")


def _robot(name: str) -> str:
    spec = load_robot(name)
    xs, ys = zip(*spec.footprint, strict=True)
    size = f"{max(xs) - min(xs):.2f} x {max(ys) - min(ys):.2f} m"
    return f"{size}, {spec.max_vel_x:.2f} m/s, {spec.drive} drive"


def _fleet(name: str) -> str:
    fleet = load_fleet(name)
    return f"{len(fleet.members)} robots: {fleet.label}"
