"""Where the data that ships with the project lives: robots, worlds, maps, params, interfaces."""

from __future__ import annotations

import os
from pathlib import Path

from swarm_common.model.errors import SwarmError, UnknownNameError

SHARE_VARIABLE = "SWARM_SHARE"


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
    """
    path = Path(name_or_path)
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
    raise UnknownNameError(kind, str(name_or_path), resource_names(kind, file_name))


def resource_names(kind: str, file_name: str) -> list[str]:
    """Return the names of all shipped folders of a kind, sorted."""
    home = share_directory() / f"{kind}s"
    return sorted(path.parent.name for path in home.glob(f"*/{file_name}"))
