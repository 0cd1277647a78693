"""Source of the Python that runs in every tick: compiled code, if there is any.

`swarm-setup` compiles the annotated Python of the folders below with mypyc
(https://mypyc.readthedocs.io), beside the installed packages and by the content of the sources.
Importing `swarm_common` puts a finder before Python's own, which takes a module from there if the
sources are still the same; else, and with SWARM_INTERPRETED=1, Python runs the sources. Both give
the same bits. The edition is the digest of what the hosts of one swarm must have in common.
"""

from __future__ import annotations

import hashlib
import os
import platform
import sys
import sysconfig
from collections.abc import Sequence
from importlib.abc import MetaPathFinder
from importlib.machinery import ExtensionFileLoader, ModuleSpec
from importlib.util import spec_from_file_location
from pathlib import Path
from types import ModuleType

DISTRIBUTION = "swarm-workbench"
# Packages whose code decides what a robot does, and what the hosts say to each other.
DECIDING = ("swarm_common", "swarm_describe", "swarm_nav", "swarm_commander")
DIGITS = 10  # of the digest that are shown
PACKAGES = ("swarm_common", "swarm_nav", "swarm_setup")  # on whose sources it depends
SWITCH = "SWARM_INTERPRETED"
ROOT = Path(__file__).resolve().parents[2]
SUFFIX = str(sysconfig.get_config_var("EXT_SUFFIX"))


def compiled_folder() -> Path:
    """Return where the code that was compiled from the sources as they are is, or would be."""
    digest = hashlib.sha256(f"{sys.version}\n{platform.machine()}".encode())
    for package in PACKAGES:
        for path in sorted((ROOT / package).rglob("*.py")):
            digest.update(str(path.relative_to(ROOT)).encode())
            digest.update(path.read_bytes())
    return compiled_folders() / digest.hexdigest()[:16]


def compiled_folders() -> Path:
    """Return the folder of all compiled code in this environment."""
    return Path(sysconfig.get_path("platlib")) / "swarm_workbench_compiled"


def is_compiled() -> bool:
    """Whether this process takes modules from compiled code."""
    return any(isinstance(finder, _Finder) for finder in sys.meta_path)


def use_compiled() -> None:
    """Let modules be imported from compiled code, if there is any of these sources."""
    if os.environ.get(SWITCH, "0") not in ("", "0") or is_compiled():
        return
    folder = compiled_folder()
    if folder.is_dir():
        sys.meta_path.insert(0, _Finder(folder))


class _Finder(MetaPathFinder):
    """Finds the modules that are in one folder of compiled code."""

    def __init__(self, folder: Path) -> None:
        names = [path.relative_to(folder) for path in folder.rglob(f"*{SUFFIX}")]
        self._files = {str(p)[: -len(SUFFIX)].replace(os.sep, "."): folder / p for p in names}

    def find_spec(
        self, fullname: str, path: Sequence[str] | None, target: ModuleType | None = None
    ) -> ModuleSpec | None:
        """Return the spec of a module that is compiled, None for all others."""
        file = self._files.get(fullname)
        if file is None:
            return None
        loader = ExtensionFileLoader(fullname, str(file))
        return spec_from_file_location(fullname, file, loader=loader)


def edition(packages: Sequence[str] = DECIDING) -> str:
    """Return the version and a digest of the code that hosts must have in common."""
    digest = hashlib.sha256()
    for package in packages:
        for path in sorted((ROOT / package).rglob("*.py")):
            digest.update(str(path.relative_to(ROOT)).encode())
            digest.update(path.read_bytes())
    return f"{_version()} ({digest.hexdigest()[:DIGITS]})"


def _version() -> str:
    from importlib import metadata  # slow to import

    try:
        return metadata.version(DISTRIBUTION)
    except metadata.PackageNotFoundError:
        return "not installed"
