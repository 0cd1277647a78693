"""An environment with the project's wheel and its dependencies, and nothing of the checkout."""

import json
import os
import shutil
import subprocess
import sys
import sysconfig
from collections.abc import Callable, Collection
from pathlib import Path

from swarm_setup.rosidl.install import MANIFEST

ROOT = Path(__file__).parents[2]
OURS = ("swarm_", "_editable_impl_swarm", "swarm-")
COMPILED = "swarm_workbench_compiled"  # navigators: they are found by the content of the sources
# Plain nodes have no profile of ours; segments of shared memory would be found by other tests.
NO_SEGMENTS = {"FASTDDS_BUILTIN_TRANSPORTS": "UDPv4"}
KEPT = ("HOME", "LANG", "PATH", "TMPDIR", "ROS_AUTOMATIC_DISCOVERY_RANGE")  # of the tests' shell


class WheelEnvironment:
    """A Python environment beside that of the tests, whose dependencies it shares as links."""

    def __init__(self, folder: Path) -> None:
        """Build the wheel and install it."""
        self.prefix, wheels = folder / "environment", folder / "wheels"
        self._run(sys.executable, "-m", "venv", "--without-pip", self.prefix)
        share_dependencies(Path(sys.prefix), self.prefix)
        pip = (sys.executable, "-m", "pip", "--quiet")
        build = ("wheel", "--no-deps", "--no-build-isolation", "--wheel-dir", wheels, ROOT)
        self._run(*pip, *build)
        python = ("--python", self.prefix / "bin" / "python")
        self._run(*pip, *python, "install", "--no-deps", "--no-index", *wheels.glob("*.whl"))

    def _run(self, *command: str | Path) -> None:
        done = subprocess.run(command, capture_output=True, text=True, check=False)
        assert done.returncode == 0, f"{command}\n{done.stdout}{done.stderr}"

    def variables(self, **more: str) -> dict[str, str]:
        kept = {name: os.environ[name] for name in KEPT if name in os.environ}
        path = f"{self.prefix / 'bin'}:{kept['PATH']}"
        return kept | NO_SEGMENTS | {"PATH": path, "MPLBACKEND": "Agg"} | more


def share_dependencies(source: Path, target: Path) -> None:
    """Link the files of an environment into another one, but for what is built from this project.

    Nothing writes into a file that is installed (`swarm_setup.rosidl.install`), so that links do.
    """
    built = tuple(json.loads((source / MANIFEST).read_text()))
    packages = Path(sysconfig.get_path("platlib")).relative_to(source)
    for folder in (Path("lib"), Path("share"), Path("include")):
        shutil.copytree(
            source / folder, target / folder, symlinks=True, dirs_exist_ok=True,
            ignore=_of_ours(source, packages, built), copy_function=_link,
        )  # fmt: skip


def _of_ours(
    source: Path, packages: Path, built: Collection[str]
) -> Callable[[str, list[str]], set[str]]:
    def ignored(folder: str, names: list[str]) -> set[str]:
        place = Path(folder).relative_to(source)
        found = {name for name in names if name in built}
        if place == packages:
            found |= {name for name in names if name.startswith(OURS)} - {COMPILED}
        elif place == Path("share"):
            found.add(MANIFEST.parts[1])
        elif place == Path("lib"):
            found |= {name for name in names if name.startswith(tuple(f"lib{b}__" for b in built))}
        return found

    return ignored


def _link(source: str, target: str) -> None:
    try:
        os.link(source, target)
    except OSError:  # on another disk
        shutil.copy2(source, target)
