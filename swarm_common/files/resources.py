"""Where the data that ships with the project lives: robots, worlds, maps, params, interfaces."""

from __future__ import annotations

import os
from collections.abc import Iterable
from pathlib import Path

from swarm_common.model.errors import ConfigError, SwarmError, UnknownNameError

SHARE_VARIABLE = "SWARM_SHARE"
PLANS = (".yaml", ".yml", ".png", ".jpg", ".jpeg", ".bmp", ".gif", ".map")  # no worlds yet


def share_directory(kind: str = "worlds") -> Path:
    """Return the folder that holds `robots`, `worlds`, `maps`, `params` and `interfaces`.

    `SWARM_SHARE` overrides; then an installed wheel's `swarm_common/data`; then the checkout that
    this file is in.

    Args:
        kind: Sub-folder that must be there.

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
        name_or_path: Name of a shipped folder, or a path to a folder or file.
        file_name: File to look for in a folder.

    Raises:
        UnknownNameError: If it is neither a shipped name nor an existing path.
        ConfigError: If a world is a floor plan.
    """
    path = Path(name_or_path)
    if kind == "world" and path.suffix.lower() in PLANS and path.is_file():
        raise ConfigError(
            f"{path} is a floor plan; build a world of it first: swarm-map new {path}"
        )
    if path.is_file():
        return path
    if (path / file_name).is_file() and len(path.parts) > 1:
        return path / file_name
    home = share_directory() / f"{kind}s"
    shipped = home / str(name_or_path) / file_name
    if len(path.parts) == 1 and shipped.is_file():
        return shipped
    if (path / file_name).is_file():  # a folder of the user's, where we have none of that name
        return path / file_name
    own = [str(file.parent) for file in path.parent.glob(f"*/{file_name}")]
    raise UnknownNameError(kind, str(name_or_path), [*resource_names(kind, file_name), *own])


def names_to_propose(name: str, shipped: Iterable[str]) -> list[str]:
    """Return the YAML file of that name in the current folder; without one, what ships with us.

    Args:
        name: As given, of a file that was not found.
        shipped: Names of those that ship with us.
    """
    own = [f"./{name}{suffix}" for suffix in (".yaml", ".yml") if Path(f"{name}{suffix}").is_file()]
    return own or sorted(shipped)


def resource_names(kind: str, file_name: str) -> list[str]:
    """Return the names of all shipped folders of a kind, sorted.

    Args:
        kind: ``robot`` or ``world``.
    """
    home = share_directory() / f"{kind}s"
    return sorted(path.parent.name for path in home.glob(f"*/{file_name}"))
