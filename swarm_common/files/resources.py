"""Folders of the data that ships with the project: robots, worlds, maps, params, interfaces."""

from __future__ import annotations

import os
from collections.abc import Iterable
from pathlib import Path
from urllib.parse import unquote, urlsplit

from swarm_common.files.fuel import name_in_fuel
from swarm_common.files.other_worlds import refuse_plan
from swarm_common.model.errors import ConfigError, SwarmError, UnknownNameError
from swarm_common.process.home import home_folder

SHARE_VARIABLE = "SWARM_SHARE"
WORLD_ENDINGS = (".sdf", ".world", ".xacro")


def share_directory(kind: str = "worlds") -> Path:
    """Return the folder that holds `robots`, `worlds`, `maps`, `params` and `interfaces`.

    `SWARM_SHARE` overrides; then an installed wheel's `swarm_common/data`; then the checkout that
    this file is in.

    Raises:
        SwarmError: If no such folder exists.
    """
    package = Path(__file__).resolve().parents[1]
    candidates = [package / "data", package.parent]
    if SHARE_VARIABLE in os.environ:
        candidates.insert(0, Path(os.environ[SHARE_VARIABLE]))
    for directory in candidates:
        if (directory / kind).is_dir():
            return directory
    places = ", ".join(str(directory) for directory in candidates)
    raise SwarmError(f"no folder '{kind}' in {places}; set {SHARE_VARIABLE} to the folder with it")


def find_resource(kind: str, name_or_path: str | Path, file_name: str) -> Path:
    """Return the file `<kind>s/<name>/<file_name>`, or the user's own path.

    Args:
        kind: ``robot`` or ``world``.
        name_or_path: Name of a shipped folder, a path to a folder or file, or a URI of Fuel.
    """
    path = Path(name_or_path)
    if kind == "world" and "://" in str(name_or_path):
        return _world_of_fuel(str(name_or_path))
    if path.is_file():
        if kind == "world":
            refuse_plan(path)
        return path
    if (path / file_name).is_file() and os.sep in str(name_or_path):
        return path / file_name
    home = share_directory() / f"{kind}s"
    shipped = home / str(name_or_path) / file_name
    if len(path.parts) == 1 and shipped.is_file():
        return shipped
    if (path / file_name).is_file():  # a folder of the user's, where we have none of that name
        return path / file_name
    own = [str(file.parent) for file in path.parent.glob(f"*/{file_name}")]
    raise UnknownNameError(kind, str(name_or_path), [*resource_names(kind, file_name), *own])


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
        file for folder in folders if folder.is_dir() for file in sorted(folder.iterdir())
        if file.suffix in WORLD_ENDINGS
    ]  # fmt: skip
    if not files:
        raise ConfigError(
            f"'{uri}' was not downloaded: looked for {folders[0]}; get it with "
            f"'gz fuel download -u {uri}'"
        )
    if len({file.name for file in files}) > 1:
        places = ", ".join(map(str, files))
        raise ConfigError(f"'{uri}' has several worlds; give the path of one: {places}")
    return files[0]


def file_of(text: str) -> Path:
    """Return the file that a path or a `file://` URL names.

    A path is taken as written (`#`, `?` and `%20` are part of it); `~/` in front means home. A URL
    that nobody quoted is taken as written, too, if only that file is there.
    """
    if not text.startswith("file://"):
        return Path(os.path.expanduser(text) if text.startswith("~/") else text)
    url = urlsplit(text)
    quoted = Path(unquote(url.netloc.removeprefix("localhost") + url.path))
    unquoted = Path(text.removeprefix("file://"))
    return unquoted if unquoted.is_file() and not quoted.is_file() else quoted


def names_to_propose(name: str, shipped: Iterable[str]) -> list[str]:
    """Return the YAML file of that name in the current folder; without one, what ships with us."""
    own = [f"./{name}{suffix}" for suffix in (".yaml", ".yml") if Path(f"{name}{suffix}").is_file()]
    return own or sorted(shipped)


def resource_names(kind: str, file_name: str) -> list[str]:
    """Return the names of all shipped folders of a kind, sorted."""
    home = share_directory() / f"{kind}s"
    return sorted(path.parent.name for path in home.glob(f"*/{file_name}"))
