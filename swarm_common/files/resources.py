"""Folders of the data that ships with the project (robots, worlds, maps, ...), and of runs."""

from __future__ import annotations

import os
from collections.abc import Iterable
from pathlib import Path
from urllib.parse import unquote, urlsplit

from swarm_common.model.errors import SwarmError

SHARE_VARIABLE = "SWARM_SHARE"


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


RUNS = Path("runs")
LATEST = "latest"


def run_folders() -> list[str]:
    """Return the folders of runs, the latest first; shells offer them."""
    folders = sorted((path.parent for path in RUNS.glob("*/config")), key=str, reverse=True)
    return [str(folder) for folder in folders]
