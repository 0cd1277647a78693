"""Puts built interface packages into an environment and remembers what it put there."""

from __future__ import annotations

import contextlib
import errno
import json
import os
import shutil
import sysconfig
from dataclasses import dataclass
from pathlib import Path

from swarm_common.model.errors import SwarmError
from swarm_setup.rosidl.packages import InterfacePackage

MANIFEST = Path("share/swarm_workbench/interfaces.json")


@dataclass(frozen=True, slots=True)
class Environment:
    """Where packages are installed to."""

    prefix: Path
    site_packages: Path

    @classmethod
    def current(cls) -> Environment:
        """Return the environment of the running interpreter."""
        paths = sysconfig.get_paths()
        return cls(Path(paths["data"]), Path(paths["platlib"]))

    def installed(self) -> dict[str, str]:
        """Return the keys of the packages that were installed here, by name."""
        try:
            manifest: dict[str, dict[str, str]] = json.loads((self.prefix / MANIFEST).read_text())
        except (OSError, ValueError):
            return {}
        return {
            name: entry["key"]
            for name, entry in manifest.items()
            if (self.site_packages / name / "__init__.py").exists()
        }

    def remember(self, name: str, key: str) -> None:
        """Record in the manifest that a package has been installed."""
        manifest = {other: {"key": known} for other, known in self.installed().items()}
        manifest[name] = {"key": key}
        file = self.prefix / MANIFEST
        file.parent.mkdir(parents=True, exist_ok=True)
        temporary = file.with_suffix(f".{os.getpid()}")
        temporary.write_text(json.dumps(manifest, indent=1, sort_keys=True))
        temporary.replace(file)


def collect(package: InterfacePackage, build: Path, tree: Path) -> None:
    """Gather one package's results from a build folder into an installable tree.

    The tree appears at once, by renaming, so that an interrupted run leaves nothing half done.
    """
    name = package.name
    draft = tree.with_name(f"{tree.name}.{os.getpid()}")
    shutil.rmtree(draft, ignore_errors=True)
    (draft / "lib").mkdir(parents=True)
    for library in (build / "lib").glob(f"lib{name}__*.so"):
        shutil.copy2(library, draft / "lib")
    shutil.copytree(build / "share" / name, draft / "share" / name)
    for generator in build.glob("rosidl_*"):
        shutil.copytree(
            generator / name,
            draft / "include" / name / name,
            dirs_exist_ok=True,
            ignore=shutil.ignore_patterns("*.c", "*.cpp", "*.o", "*.py", "*.em"),
        )
    shutil.copytree(build / "python" / name, draft / "python" / name)
    shutil.copytree(
        build / "rosidl_generator_py" / name,
        draft / "python" / name,
        dirs_exist_ok=True,
        ignore=shutil.ignore_patterns("*.c", "*.o"),
    )
    _write_ament_index(package, draft / "share" / "ament_index" / "resource_index")
    shutil.rmtree(tree, ignore_errors=True)
    draft.replace(tree)


def install(name: str, key: str, tree: Path, environment: Environment) -> None:
    """Copy a tree into an environment.

    Each file is replaced at once, never written into: a swarm that runs has the old libraries
    mapped, and its processes would end by SIGSEGV.
    """
    try:
        for part in ("lib", "include", "share"):
            _copy(tree / part, environment.prefix / part)
        target = environment.site_packages / name
        _copy(tree / "python" / name, target)
        for path in target.rglob("*"):
            if path.is_file() and not (tree / "python" / name / path.relative_to(target)).exists():
                path.unlink(missing_ok=True)
        environment.remember(name, key)
    except OSError as error:
        if error.errno not in (errno.EACCES, errno.EPERM, errno.EROFS):
            raise
        raise SwarmError(
            f"no permission to install {name} into {environment.prefix}: {error.filename};"
            " use a virtual environment (python3 -m venv .venv)"
        ) from error


def _copy(source: Path, target: Path) -> None:
    target.mkdir(parents=True, exist_ok=True)
    for path in source.iterdir():
        if path.is_dir():
            _copy(path, target / path.name)
        else:
            _replace(path, target / path.name)


def _replace(source: Path, target: Path) -> None:
    draft = target.with_name(f"{target.name}.{os.getpid()}")
    try:
        shutil.copy2(source, draft)
        draft.replace(target)
    except OSError:
        with contextlib.suppress(OSError):
            draft.unlink()
        raise


def _write_ament_index(package: InterfacePackage, index: Path) -> None:
    texts = {
        "packages": "",
        "package_run_dependencies": ";".join(package.depends),
        "rosidl_interfaces": "\n".join(
            name
            for relative in package.files
            for name in (relative.with_suffix(".idl").as_posix(), relative.as_posix())
        ),
    }
    for kind, text in texts.items():
        (index / kind).mkdir(parents=True, exist_ok=True)
        (index / kind / package.name).write_text(text)
