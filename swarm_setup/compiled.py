"""Compiles the Python that runs in every tick, with mypyc.

One shared library holds the code of all modules, which so call each other without Python; beside
it, each module has a small one that the import system loads.
"""

from __future__ import annotations

import contextlib
import json
import os
import shutil
import subprocess
import sys
import sysconfig
import tempfile
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

from swarm_common.process.compiled_code import (
    PACKAGES,
    ROOT,
    SUFFIX,
    compiled_folder,
    compiled_folders,
)
from swarm_setup.rosidl.compile import BuildError, run_tool
from swarm_setup.rosidl.toolchain import find_compiler

FOLDERS = (
    "behaviour", "control", "core", "localisation", "perception", "planning", "reservation",
    "traffic",
)  # fmt: skip
LEFT = {  # besides modules with kernels of numba's
    "core/config.py",
    "core/localisation_config.py",  # the comments in them are read, too
    "core/limits.py",  # their classes inherit from one of it
    "core/goals.py",  # made in many places, and from names
    "behaviour/plain.py",  # brains of others inherit from it
    "behaviour/plugin_brain.py",  # gives itself methods of the plug-in
    "behaviour/costmap.py",  # mypyc knows no field that is a slice
    "planning/terrain.py",  # attributes beyond those of the class
}
FLAGS = ("-fPIC", "-DNDEBUG", "-w", "-Wno-error", "-ffp-contract=off")  # bits as Python's
MOST_KEPT = 3  # states of the sources in one environment; the oldest go first
TRANSLATOR = """
import json, pathlib, sys
from mypyc.build import mypycify
build = sys.argv[1]
made = mypycify(
    sys.argv[2:], opt_level="1", debug_level="0", multi_file=True, target_dir=build,
    group_name="swarm_workbench",
)
kept = "name", "sources", "include_dirs", "extra_compile_args"
extensions = [{key: getattr(extension, key) for key in kept} for extension in made]
pathlib.Path(build, "extensions.json").write_text(json.dumps(extensions))
"""
CONFIG = """
[mypy]
always_true = COMPILED
ignore_missing_imports = true
follow_imports = silent
[mypy-numba.*,scipy.*,shapely.*,trimesh.*,PIL.*]
follow_imports = skip
"""


def ensure_compiled() -> bool:
    """Compile the sources as they are, unless that has been done; return whether it was needed.

    Raises:
        SwarmError: If mypyc or the compiler does not take them.
    """
    folder = compiled_folder()
    if folder.is_dir():
        return False
    compiled_folders().mkdir(parents=True, exist_ok=True)
    draft = Path(tempfile.mkdtemp(prefix="draft-", dir=compiled_folders()))
    try:
        _build(_translate(draft), draft / folder.name)
        with contextlib.suppress(OSError):  # another process was faster
            (draft / folder.name).rename(folder)
    finally:
        shutil.rmtree(draft, ignore_errors=True)
    made = sorted(compiled_folders().iterdir(), key=lambda path: path.stat().st_mtime)
    for old in made[:-MOST_KEPT]:
        shutil.rmtree(old, ignore_errors=True)
    return True


def modules() -> list[Path]:
    """Return the source files that are compiled."""
    package = ROOT / "swarm_nav"
    found = [path for folder in FOLDERS for path in sorted((package / folder).glob("*.py"))]
    found = [path for path in found if str(path.relative_to(package)) not in LEFT]
    return [path for path in found if path.stem != "__init__" and "@njit" not in path.read_text()]


def _translate(draft: Path) -> list[dict[str, Any]]:
    """Write C for the modules; return what is to be built from it.

    From a copy of the sources: among installed packages mypy takes others for ours. In a process
    of its own: mypyc changes setuptools, and ends its process where it finds errors.
    """
    sources, build = draft / "sources", draft / "c"
    for package in PACKAGES:
        shutil.copytree(ROOT / package, sources / package, ignore=shutil.ignore_patterns("data"))
    build.mkdir()
    (sources / "mypy.ini").write_text(CONFIG)
    names = [str(path.relative_to(ROOT)) for path in modules()]
    command = [sys.executable, "-c", TRANSLATOR, str(build), *names]
    result = subprocess.run(command, cwd=sources, capture_output=True, text=True, check=False)
    if result.returncode != 0:
        raise BuildError(f"mypyc failed:\n{(result.stdout + result.stderr)[-4000:]}")
    extensions: list[dict[str, Any]] = json.loads((build / "extensions.json").read_text())
    return extensions


def _build(extensions: list[dict[str, Any]], target: Path) -> None:
    """Compile and link extensions with all cores."""
    compiler = find_compiler("CC", "gcc", os.environ)

    def compile_source(extension: dict[str, Any], source: str) -> None:
        folders = [*extension["include_dirs"], sysconfig.get_path("include")]
        flags = [*extension["extra_compile_args"], *FLAGS, *(f"-I{folder}" for folder in folders)]
        run_tool([compiler, *flags, "-c", source, "-o", f"{source}.o"])

    def link(extension: dict[str, Any]) -> None:
        library = target / (extension["name"].replace(".", os.sep) + SUFFIX)
        library.parent.mkdir(parents=True, exist_ok=True)
        objects = [f"{source}.o" for source in extension["sources"]]
        run_tool([compiler, "-shared", *objects, "-o", str(library)])

    with ThreadPoolExecutor(len(os.sched_getaffinity(0))) as pool:
        works = [(each, source) for each in extensions for source in each["sources"]]
        list(pool.map(lambda work: compile_source(*work), works))
        list(pool.map(link, extensions))
