"""Runs the rosidl generators: definitions in, C and Python sources out.

The steps are those that `rosidl_generate_interfaces` would have CMake run; the C++ API and the
C++ type supports are left out, since nothing in Python loads them.
"""

from __future__ import annotations

import contextlib
import functools
import importlib
import io
import json
import shutil
from pathlib import Path
from typing import Any

from swarm_setup.rosidl.packages import InterfacePackage

PARSER_USERS = (
    "rosidl_pycommon",
    "rosidl_generator_type_description",
    "rosidl_generator_py.generate_py_impl",
)
TYPESUPPORTS = ("rosidl_typesupport_fastrtps_c", "rosidl_typesupport_introspection_c")
GENERATORS = ("rosidl_generator_c", "rosidl_generator_py", "rosidl_typesupport_c", *TYPESUPPORTS)


def prepare(package: InterfacePackage, build: Path, prefixes: tuple[Path, ...]) -> None:
    """Convert the definitions to IDL and describe their types (with hashes).

    The package's dependencies must have been prepared. `build/share/<package>` is written;
    `prefixes` have `share/<package>` of installed ones.
    """
    from rosidl_adapter import convert_to_idl

    share = build / "share" / package.name
    for relative in package.files:
        (share / relative).parent.mkdir(parents=True, exist_ok=True)
        shutil.copyfile(package.folder / relative, share / relative)
        with contextlib.redirect_stdout(io.StringIO()):
            convert_to_idl(package.folder, package.name, relative, share)
    shutil.copyfile(package.folder / "package.xml", share / "package.xml")
    folders = [
        f"{path.name}:{path}"
        for prefix in reversed((build, *prefixes))
        for path in sorted((prefix / "share").iterdir())
        if any((path / kind).is_dir() for kind in ("msg", "srv", "action"))
    ]
    _cache_parser()
    arguments = _arguments(package, build, share)
    arguments["include_paths"] = folders
    module = importlib.import_module("rosidl_generator_type_description")
    module.generate_type_hash(_write(arguments, build, "type_description"))


def generate(package: InterfacePackage, build: Path, prefix: Path, generator: str) -> None:
    """Run one generator for one prepared package into `build/<generator>/<package>`."""
    _cache_parser()
    output = build / generator / package.name
    arguments = _arguments(package, build, output)
    arguments["template_dir"] = str(prefix / "share" / generator / "resource")
    for kind in {relative.parent.name for relative in package.files} | {"msg"}:
        (output / kind / "detail").mkdir(parents=True, exist_ok=True)
    file = _write(arguments, build, generator)
    module = importlib.import_module(generator)
    if generator == "rosidl_generator_py":
        (output / "__init__.py").touch()
        module.generate_py(file, ["rosidl_typesupport_c"])
    elif generator == "rosidl_typesupport_c":
        module.generate_c(file, list(TYPESUPPORTS))
    elif generator == "rosidl_typesupport_fastrtps_c":
        module.generate_typesupport_fastrtps_c(file)
    else:
        module.generate_c(file)
    _write_visibility_control(prefix, generator, package, output)


def _arguments(package: InterfacePackage, build: Path, output: Path) -> dict[str, object]:
    share = build / "share" / package.name
    idl = [relative.with_suffix(".idl") for relative in package.files]
    return {
        "package_name": package.name,
        "output_dir": str(output),
        "idl_tuples": [f"{share}:{path.as_posix()}" for path in idl],
        "type_description_tuples": [
            f"{path.as_posix()}:{share / path.with_suffix('.json')}" for path in idl
        ],
        "ros_interface_files": [str(share / relative) for relative in package.files],
        "ros_interface_dependencies": [],
        "target_dependencies": [str(share / path) for path in idl],
    }


def _write(arguments: dict[str, object], build: Path, generator: str) -> str:
    file = build / "arguments" / f"{arguments['package_name']}__{generator}.json"
    file.parent.mkdir(exist_ok=True)
    file.write_text(json.dumps(arguments, indent=1))
    return str(file)


def _write_visibility_control(
    prefix: Path, generator: str, package: InterfacePackage, output: Path
) -> None:
    """Fill in the header with the export macros, which CMake's configure_file would write."""
    resource = prefix / "share" / generator / "resource"
    for template in resource.glob("*visibility_control.h.in"):
        text = template.read_text().replace("@PROJECT_NAME@", package.name)
        text = text.replace("@PROJECT_NAME_UPPER@", package.name.upper())
        (output / "msg" / template.stem).write_text(text)


@functools.cache
def _cache_parser() -> None:
    """Parse each IDL file once per process; every generator parses all of them again."""
    parse = importlib.import_module("rosidl_parser.parser").parse_idl_file
    known: dict[Path, object] = {}

    def parse_once(locator: Any) -> object:
        path = locator.get_absolute_path()
        if path not in known:
            known[path] = parse(locator)
        return known[path]

    for name in PARSER_USERS:
        importlib.import_module(name).__dict__["parse_idl_file"] = parse_once
