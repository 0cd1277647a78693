"""ROS packages on disk: where `package://` URIs and `$(find package)` lead."""

from __future__ import annotations

import os
import re
from collections.abc import Iterator, Sequence
from pathlib import Path
from urllib.parse import unquote

from swarm_common.files.resources import file_of
from swarm_common.model.errors import ConfigError, DescriptionError, MissingPackageError

DEPTH = 3  # folders below a given path in which packages are looked for
ANCESTORS = 6  # folders above a file in which its own package is looked for
NAME = re.compile(r"<name>\s*([^<\s]+)\s*</name>")


def add_package_paths(paths: Sequence[Path]) -> None:
    """Put folders before those of ROS_PACKAGE_PATH, for this process and its children.

    Args:
        paths: Packages, or folders that hold some; the first is searched first.
    """
    for path in paths:
        if not path.is_dir():
            raise ConfigError(f"--package-path {path} is no folder")
    before = [os.environ["ROS_PACKAGE_PATH"]] if os.environ.get("ROS_PACKAGE_PATH") else []
    if paths:
        texts = [str(path.absolute()) for path in paths]
        os.environ["ROS_PACKAGE_PATH"] = os.pathsep.join([*texts, *before])


class PackageFinder:
    """Looks for packages in given folders, around a file, and where ROS would look.

    The order: the given folders and what lies in them, the folders above the file, the entries of
    `ROS_PACKAGE_PATH`, `share` of those of `AMENT_PREFIX_PATH`.
    """

    def __init__(self, paths: Sequence[Path] = (), near: Path | None = None) -> None:
        """Remember where to look; nothing is read yet.

        Args:
            near: File whose folders are searched upwards. None: none are.
        """
        self._paths = [path.absolute() for path in paths]
        self._above = list(near.absolute().parents[:ANCESTORS]) if near is not None else []

    def share(self, package: str) -> Path:
        """Return a package's folder."""
        for folder in self._candidates(package):
            if folder.is_dir():
                return folder
        raise MissingPackageError([package], self.searched())

    def resolve(self, uri: str, beside: Path) -> Path:
        """Return the file of a `package://`, `file://`, absolute or relative URI."""
        scheme, is_uri, rest = uri.partition("://")
        if is_uri and scheme in ("package", "model"):
            package, _, name = rest.partition("/")
            share = self.share(package)
            path = share / name.lstrip("/")
            if not path.is_file():  # both are found in the wild: the name, and the name quoted
                path = share / unquote(name).lstrip("/")
        else:
            path = beside / file_of(uri)
        if not path.is_file():
            raise DescriptionError(f"there is no file {path} (for '{uri}')")
        return path

    def _candidates(self, package: str) -> Iterator[Path]:
        for folder in self._paths:
            yield from _in_tree(folder, package)
        for folder in self._above:
            if _package_name(folder) == package or folder.name == package:
                yield folder
            if _package_name(folder / package) == package:
                yield folder / package
        for folder in _entries("ROS_PACKAGE_PATH"):
            yield from _in_tree(folder, package)
        for prefix in _entries("AMENT_PREFIX_PATH"):
            yield prefix / "share" / package

    def searched(self) -> str:
        """Return the places for messages."""
        given = [str(path) for path in self._paths]
        above = [f"the folders above {self._above[0]}"] if self._above else []
        names = ("ROS_PACKAGE_PATH", "AMENT_PREFIX_PATH")
        ros = [f"{name}={os.environ[name]}" for name in names if os.environ.get(name)]
        unset = [f"{name} (not set)" for name in names if not os.environ.get(name)]
        return ", ".join([*given, *above, *ros, *unset])


def _entries(variable: str) -> list[Path]:
    return [Path(text) for text in os.environ.get(variable, "").split(os.pathsep) if text]


def _in_tree(folder: Path, package: str) -> Iterator[Path]:
    """Yield the places of a package in a folder: itself, a child of its name, or deeper down."""
    if folder.name == package or _package_name(folder) == package:
        yield folder
    yield folder / package
    yield folder / "share" / package
    for root, folders, files in os.walk(folder):
        depth = len(Path(root).relative_to(folder).parts)
        if "package.xml" in files and _package_name(Path(root)) == package:
            yield Path(root)
        folders[:] = sorted(folders) if depth < DEPTH and "package.xml" not in files else []


def _package_name(folder: Path) -> str | None:
    """Return the name in a folder's package.xml, None without one."""
    try:
        match = NAME.search((folder / "package.xml").read_text(encoding="utf-8", errors="replace"))
    except OSError:
        return None
    return match.group(1) if match else None
