"""Turns generated sources into shared libraries: plans the compiler calls, runs them in parallel.

Per package there are five libraries and one Python extension, named as CMake would name them,
because the type-support dispatcher opens them by name.
"""

from __future__ import annotations

import subprocess
import sysconfig
from collections.abc import Callable
from concurrent.futures import FIRST_COMPLETED, Future, ThreadPoolExecutor, wait
from dataclasses import dataclass
from pathlib import Path

from swarm_common.model.errors import SwarmError
from swarm_setup.rosidl.generate import GENERATORS, TYPESUPPORTS
from swarm_setup.rosidl.packages import InterfacePackage

FLAGS = ("-O1", "-fPIC", "-w", "-DNDEBUG", "-DRCUTILS_ENABLE_FAULT_INJECTION=0")
LINK_ORDER = ("rosidl_generator_c", *TYPESUPPORTS, "rosidl_typesupport_c", "rosidl_generator_py")
# What every service and action uses without saying so.
IMPLIED = ("action_msgs", "builtin_interfaces", "service_msgs", "unique_identifier_msgs")
RUNTIME = (
    "rosidl_runtime_c", "rosidl_typesupport_c", "rosidl_typesupport_introspection_c",
    "rosidl_typesupport_fastrtps_cpp", "rosidl_typesupport_fastrtps_c",
    "rosidl_dynamic_typesupport", "rmw", "rcutils", "fastcdr",
)  # fmt: skip
UNIT_SIZE = 10  # generated sources compiled together


class BuildError(SwarmError):
    """A compiler call failed; the message holds its output."""


@dataclass(frozen=True, slots=True)
class Toolchain:
    """Programs to call and folders to search."""

    c: str
    cxx: str
    prefixes: tuple[Path, ...]  # of installed ROS packages: include/, lib/
    include: tuple[Path, ...]  # Python's and numpy's headers


@dataclass(frozen=True, slots=True)
class Library:
    """One shared library: its sources and the interface libraries that it links."""

    package: str
    target: str  # path relative to the build folder
    rpath: str  # of lib/, relative to the library's own folder
    sources: tuple[Path, ...]
    links: tuple[str, ...]  # names for -l, dropped where unused
    needs: tuple[str, ...]  # names for -l, loaded in any case


def plan(package: InterfacePackage, build: Path) -> list[Library]:
    """List the libraries of a generated package, in link order."""
    own = [_library(package, build, generator) for generator in LINK_ORDER]
    return [*own, _extension(package, build)]


def _library(package: InterfacePackage, build: Path, generator: str) -> Library:
    """Return the library of one generator; it links its peers in the packages depended on.

    The dispatcher opens the type supports by name at run time. Linking them makes that work
    without LD_LIBRARY_PATH.
    """
    folder = build / generator / package.name
    sources = [*folder.rglob("*.c"), *folder.rglob("*.cpp")]
    own = "rosidl_generator_c", "rosidl_typesupport_c"
    links = [f"{package.name}__{kind}" for kind in own if kind != generator]
    for name in {*package.depends, *IMPLIED}:
        links += [f"{name}__{kind}" for kind in {generator, "rosidl_generator_c"}]
    dispatches = generator == "rosidl_typesupport_c"
    needs = tuple(f"{package.name}__{kind}" for kind in TYPESUPPORTS) if dispatches else ()
    compiled = sorted(path for path in sources if ".ep." not in path.name)
    units = _units(compiled, build / "units" / f"{package.name}__{generator}")
    target = f"lib/lib{package.name}__{generator}.so"
    return Library(package.name, target, "$ORIGIN", units, tuple(sorted(links)), needs)


def _units(sources: list[Path], folder: Path) -> tuple[Path, ...]:
    """Write files that include several sources each, and return what is to be compiled.

    Most of a source's compile time goes into headers that all of them share. The type
    descriptions stay alone: they define the same static names.
    """
    alone = [path for path in sources if path.stem.endswith("__description")]
    others = [path for path in sources if path not in alone]
    folder.mkdir(parents=True, exist_ok=True)
    units = []
    for start in range(0, len(others), UNIT_SIZE):
        part = others[start : start + UNIT_SIZE]
        unit = folder / f"unit{start}{part[0].suffix}"
        unit.write_text("".join(f'#include "{path}"\n' for path in part))
        units.append(unit)
    return (*units, *alone)


def _extension(package: InterfacePackage, build: Path) -> Library:
    """Return the Python extension through which rclpy finds the type supports."""
    name = package.name
    entry = build / "rosidl_generator_py" / name / f"_{name}_s.ep.rosidl_typesupport_c.c"
    suffix = sysconfig.get_config_var("EXT_SUFFIX")
    needs = ("rosidl_generator_py", "rosidl_typesupport_c", "rosidl_generator_c")
    target = f"python/{name}/{name}_s__rosidl_typesupport_c{suffix}"
    linked = tuple(f"{name}__{kind}" for kind in needs)
    return Library(name, target, "$ORIGIN/../../..", (entry,), (), linked)


def build_all(
    libraries: list[Library], build: Path, tools: Toolchain, jobs: int, done: Callable[[], None]
) -> None:
    """Compile and link libraries, dependencies first, with `jobs` compiler processes at a time.

    A call that fails stops the others.
    """
    with ThreadPoolExecutor(jobs) as pool:
        objects = {
            library.target: [
                pool.submit(_compile, source, library.package, build, tools)
                for source in library.sources
            ]
            for library in libraries
        }
        try:
            _await([future for futures in objects.values() for future in futures], done)
            for library in libraries:
                files = [future.result() for future in objects[library.target]]
                _link(library, files, build, tools)
                done()
        except BaseException:
            pool.shutdown(wait=True, cancel_futures=True)
            raise


def count_calls(libraries: list[Library]) -> int:
    """Return how many compiler calls `build_all` will make."""
    return sum(len(library.sources) + 1 for library in libraries)


def _await(futures: list[Future[Path]], done: Callable[[], None]) -> None:
    waiting = set(futures)
    while waiting:
        finished, waiting = wait(waiting, return_when=FIRST_COMPLETED)
        for future in finished:
            future.result()
            done()


def _compile(source: Path, package: str, build: Path, tools: Toolchain) -> Path:
    target = source.with_suffix(source.suffix + ".o")
    compiler = (tools.cxx, "-std=c++17") if source.suffix == ".cpp" else (tools.c, "-std=gnu11")
    define = f"-DROSIDL_GENERATOR_C_BUILDING_DLL_{package}"
    files = ("-c", str(source), "-o", str(target))
    run_tool([*compiler, *FLAGS, *_includes(build, tools), define, *files])
    return target


def _includes(build: Path, tools: Toolchain) -> list[str]:
    folders = [build / generator for generator in GENERATORS]
    for prefix in tools.prefixes:
        folders += [path for path in sorted((prefix / "include").iterdir()) if path.is_dir()]
        folders.append(prefix / "include")
    return [f"-I{folder}" for folder in (*folders, *tools.include)]


def _link(library: Library, objects: list[Path], build: Path, tools: Toolchain) -> None:
    target = build / library.target
    target.parent.mkdir(parents=True, exist_ok=True)
    folders = [build / "lib", *(prefix / "lib" for prefix in tools.prefixes)]
    names = [
        name
        for name in (*library.links, *RUNTIME)
        if any((folder / f"lib{name}.so").exists() for folder in folders)
    ]
    run_tool(
        [
            tools.cxx,
            "-shared",
            "-o",
            str(target),
            f"-Wl,-soname,{target.name}",
            f"-Wl,-rpath,{library.rpath}",
            *map(str, objects),
            *(f"-L{folder}" for folder in folders),
            "-Wl,--no-as-needed",
            *(f"-l{name}" for name in library.needs),
            "-Wl,--as-needed",
            *(f"-l{name}" for name in names),
        ]
    )


def run_tool(command: list[str]) -> None:
    """Run a compiler or linker.

    Raises:
        BuildError: If it fails.
    """
    result = subprocess.run(command, capture_output=True, text=True, check=False)
    if result.returncode != 0:
        errors = result.stderr[-4000:]
        raise BuildError(f"{command[0]} failed; its last argument was {command[-1]}:\n{errors}")
