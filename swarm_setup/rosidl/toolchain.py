"""Finds compilers, headers and the generators, and says what to install when one is missing."""

from __future__ import annotations

import importlib.util
import os
import platform
import shutil
import subprocess
import sys
import sysconfig
from collections.abc import Mapping
from pathlib import Path

from swarm_common.model.errors import SwarmError
from swarm_setup.rosidl.compile import FLAGS, Toolchain
from swarm_setup.rosidl.generate import GENERATORS


class MissingToolError(SwarmError):
    """Something that the build needs is not installed; the message names the package."""


def find_toolchain(environ: Mapping[str, str]) -> Toolchain:
    """Find everything that a build needs, by CC, CXX, PATH and AMENT_PREFIX_PATH."""
    include = Path(sysconfig.get_path("include"))
    if not (include / "Python.h").exists():
        version = f"{sys.version_info.major}.{sys.version_info.minor}"
        raise MissingToolError(
            f"Python's headers are missing ({include / 'Python.h'}), which the ROS 2 interface"
            f" packages need; install them: sudo apt install python{version}-dev"
        )
    for generator in GENERATORS:
        if importlib.util.find_spec(generator) is None:
            raise MissingToolError(
                f"the Python package {generator} is missing, which the ROS 2 interface packages"
                " need; install it: pip install 'ros-jazzy-rclpy[fastrtps]'"
            )
    import numpy

    return Toolchain(
        c=find_compiler("CC", "gcc", environ),
        cxx=find_compiler("CXX", "g++", environ),
        prefixes=ros_prefixes(environ),
        include=(include, Path(numpy.get_include())),
    )


def ros_prefixes(environ: Mapping[str, str]) -> tuple[Path, ...]:
    """Return where ROS packages are installed: this environment, then AMENT_PREFIX_PATH."""
    parts = environ.get("AMENT_PREFIX_PATH", "").split(os.pathsep)
    others = [Path(part) for part in parts if part and (Path(part) / "share").is_dir()]
    return tuple(dict.fromkeys([Path(sys.prefix), *others]))


def platform_key(tools: Toolchain) -> str:
    """Return a text that changes whenever built libraries could no longer be used."""
    version = subprocess.run(
        [tools.cxx, "-dumpfullversion"], capture_output=True, text=True, check=False
    ).stdout.strip()
    parts = [sys.version, platform.machine(), version, *FLAGS]
    for generator in GENERATORS:
        spec = importlib.util.find_spec(generator)
        parts.append(_version(generator, spec.origin if spec and spec.origin else ""))
    return "\n".join(parts)


def _version(package: str, origin: str) -> str:
    for folder in Path(origin).parents:
        file = folder / "share" / package / "package.xml"
        if file.exists():
            return file.read_text()
    return package


def find_compiler(variable: str, default: str, environ: Mapping[str, str]) -> str:
    """Return the compiler that a variable names, or the usual one.

    Raises:
        MissingToolError: If there is none.
    """
    wanted = environ.get(variable, default)
    found = shutil.which(wanted, path=environ.get("PATH"))
    if found is None:
        raise MissingToolError(
            f"the compiler {wanted} is missing, which the ROS 2 interface packages need;"
            f" install it: sudo apt install {'g++' if variable == 'CXX' else 'gcc'}"
        )
    return found
