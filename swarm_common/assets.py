"""Finds the data that ships with the project: robots, worlds, maps, params, interfaces.

In a clone they are folders beside the packages; a wheel carries them in `swarm_common/data`.
"""

from __future__ import annotations

from pathlib import Path

from swarm_common.errors import SwarmError, UnknownNameError

KINDS = ("robots", "worlds", "maps", "params", "interfaces")

_PACKAGE = Path(__file__).resolve().parent


def directory(kind: str) -> Path:
    """Return the folder of one kind of data.

    Args:
        kind: One of KINDS.

    Raises:
        SwarmError: The installation lacks the folder.
    """
    if kind not in KINDS:
        raise ValueError(f"no such kind of data: {kind}; known: {', '.join(KINDS)}")
    for root in (_PACKAGE / "data", _PACKAGE.parent):
        if (root / kind).is_dir():
            return root / kind
    raise SwarmError(
        f"the folder {kind}/ is neither in {_PACKAGE / 'data'} nor beside {_PACKAGE};"
        " the installation is incomplete: run pip install again"
    )


def names(kind: str) -> list[str]:
    """List what exists of one kind: sub-folders, or YAML files without their suffix."""
    found = {
        path.stem if path.is_file() else path.name
        for path in directory(kind).iterdir()
        if not path.name.startswith((".", "_")) and (path.is_dir() or path.suffix == ".yaml")
    }
    return sorted(found)


def find(kind: str, name: str, file: str = "") -> Path:
    """Return the path of a named item.

    Args:
        kind: One of KINDS.
        name: What the user typed, for example a world's name.
        file: File inside the item's folder; empty for the folder or YAML file itself.

    Raises:
        UnknownNameError: There is no such item.
    """
    if name not in names(kind):
        raise UnknownNameError(kind.removesuffix("s"), name, names(kind))
    path = directory(kind) / name
    if not path.is_dir():
        path = path.with_suffix(".yaml")
    return path / file if file else path
