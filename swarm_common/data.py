"""Where the worlds, maps, robots and parameters that come with the project lie."""

from __future__ import annotations

import sys
from pathlib import Path

from swarm_common.errors import ConfigError, UnknownNameError

SHARE = Path("share") / "swarm_workbench"  # below the environment's prefix, for an installed wheel


def data_folder(kind: str) -> Path:
    """Return the folder `worlds`, `maps`, `robots` or `params` of the checkout or the installation.

    Raises:
        ConfigError: If neither has it.
    """
    candidates = [Path(__file__).resolve().parent.parent / kind, Path(sys.prefix) / SHARE / kind]
    for folder in candidates:
        if folder.is_dir():
            return folder
    tried = " nor ".join(str(folder) for folder in candidates)
    raise ConfigError(f"the folder of {kind} is missing: found neither {tried}; install again")


def is_path(name: str) -> bool:
    """Whether the user means a file of his own rather than something that comes with us."""
    return "/" in name or Path(name).suffix != ""


def find_entry(kind: str, name: str, pattern: str, label: str) -> Path:
    """Return the file of a named entry of `data_folder(kind)`.

    Args:
        kind: Folder of the data, for example ``worlds``.
        name: Name as given by the user.
        pattern: Where the entry's file lies below the folder, with ``{}`` for the name, for
            example ``{}/world.sdf``.
        label: What to call it in the message, for example ``world``.

    Raises:
        UnknownNameError: If there is none of that name; carries the known names.
    """
    folder = data_folder(kind)
    before, _, after = pattern.partition("{}")
    known = {
        str(path.relative_to(folder))[len(before) : -len(after)]
        for path in folder.glob(pattern.replace("{}", "*"))
    }
    if name not in known:
        raise UnknownNameError(label, name, known)
    return folder / pattern.replace("{}", name)
