"""Where things are kept between runs if the user has no home folder, or one that is read-only."""

from __future__ import annotations

import os
import stat
import tempfile
from collections.abc import MutableMapping
from pathlib import Path

NAME = "swarm-workbench"


def home_folder() -> Path:
    """Return the user's home folder, whether it exists or not."""
    try:
        return Path.home()
    except RuntimeError:  # neither HOME nor an entry of this user
        return Path(os.sep)


def cache_base() -> Path:
    """Return the folder for caches: the user's, or a private one among the temporary files."""
    own = os.environ.get("XDG_CACHE_HOME", "")
    base = Path(own) if own else home_folder() / ".cache"
    return base if can_be_written(base) else temporary_base()


def can_be_written(folder: Path) -> bool:
    """Whether files can be put into a folder, or could if it was made in the one above it."""
    place = folder if folder.is_dir() else folder.parent
    return place.is_dir() and os.access(place, os.W_OK | os.X_OK)


def temporary_base() -> Path:
    """Return a folder that belongs to this user alone; the same at each call."""
    path = Path(tempfile.gettempdir()) / f"{NAME}-{os.getuid()}"
    path.mkdir(mode=0o700, exist_ok=True)
    status = path.lstat()
    is_ours = stat.S_ISDIR(status.st_mode) and status.st_uid == os.getuid()
    if is_ours and not status.st_mode & 0o077:
        return path
    return Path(tempfile.mkdtemp(prefix=f"{NAME}-"))  # somebody else was there first


def set_defaults(environment: MutableMapping[str, str]) -> None:
    """Tell ROS, numba and matplotlib where to write if the user's home folder cannot be written.

    Without that rclpy does not start: it wants a folder for logs.
    """
    home = Path(environment.get("HOME") or os.devnull)
    if home.is_dir() and os.access(home, os.W_OK | os.X_OK):
        return
    base = temporary_base()
    if "ROS_HOME" not in environment:
        environment.setdefault("ROS_LOG_DIR", str(base / "ros"))
    if not os.access(Path(__file__).parent, os.W_OK):  # numba keeps kernels beside their sources
        environment.setdefault("NUMBA_CACHE_DIR", str(base / "numba"))
    environment.setdefault("MPLCONFIGDIR", str(base / "matplotlib"))
