"""Where a robot comes from: a folder of `robots/`, or the user's URDF, xacro or `robot.yaml`."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from swarm_common.files.resources import resource_names, share_directory
from swarm_common.files.yaml_io import read_yaml
from swarm_common.model.errors import RobotModelError, UnknownNameError
from swarm_common.robots.packages import PackageFinder
from swarm_common.robots.xacro_io import expand

ROBOT_FILE = "robot.yaml"
DESCRIPTIONS = ("model.urdf.xacro", "model.urdf")
ENDINGS = (".urdf", ".xacro", ".xml")


@dataclass(frozen=True, slots=True)
class RobotSource:
    """The files of a robot."""

    name: str  # of the model, unless its settings say otherwise
    settings: Path  # its robot.yaml, which need not exist
    data: dict[str, Any] = field(default_factory=dict)  # what is in there
    urdf: Path | None = None  # its description, URDF or xacro; None if there is none

    @property
    def where(self) -> str:
        """What errors in the description are about."""
        return str(self.urdf or self.settings.parent)

    def finder(self) -> PackageFinder:
        """Return what finds the packages that the description refers to.

        Raises:
            RobotModelError: If `packages` in robot.yaml is not a list of folders.
        """
        paths = self.data.get("packages") or []
        if not isinstance(paths, list) or not all(isinstance(path, str) for path in paths):
            raise RobotModelError(f"{self.settings}: packages is {paths!r}; a list of folders")
        return PackageFinder([self.settings.parent / path for path in paths], self.urdf)

    def text(self) -> str:
        """Return the description as URDF text, xacro expanded.

        Raises:
            RobotModelError: If there is none, or it cannot be read.
        """
        if self.urdf is None:
            raise RobotModelError(
                f"{self.settings.parent} has no {' or '.join(DESCRIPTIONS)} to describe the robot"
            )
        try:
            text = self.urdf.read_text(encoding="utf-8")
        except (OSError, UnicodeDecodeError) as cause:
            raise RobotModelError(f"cannot read {self.urdf}: {cause}") from cause
        if self.urdf.suffix != ".xacro" and "xacro:" not in text:
            return text
        return expand(self.urdf, self._arguments(), self.finder())

    def _arguments(self) -> dict[str, str]:
        values = self.data.get("xacro_args") or {}
        if not isinstance(values, dict):
            raise RobotModelError(f"{self.settings}: xacro_args is {values!r}; 'name: value' lines")
        return {
            str(name): str(value).lower() if isinstance(value, bool) else str(value)
            for name, value in values.items()
        }


def robot_names() -> list[str]:
    """Return the names of the robot models that ship with the project."""
    return resource_names("robot", ROBOT_FILE)


def find_robot(name_or_path: str | Path) -> RobotSource:
    """Return the files of a robot.

    Args:
        name_or_path: Name of a folder in `robots/`, or a path to a folder, URDF, xacro or
            `robot.yaml`.

    Raises:
        UnknownNameError: If there is no such robot.
        RobotModelError: If its robot.yaml cannot be read.
    """
    path = Path(name_or_path)
    if path.is_file():
        return _of_file(path)
    if len(path.parts) == 1 and (share_directory("robots") / "robots" / path).is_dir():
        path = share_directory("robots") / "robots" / path
    if (path / ROBOT_FILE).is_file():
        return _of_settings(path / ROBOT_FILE)
    found = _description_in(path) if path.is_dir() else None
    if found is None:
        raise UnknownNameError("robot", str(name_or_path), robot_names())
    return _of_file(found)


def _of_file(path: Path) -> RobotSource:
    if path.suffix in (".yaml", ".yml"):
        return _of_settings(path)
    if path.suffix not in ENDINGS:
        raise RobotModelError(f"{path} is no robot; expected a .urdf, .xacro or robot.yaml")
    for settings in (path.with_name(f"{_stem(path)}.{ROBOT_FILE}"), path.with_name(ROBOT_FILE)):
        if settings.is_file():
            data = read_yaml(settings, RobotModelError)
            described = _described(settings, data) if "description" in data else path
            if described is not None and described.resolve() == path.resolve():
                return RobotSource(_stem(path), settings, data, path)
    return RobotSource(_stem(path), path.with_name(ROBOT_FILE), {}, path)


def _of_settings(path: Path) -> RobotSource:
    data = read_yaml(path, RobotModelError)
    return RobotSource(path.absolute().parent.name, path, data, _described(path, data))


def _described(settings: Path, data: dict[str, Any]) -> Path | None:
    """Return the description that belongs to a robot.yaml."""
    given = data.get("description")
    if given is None:
        return _description_in(settings.parent)
    if not isinstance(given, str) or not (settings.parent / given).is_file():
        raise RobotModelError(f"{settings}: description is {given!r}; there is no such file")
    return settings.parent / given


def _description_in(folder: Path) -> Path | None:
    for name in DESCRIPTIONS:
        if (folder / name).is_file():
            return folder / name
    found = [path for path in sorted(folder.iterdir()) if path.suffix in ENDINGS[:2]]
    return found[0] if len(found) == 1 else None


def _stem(path: Path) -> str:
    """Return what a description is called: its folder's name if its own is `model`."""
    stem = path.name.split(".")[0] or path.name
    return path.absolute().parent.name if stem == "model" else stem
