"""Places of the models and meshes that a world file names by URI."""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from urllib.parse import unquote

from swarm_common.process.home import home_folder
from swarm_describe.files.fuel import name_in_fuel

MODEL_VARIABLES = (
    "GZ_SIM_RESOURCE_PATH",
    "IGN_GAZEBO_RESOURCE_PATH",
    "SDF_PATH",
    "GAZEBO_MODEL_PATH",
    "GAZEBO_RESOURCE_PATH",
)
BESIDE = (".", "models", "..", "../models")  # of the world file


@dataclass(frozen=True, slots=True)
class ModelPaths:
    """Searches for files in the folders that Gazebo would look into."""

    beside: Path  # folder of the world file
    # variables with further folders
    environ: Mapping[str, str] = field(default_factory=lambda: os.environ)
    home: Path = field(default_factory=home_folder)  # folder of the user

    def find(self, uri: str, here: Path) -> Path | None:
        """Return the file or folder that a URI means; None if it is nowhere.

        Args:
            uri: ``model://``, ``package://``, ``file://``, of Gazebo Fuel, or a path.
        """
        for path in self.candidates(uri, here):
            if path.exists():
                return path
        return None

    def candidates(self, uri: str, here: Path) -> Iterator[Path]:
        """Yield where a URI is searched, in order."""
        scheme, _, rest = uri.strip().rpartition("://")
        if scheme == "model":
            yield from (folder / _name(rest) for folder in self._model_folders(here))
        elif scheme == "package":
            yield from self._in_packages(rest, here)
        elif scheme in ("http", "https"):
            yield from self._in_fuel(uri.strip(), here)
        elif scheme in ("", "file"):
            path = Path(rest)
            yield here / path  # an absolute path replaces the folder
            if not path.is_absolute():
                yield from (folder / path for folder in self._model_folders(here))

    def _model_folders(self, here: Path) -> list[Path]:
        folders = [self.beside / name for name in BESIDE]
        folders += [here / name for name in (".", "..")]
        for variable in MODEL_VARIABLES:
            folders += _folders_in(self.environ.get(variable, ""))
        folders.append(self.home / ".gazebo" / "models")
        return list(dict.fromkeys(folder.resolve() for folder in folders))

    def _in_packages(self, rest: str, here: Path) -> Iterator[Path]:
        package, _, inside = _name(rest).partition("/")
        for folder in here.parents:  # the package that the world file belongs to
            if folder.name == package:
                yield folder / inside
        for folder in _folders_in(self.environ.get("ROS_PACKAGE_PATH", "")):
            if folder.name == package:
                yield folder / inside
            yield folder / package / inside
        for folder in _folders_in(self.environ.get("AMENT_PREFIX_PATH", "")):
            yield folder / "share" / package / inside
        yield from (folder / package / inside for folder in self._model_folders(here))

    def _in_fuel(self, uri: str, here: Path) -> Iterator[Path]:
        """Yield places of what was downloaded before; nothing is downloaded here."""
        name = name_in_fuel(uri)
        if name is None:
            return
        yield from name.cached(self.home, self.environ)
        yield from (folder / name.name / name.inside for folder in self._model_folders(here))


def _name(rest: str) -> str:
    """Return the path in a URI, without a way out of the folders that are searched."""
    return "/".join(part for part in unquote(rest).split("/") if part not in ("", "..", "."))


def _folders_in(variable: str) -> list[Path]:
    return [Path(os.path.expanduser(text)) for text in variable.split(os.pathsep) if text]
