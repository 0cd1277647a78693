"""The private parts of xacro that we use, all in one place; written for xacro 2.1.

xacro has no public way to find packages in other places than an installed ROS, to expand a
document that was changed after parsing, or to know which files were open when it gave up.
"""

from __future__ import annotations

import contextlib
import io
import os
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import Any

import xacro
from xacro import substitution_args

from swarm_common.process.private_parts import require

PARTS: tuple[tuple[Any, str], ...] = (
    (xacro, "all_includes"),
    (xacro, "filestack"),
    (xacro, "init_stacks"),
    (xacro, "parse"),
    (xacro, "process_doc"),
    (substitution_args, "_eval_dict"),
    (substitution_args, "_eval_find"),
)
require("xacro", __name__, PARTS)


def expand(path: Path, arguments: Mapping[str, str], prepare: Callable[[Any], None]) -> str:
    """Return a xacro file as URDF text.

    Raises:
        Exception: One of xacro's own kinds, or a bare one.
    """
    with _encoded_files():
        document = xacro.parse(None, str(path))
        prepare(document)
        xacro.init_stacks(str(path))
        xacro.all_includes.clear()
        xacro.process_doc(document, mappings=dict(arguments))
    return str(document.toxml())


@contextlib.contextmanager
def _encoded_files() -> Iterator[None]:
    """Within it, files are read in the encoding that they declare; xacro itself reads UTF-8."""
    before: Any = xacro.parse

    def _parse(source: Any, filename: str | None = None) -> Any:
        if source is None and filename is not None and os.path.isfile(filename):
            source = io.BytesIO(Path(filename).read_bytes().lstrip())
        return before(source, filename)

    xacro.parse = _parse
    try:
        yield
    finally:
        xacro.parse = before


def open_files() -> list[str]:
    """Return the files that xacro had open when it gave up, the innermost first."""
    return [*reversed(xacro.filestack or []), *xacro.all_includes]


@contextlib.contextmanager
def packages_from(find: Callable[[str], str]) -> Iterator[None]:
    """Within it, `$(find package)` asks a function of ours.

    Args:
        find: Returns the folder of a package by its name; what it raises ends the expansion.
    """
    before: Any = substitution_args._eval_find
    substitution_args._eval_find = substitution_args._eval_dict["find"] = find
    try:
        yield
    finally:
        substitution_args._eval_find = substitution_args._eval_dict["find"] = before
