"""Folders for files between runs if the user's own folders cannot be written."""

from __future__ import annotations

import contextlib
import os
import stat
import tempfile
from collections.abc import MutableMapping
from pathlib import Path

from swarm_common.model.errors import ConfigError

NAME = "swarm-workbench"


def home_folder() -> Path:
    """Return the user's home folder, whether it exists or not."""
    try:
        return Path.home()
    except RuntimeError:  # neither HOME nor an entry of this user
        return Path(os.sep)


def cache_base() -> Path:
    """Return the folder for caches: the user's, or a private one among the temporary files."""
    base = _base("XDG_CACHE_HOME", ".cache")
    return base if can_be_written(base / NAME) else temporary_base()


def can_be_written(folder: Path) -> bool:
    """Whether files can be put into a folder, which may have to be made, and the one above it."""
    for place in (folder, folder.parent, folder.parent.parent):
        if os.path.lexists(place):  # unlike Path.exists no error if we may not look
            return os.path.isdir(place) and os.access(place, os.W_OK | os.X_OK)
    return False


def temporary_base() -> Path:
    """Return a folder that belongs to this user alone; the same at each call."""
    try:
        path = Path(tempfile.gettempdir()) / f"{NAME}-{os.getuid()}"
        with contextlib.suppress(FileExistsError):
            path.mkdir(mode=0o700)
        status = path.lstat()
        is_ours = stat.S_ISDIR(status.st_mode) and status.st_uid == os.getuid()
        if is_ours and not status.st_mode & 0o077:
            return path
        return Path(tempfile.mkdtemp(prefix=f"{NAME}-"))  # somebody else was there first
    except OSError as error:
        raise ConfigError(
            f"neither the home folder nor one for temporary files can be written"
            f" ({error.strerror}): set TMPDIR to one that can"
        ) from None


def set_defaults(environment: MutableMapping[str, str]) -> None:
    """Set where ROS and matplotlib write if the user's own folders cannot be written.

    Without that rclpy does not start: it wants a folder for logs.

    Args:
        environment: Environment of this process, before ROS and matplotlib are loaded.
    """
    ros = environment.get("ROS_HOME") or Path(environment.get("HOME") or os.devnull) / ".ros"
    config = _base("XDG_CONFIG_HOME", ".config")
    if not can_be_written(Path(environment.get("ROS_LOG_DIR") or Path(ros) / "log")):
        environment["ROS_LOG_DIR"] = str(temporary_base() / "ros")
    if not can_be_written(config / "matplotlib"):
        environment.setdefault("MPLCONFIGDIR", str(temporary_base() / "matplotlib"))


def log_to(folder: Path, environment: MutableMapping[str, str]) -> None:
    """Let ROS log to a folder, unless the user has chosen another one that can be written."""
    chosen = Path(environment.get("ROS_LOG_DIR", ""))
    is_makeshift = chosen.name == "ros" and chosen.parent.name.startswith(f"{NAME}-")
    if is_makeshift or not environment.get("ROS_LOG_DIR"):
        environment["ROS_LOG_DIR"] = str(folder)


def _base(variable: str, usual: str) -> Path:
    """Return a base folder of the XDG specification, which has relative ones ignored."""
    own = Path(os.environ.get(variable, ""))
    return own if own.is_absolute() else home_folder() / usual
