"""Interface packages as sources: what they define, what they need, when they changed."""

from __future__ import annotations

import hashlib
import xml.etree.ElementTree as ElementTree
from dataclasses import dataclass
from pathlib import Path

from swarm_common.model.errors import ConfigError

KINDS = ("msg", "srv", "action")


@dataclass(frozen=True, slots=True)
class InterfacePackage:
    """One folder with package.xml and msg/, srv/, action/."""

    name: str
    folder: Path
    depends: tuple[str, ...]  # direct dependencies, by package name
    files: tuple[Path, ...]  # definitions relative to the folder, sorted

    def digest(self) -> str:
        """Return a hash of all definitions and of package.xml."""
        state = hashlib.sha256()
        for relative in (Path("package.xml"), *self.files):
            state.update(f"{relative.as_posix()}\0".encode())
            state.update((self.folder / relative).read_bytes())
        return state.hexdigest()


def load_package(folder: Path) -> InterfacePackage:
    """Read one interface package."""
    try:
        root = ElementTree.parse(folder / "package.xml").getroot()
    except ElementTree.ParseError as error:
        raise ConfigError(f"{folder / 'package.xml'} is malformed: {error}") from error
    name = root.findtext("name")
    if not name:
        raise ConfigError(f"{folder / 'package.xml'} has no <name>")
    files = sorted(
        path.relative_to(folder) for kind in KINDS for path in folder.glob(f"{kind}/*.{kind}")
    )
    if not files:
        raise ConfigError(f"{folder} defines no message, service or action")
    depends = tuple(sorted({node.text or "" for node in root.findall("depend")}))
    return InterfacePackage(name, folder, depends, tuple(files))


def load_packages(root: Path) -> list[InterfacePackage]:
    """Read all interface packages below a folder, dependencies first."""
    packages = [load_package(path.parent) for path in sorted(root.glob("*/package.xml"))]
    if not packages:
        raise ConfigError(f"{root} holds no interface packages (folders with a package.xml)")
    return sort_by_dependency(packages)


def sort_by_dependency(packages: list[InterfacePackage]) -> list[InterfacePackage]:
    """Order packages so that each one comes after those that it depends on."""
    waiting = {package.name: package for package in packages}
    ordered: list[InterfacePackage] = []
    while waiting:
        ready = [p for p in waiting.values() if not any(name in waiting for name in p.depends)]
        if not ready:
            raise ConfigError(f"interface packages depend on each other: {', '.join(waiting)}")
        for package in ready:
            del waiting[package.name]
        ordered += ready
    return ordered


def content_key(packages: list[InterfacePackage], platform: str) -> str:
    """Return the name under which a build of these packages is cached.

    `platform` is everything else that the result depends on: Python, generators, compiler flags.
    """
    state = hashlib.sha256(platform.encode())
    for package in sorted(packages, key=lambda package: package.name):
        state.update(f"{package.name}:{package.digest()}\n".encode())
    return state.hexdigest()[:20]
