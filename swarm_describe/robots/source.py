"""Source of a robot: a folder of `robots/`, or the user's URDF, xacro or `robot.yaml`."""

from __future__ import annotations

import codecs
import re
import xml.etree.ElementTree as ET
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from swarm_common.files.resources import resource_names, share_directory
from swarm_common.files.yaml_io import read_yaml
from swarm_common.model.errors import RobotModelError, UnknownNameError
from swarm_describe.files.packages import PackageFinder
from swarm_describe.files.xacro_io import expand, macro_message
from swarm_describe.robots.grammar import description_notes
from swarm_describe.robots.sdf_robot import find_model_file, urdf_of
from swarm_describe.robots.spec import AS_WRITTEN, value_of
from swarm_describe.robots.urdf_tree import OF_SHAPES

ROBOT_FILE = "robot.yaml"
DESCRIPTIONS = ("model.urdf.xacro", "model.urdf")
ENDINGS = (".urdf", ".xacro", ".xml", ".sdf")
DECLARATION = re.compile(r"^\s*<\?xml\b[^>]*?\?>")
ENCODING = re.compile(rb"^\s*<\?xml\b[^>]*?\bencoding\s*=\s*[\"']([\w.:-]+)[\"']")
PREFIX = re.compile(r"</?([A-Za-z_][\w.-]*):(?=[A-Za-z_])")
DECLARED_PREFIX = re.compile(r"\bxmlns:([\w.-]+)\s*=")
ROOT = re.compile(r"<(?:robot|sdf)\b")
SDF = re.compile(r"<sdf\b")


@dataclass(frozen=True, slots=True)
class RobotSource:
    """The files of a robot."""

    name: str  # of the model, unless its settings say otherwise
    settings: Path  # its robot.yaml, which need not exist
    data: dict[str, Any] = field(default_factory=dict)  # what is in there
    urdf: Path | None = None  # its description, URDF or xacro; None if there is none

    @property
    def where(self) -> str:
        """Name of the description in error messages."""
        return str(self.urdf or self.settings.parent)

    @property
    def file(self) -> str:
        """Name of what states its values, in error messages."""
        return str(self.settings if self.settings.is_file() else self.where)

    def finder(self) -> PackageFinder:
        """Return the finder of the packages to which the description refers."""
        names = value_of("packages", self.data.get("packages") or [], self.settings)
        for name in names:
            if not (self.settings.parent / name).is_dir():
                raise RobotModelError(f"{self.settings}: packages: there is no folder '{name}'")
        return PackageFinder([self.settings.parent / name for name in names], self.urdf)

    def text(self) -> str:
        """Return the description as URDF text, xacro expanded."""
        return self.read()[0]

    def read(self) -> tuple[str, list[str]]:
        """Return the description as URDF text, and a sentence on what of it nothing reads."""
        if self.urdf is None:
            raise RobotModelError(
                f"{self.settings.parent} has no {' or '.join(DESCRIPTIONS)} to describe the robot"
            )
        text = _read(self.urdf)
        if self.urdf.suffix == ".xacro" or "xacro:" in text:
            text = expand(self.urdf, self.arguments(), self.finder())
            if message := macro_message(self.urdf, text):
                raise RobotModelError(message)
        if SDF.search(text) is None:
            return text, []
        try:
            root = ET.fromstring(text)
        except ET.ParseError as cause:
            raise RobotModelError(f"{self.urdf}: malformed XML: {cause}") from cause
        if root.tag != "sdf":
            return text, []
        if self.data.get("inertia") == OF_SHAPES:
            for element in root.iter("inertia"):
                element.clear()
        return urdf_of(root, str(self.urdf)), description_notes(root)

    def arguments(self) -> dict[str, str]:
        """Return the arguments of robot.yaml for xacro, each as on xacro's command line."""
        values = value_of("xacro_args", self.data.get("xacro_args") or {}, self.settings)
        return {name: value or "" for name, value in values.items()}


def robot_names() -> list[str]:
    """Return the names of the robot models that ship with the project."""
    return resource_names("robot", ROBOT_FILE)


def find_robot(name_or_path: str | Path) -> RobotSource:
    """Return the files of a robot."""
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
        raise RobotModelError(f"{path} is no robot; expected a .urdf, .xacro, .sdf or robot.yaml")
    for settings in (path.with_name(f"{_stem(path)}.{ROBOT_FILE}"), path.with_name(ROBOT_FILE)):
        if settings.is_file():
            data = read_yaml(settings, RobotModelError, as_written=AS_WRITTEN)
            described = _described(settings, data) if "description" in data else path
            if described is not None and described.resolve() == path.resolve():
                return RobotSource(_stem(path), settings, data, path)
    return RobotSource(_stem(path), path.with_name(ROBOT_FILE), {}, path)


def _of_settings(path: Path) -> RobotSource:
    data = read_yaml(path, RobotModelError, as_written=AS_WRITTEN)
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
    return found[0] if len(found) == 1 else find_model_file(folder)


def _read(path: Path) -> str:
    """Return a description's text without its XML declaration, which says how it is encoded."""
    try:
        content = path.read_bytes().removeprefix(codecs.BOM_UTF8)
        declared = ENCODING.match(content)
        encoding = declared.group(1).decode("ascii") if declared else "utf-8"
        text = content.decode(encoding)
    except OSError as cause:
        raise RobotModelError(f"cannot read {path}: {cause}") from cause
    except LookupError as cause:
        raise RobotModelError(f"cannot read {path}: it declares {cause}") from cause
    except UnicodeDecodeError as cause:
        line = content.count(b"\n", 0, cause.start) + 1
        raise RobotModelError(
            f"cannot read {path}: line {line} is not {encoding}; save the file as UTF-8, or "
            "declare its encoding in the first line, like "
            '<?xml version="1.0" encoding="ISO-8859-1"?>'
        ) from cause
    return _with_prefixes(DECLARATION.sub("", text).lstrip())


def _with_prefixes(text: str) -> str:
    """Declare the prefixes (`gz:`) that descriptions use undeclared, as simulators allow it."""
    known = {*DECLARED_PREFIX.findall(text), "xml", "xmlns", "xacro"}
    used = {*PREFIX.findall(text)} - known
    more = "".join(f' xmlns:{name}="urn:undeclared:{name}"' for name in sorted(used))
    return ROOT.sub(lambda found: found.group() + more, text, count=1) if used else text


def _stem(path: Path) -> str:
    """Return the name of a description: that of its folder if its own is `model`.

    In Fuel's cache that folder is a version, and the one above it has the name.
    """
    stem = path.name
    while (rest := Path(stem)).suffix in ENDINGS:
        stem = rest.stem
    folder = path.absolute().parent
    named = folder.parent if folder.name.isdigit() else folder
    return named.name if stem == "model" else stem
