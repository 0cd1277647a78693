"""Where a world is: one of `worlds/`, the user's own, or one that came from Gazebo Fuel."""

from __future__ import annotations

import os
from pathlib import Path

from swarm_common.files.resources import resource_names, share_directory
from swarm_common.model.errors import ConfigError, UnknownNameError
from swarm_common.process.home import home_folder
from swarm_describe.files.fuel import name_in_fuel
from swarm_describe.worlds.other_worlds import refuse_plan

WORLD_FILE = "world.sdf"
SITES_FILE = "sites.yaml"
WORLD_ENDINGS = (".sdf", ".world", ".xacro")


def world_names() -> list[str]:
    """Return the names of the worlds that ship with the project."""
    return resource_names("world", WORLD_FILE)


def find_world(name_or_path: str | Path, file_name: str = WORLD_FILE) -> Path:
    """Return a file of a world, or the user's own path.

    Args:
        name_or_path: Name of a shipped folder, a path to a folder or file, or a URI of Fuel.
        file_name: Name of the file in the world's folder.
    """
    path = Path(name_or_path)
    if "://" in str(name_or_path):
        return _world_of_fuel(str(name_or_path))
    if path.is_file():
        refuse_plan(path)
        return path
    own, shipped = path / file_name, share_directory() / "worlds" / path / file_name
    places = [shipped, own] if len(path.parts) == 1 else [own]
    for place in reversed(places) if os.sep in str(name_or_path) else places:
        if place.is_file():
            return place
    near = [str(file.parent) for file in path.parent.glob(f"*/{file_name}")]
    raise UnknownNameError("world", str(name_or_path), [*resource_names("world", file_name), *near])


def _world_of_fuel(uri: str) -> Path:
    """Return the file of a world that was downloaded from Gazebo Fuel."""
    name = name_in_fuel(uri)
    if name is None or name.kind != "worlds":
        raise ConfigError(
            f"'{uri}' is no world of Gazebo Fuel; expected https://fuel.gazebosim.org/1.0/"
            "OWNER/worlds/NAME, or the path of a file"
        )
    folders = list(name.cached(home_folder(), os.environ))
    files = [
        file
        for folder in folders
        if folder.is_dir()
        for file in sorted(folder.iterdir())
        if file.suffix in WORLD_ENDINGS
    ]
    if not files:
        raise ConfigError(
            f"'{uri}' was not downloaded: looked for {folders[0]}; get it with "
            f"'gz fuel download -u {uri}'"
        )
    if len({file.name for file in files}) > 1:
        places = ", ".join(map(str, files))
        raise ConfigError(f"'{uri}' has several worlds; give the path of one: {places}")
    return files[0]
