"""Keeps out of our processes what they cannot use: another ROS 2, warnings that are errors.

A shell that has sourced a ROS 2 exports its Python packages, its libraries and, often, another
middleware. ROS 2 from pip has `rmw_fastrtps_cpp` only and ends every process that is told
otherwise; packages of a ROS 2 for another Python hide ours and cannot be imported. Libraries warn
when they are imported; where `PYTHONWARNINGS` makes errors of that, a process of ours cannot start.

ROS 2 from pip has each Python begin anew with its libraries on `LD_LIBRARY_PATH`, once: a command
that a program of another environment starts inherits the libraries of that one.
"""

from __future__ import annotations

import importlib
import importlib.util
import os
import re
import sys
from collections.abc import Iterable, Mapping
from pathlib import Path

RMW, OWN_RMW = "RMW_IMPLEMENTATION", "rmw_fastrtps_cpp"
LIBRARIES, PACKAGES, WARNINGS = "LD_LIBRARY_PATH", "PYTHONPATH", "PYTHONWARNINGS"
WHEELS = "lib/python*/site-packages/ros_*.libs"  # of ROS 2 from pip, in an environment
ALREADY_BEGUN_ANEW = "_ROS_WHEELS_BOOTSTRAP_COMPLETE"  # of ros_wheels_bootstrapper
VERSIONED = re.compile(r"/python(?P<version>\d+\.\d+)/(?:site|dist)-packages/*$")


def set_aside(name: str) -> None:
    """Go on without what cannot be used, and say so on stderr; before rclpy is imported.

    Where the order of the libraries is to change, or what becomes of warnings, the process begins
    anew, because they are read only once.
    """
    version = f"{sys.version_info.major}.{sys.version_info.minor}"
    unusable = unusable_packages(os.environ, version)
    if unusable:
        os.environ[PACKAGES] = without(os.environ[PACKAGES], unusable)
        normal = {os.path.normpath(folder) for folder in unusable}
        sys.path[:] = [folder for folder in sys.path if os.path.normpath(folder) not in normal]
        importlib.invalidate_caches()
        more = f" and {len(unusable) - 1} more folders" if len(unusable) > 1 else ""
        _say(
            name,
            f"not used: {unusable[0]}{more} on {PACKAGES}, of a ROS 2 for another Python than"
            f" this {version}; the ROS 2 of {sys.prefix} is",
        )
    if os.environ.get(RMW, OWN_RMW) != OWN_RMW and is_own_ros():
        chosen = os.environ.pop(RMW)
        _say(name, f"not used: {RMW}={chosen}, as the ROS 2 of {sys.prefix} has {OWN_RMW} only")
    libraries = os.environ.get(LIBRARIES, "")
    foreign = libraries_of_others(libraries, own_libraries()) if is_own_ros() else []
    ordered = own_first(without(libraries, foreign), Path(sys.prefix))
    is_reordered = bool(unusable or foreign) and ordered != libraries
    if foreign:
        os.environ.pop(ALREADY_BEGUN_ANEW, None)
        package = next(Path(folder) for folder in foreign if Path(folder).match(WHEELS))
        _say(
            name,
            f"not used: the ROS 2 libraries of {package.parents[3]} on {LIBRARIES};"
            f" those of {sys.prefix} are",
        )
    has_errors = "error" in os.environ.get(WARNINGS, "")
    if has_errors:
        chosen = os.environ.pop(WARNINGS)
        _say(name, f"not used: {WARNINGS}={chosen}, as libraries of others warn")
    if is_reordered:
        os.environ[LIBRARIES] = ordered
    if has_errors or is_reordered:
        os.execve(sys.executable, sys.orig_argv, os.environ)


def is_own_ros() -> bool:
    """Whether the rclpy that would be imported belongs to this Python environment (from pip)."""
    spec = importlib.util.find_spec("rclpy")
    return bool(spec and spec.origin and Path(spec.origin).is_relative_to(sys.prefix))


def unusable_packages(environ: Mapping[str, str], version: str) -> list[str]:
    """Return the folders on PYTHONPATH that belong to a ROS 2 for another Python."""
    folders = environ.get(PACKAGES, "").split(os.pathsep)
    return [folder for folder in folders if _is_unusable(folder, version)]


def without(folders: str, unwanted: Iterable[str]) -> str:
    """Return a search path without some of its folders."""
    left_out = set(unwanted)
    return os.pathsep.join(f for f in folders.split(os.pathsep) if f not in left_out)


def own_libraries() -> set[Path]:
    """Return the folders of libraries that ROS 2 from pip has in this Python environment."""
    folders = (Path(entry) for entry in sys.path if entry)
    return {libraries.resolve() for folder in folders for libraries in folder.glob("ros_*.libs")}


def libraries_of_others(folders: str, own: set[Path]) -> list[str]:
    """Return the folders on a search path that belong to ROS 2 from pip in other environments.

    These are `ros_*.libs` of its packages and `lib` of the environment, where messages that were
    built for it are.
    """
    parts = {folder: Path(folder).resolve() for folder in folders.split(os.pathsep) if folder}
    packages = {path for path in parts.values() if path.match(WHEELS)} - own
    environments = {path.parents[2] for path in packages} - {path.parents[2] for path in own}
    return [folder for folder, path in parts.items() if path in packages | environments]


def own_first(folders: str, prefix: Path) -> str:
    """Return a search path with the folders below a prefix before all others."""
    parts = [folder for folder in folders.split(os.pathsep) if folder]
    own = [folder for folder in parts if Path(folder).is_relative_to(prefix)]
    return os.pathsep.join([*own, *(folder for folder in parts if folder not in own)])


def _is_unusable(folder: str, version: str) -> bool:
    match = VERSIONED.search(folder)
    if match is None or match["version"] == version:
        return False
    above = list(Path(folder).parents)[2:4]  # PREFIX/lib/pythonX.Y/..., PREFIX/local/lib/...
    return any((prefix / "share" / "ament_index").is_dir() for prefix in above)


def _say(name: str, what: str) -> None:
    sys.stderr.write(f"{name}: {what}\n")
    sys.stderr.flush()
