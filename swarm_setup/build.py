"""Provides the ROS 2 interface packages that PyPI lacks.

What the environment already has (a full ROS 2 installation) is used as it is. The rest is built
from `interfaces/` once, kept in the user's cache by content, and copied into the environment.
"""

from __future__ import annotations

import fcntl
import importlib.util
import os
import re
import shutil
import sys
import tempfile
from collections.abc import Callable, Iterator
from concurrent.futures import ProcessPoolExecutor
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path

from rich.console import Console
from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn

from swarm_common.files.resources import share_directory
from swarm_common.files.storage import cache_folder
from swarm_common.model.errors import SwarmError
from swarm_setup.rosidl import compile as compiling
from swarm_setup.rosidl import generate, install, packages, toolchain
from swarm_setup.rosidl.packages import InterfacePackage

INDEX = Path("share/ament_index/resource_index/packages")
# Least release of each major that has what we use, for packages that others may have installed.
RELEASES = {"simulation_interfaces": ((1, 5), (2, 1)), "nav2_msgs": ((1, 3),)}
VERSION = re.compile(r"<version>\s*(\d+)\.(\d+)[\d.]*\s*</version>")


def ensure_interfaces(*, quiet: bool = False) -> list[str]:
    """Build and install interface packages that are missing or out of date; return their names."""
    environment = install.Environment.current()
    wanted = _wanted()
    stale = _stale(wanted, environment)
    if not stale:
        return []
    tools = toolchain.find_toolchain(os.environ)
    platform = toolchain.platform_key(tools)
    with _lock(builds_folder()):
        trees = {p.name: builds_folder() / f"{p.name}-{_key(p, wanted, platform)}" for p in wanted}
        missing = [package for package in wanted if not trees[package.name].exists()]
        if missing:
            ready = tuple(tree for tree in trees.values() if tree.exists())
            _build(missing, trees, ready, tools, quiet=quiet)
        for package in stale:
            key = _key(package, wanted, sys.version)
            install.install(package.name, key, trees[package.name], environment)
    importlib.invalidate_caches()
    return [package.name for package in stale]


def stale_interfaces() -> list[str]:
    """Return the names of the interface packages that are missing or out of date."""
    environment = install.Environment.current()
    return [package.name for package in _stale(_wanted(), environment)]


def builds_folder() -> Path:
    """Return where finished builds are kept."""
    return cache_folder() / "interfaces"


def interface_packages() -> list[Path]:
    """Return the folders of the interface packages that were installed by us."""
    environment = install.Environment.current()
    return [environment.site_packages / name for name in environment.installed()]


def foreign_interfaces() -> dict[str, Path]:
    """Return the interface packages that somebody else installed, and where."""
    environment = install.Environment.current()
    names = [package.name for package in _packages()]
    found = {name: prefix for name in names if (prefix := _provider(name, environment))}
    for name, prefix in found.items():
        _check_release(name, prefix)
    return found


def _wanted() -> list[InterfacePackage]:
    foreign = foreign_interfaces()
    return [package for package in _packages() if package.name not in foreign]


def _packages() -> list[InterfacePackage]:
    return packages.load_packages(share_directory("interfaces") / "interfaces")


def _stale(
    wanted: list[InterfacePackage], environment: install.Environment
) -> list[InterfacePackage]:
    """Return those that are not installed as `interfaces/` has them."""
    installed = environment.installed()
    return [p for p in wanted if installed.get(p.name) != _key(p, wanted, sys.version)]


def _provider(name: str, environment: install.Environment) -> Path | None:
    """Return where somebody else installed the package that is imported, by the ament indices.

    It may hide one that we have installed: a ROS 2 that was sourced later is before it.
    """
    spec = importlib.util.find_spec(name)
    places = list(spec.submodule_search_locations or ()) if spec else []
    if not places or (
        name in environment.installed() and Path(places[0]) == environment.site_packages / name
    ):
        return None
    prefixes = [p for p in toolchain.ros_prefixes(os.environ) if (p / INDEX / name).exists()]
    around = [prefix for prefix in prefixes if prefix in Path(places[0]).parents]
    return next(iter(around or prefixes), None)


def _check_release(name: str, prefix: Path) -> None:
    file = prefix / "share" / name / "package.xml"
    match = VERSION.search(file.read_text(encoding="utf-8")) if file.is_file() else None
    if match is None or name not in RELEASES:
        return
    major, minor = int(match[1]), int(match[2])
    if any(major == least[0] and minor >= least[1] for least in RELEASES[name]):
        return
    wanted = " or ".join(f"{one}.{two} and later {one}.x" for one, two in RELEASES[name])
    raise SwarmError(
        f"{name} {major}.{minor} in {prefix} does not have all that is used here; expected"
        f" {wanted}: update it, or leave it out of AMENT_PREFIX_PATH and PYTHONPATH to have ours"
        " built"
    )


def _key(package: InterfacePackage, among: list[InterfacePackage], platform: str) -> str:
    """Return the key of a package and those among the others that it needs, directly or not."""
    names = {package.name}
    for other in reversed(among):
        if other.name in names:
            names.update(other.depends)
    return packages.content_key([other for other in among if other.name in names], platform)


@contextmanager
def _lock(folder: Path) -> Iterator[None]:
    """Let one process at a time build and install."""
    folder.mkdir(parents=True, exist_ok=True)
    with (folder / "lock").open("w") as file:
        try:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            sys.stderr.write(
                "another process builds the interface packages; waiting for its end"
                f" (its lock: {folder / 'lock'})\n"
            )
            sys.stderr.flush()
            fcntl.flock(file, fcntl.LOCK_EX)
        yield


def _build(
    missing: list[InterfacePackage],
    trees: dict[str, Path],
    ready: tuple[Path, ...],
    tools: compiling.Toolchain,
    *,
    quiet: bool,
) -> None:
    """Build packages and put each one's results into its tree in the cache."""
    tools = replace(tools, prefixes=(*ready, *tools.prefixes))
    count = TextColumn("{task.completed}/{task.total}")
    columns = (TextColumn("{task.description}"), BarColumn(), count, TimeElapsedColumn())
    build = Path(tempfile.mkdtemp(prefix="build-", dir=builds_folder()))
    try:
        with Progress(*columns, console=Console(stderr=True), disable=quiet) as progress:
            task = progress.add_task("", total=None)
            names = ", ".join(package.name for package in missing)
            progress.update(task, description=f"generating {names}")
            jobs = max(1, len(os.sched_getaffinity(0)))
            _generate(missing, build, tools.prefixes, jobs, lambda: progress.advance(task))
            libraries = [lib for package in missing for lib in compiling.plan(package, build)]
            progress.reset(task, total=compiling.count_calls(libraries))
            progress.update(task, description=f"compiling {names}")
            compiling.build_all(libraries, build, tools, jobs, lambda: progress.advance(task))
        for package in missing:
            install.collect(package, build, trees[package.name])
    finally:
        shutil.rmtree(build, ignore_errors=True)


def _generate(
    missing: list[InterfacePackage],
    build: Path,
    prefixes: tuple[Path, ...],
    jobs: int,
    done: Callable[[], None],
) -> None:
    for package in missing:
        generate.prepare(package, build, prefixes)
        done()
    homes = {name: _resources(name, prefixes) for name in generate.GENERATORS}
    with ProcessPoolExecutor(jobs) as pool:
        futures = [
            pool.submit(generate.generate, package, build, home, name)
            for package in missing
            for name, home in homes.items()
        ]
        for future in futures:
            future.result()
            done()


def _resources(generator: str, prefixes: tuple[Path, ...]) -> Path:
    for prefix in prefixes:
        if (prefix / "share" / generator / "resource").is_dir():
            return prefix
    raise SwarmError(f"the templates of {generator} are missing under {prefixes}")
