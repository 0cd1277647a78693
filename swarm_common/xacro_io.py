"""Expansion of xacro files, with errors that name file and line."""

from __future__ import annotations

import contextlib
import io
import os
import re
import xml.parsers.expat
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from swarm_common.errors import RobotModelError, SwarmError
from swarm_common.packages import PackageFinder

EXPRESSION = re.compile(r"when evaluating expression '(.*?)'(?: |$)", re.DOTALL | re.MULTILINE)
PLACEHOLDERS = ("namespace", "robot_namespace", "ns", "prefix", "tf_prefix", "frame_prefix")
LONGEST = 300  # characters of xacro's own message that are shown


def expand(path: Path, arguments: Mapping[str, str], finder: PackageFinder) -> str:
    """Return a xacro file as URDF text.

    Args:
        path: Of the file.
        arguments: Values of `xacro:arg`s by name.
        finder: Of the packages in `$(find package)`.

    Raises:
        RobotModelError: If xacro refuses it; the message names the file and, if it can, the line.
    """
    import xacro  # slow to import, and not needed for plain URDF

    noise = io.StringIO()  # xacro prints its deprecation warnings
    try:
        with contextlib.redirect_stderr(noise), _packages_from(finder):
            document = xacro.parse(None, str(path))
            _fill_placeholders(document)
            xacro.init_stacks(str(path))
            xacro.all_includes.clear()
            xacro.process_doc(document, mappings=dict(arguments))
            return str(document.toxml())
    except RecursionError:
        raise RobotModelError(f"{path}: xacro cannot expand it: it includes itself") from None
    except Exception as cause:  # xacro raises its own and bare exceptions
        own = _own_error(cause)
        if own is not None:
            raise RobotModelError(f"{path}: {own}") from cause
        place = _place(path, cause, [*reversed(xacro.filestack or []), *xacro.all_includes])
        message = " ".join(str(cause).split())[:LONGEST] or type(cause).__name__
        raise RobotModelError(f"{place}: xacro cannot expand it: {message}") from cause


def _own_error(error: BaseException | None) -> SwarmError | None:
    """Return what our finder said, around which xacro wraps errors of its own."""
    while error is not None and not isinstance(error, SwarmError):
        error = error.__cause__ or error.__context__
    return error


@contextlib.contextmanager
def _packages_from(finder: PackageFinder) -> Iterator[None]:
    """Let `$(find package)` ask our finder; xacro itself knows installed packages only."""
    from xacro import substitution_args

    def find(package: str) -> str:
        return str(finder.share(package))

    before: Any = substitution_args._eval_find
    substitution_args._eval_find = substitution_args._eval_dict["find"] = find
    try:
        yield
    finally:
        substitution_args._eval_find = substitution_args._eval_dict["find"] = before


def _fill_placeholders(document: Any) -> None:
    """Define the properties that packages leave to whoever spawns the robot, as empty."""
    root = document.documentElement
    for name in reversed(PLACEHOLDERS):
        element = document.createElement("xacro:property")
        element.setAttribute("name", name)
        element.setAttribute("value", "")
        root.insertBefore(element, root.firstChild)
    root.setAttribute("xmlns:xacro", "http://www.ros.org/wiki/xacro")


def _place(path: Path, cause: Exception, files: list[str]) -> str:
    """Return `file, line n` of an error, or the file if the line is not known."""
    if isinstance(cause, xml.parsers.expat.ExpatError):
        return f"{files[0] if files else path}, line {cause.lineno}"
    expressions = EXPRESSION.findall(str(cause))
    for name in dict.fromkeys(map(os.path.normpath, files)):
        try:
            text = Path(name).read_text(encoding="utf-8", errors="replace")
        except OSError:
            continue
        for expression in expressions:
            match = re.search(r"[({]\s*" + re.escape(expression.strip()) + r"\s*[)}]", text)
            if match:
                return f"{name}, line {text.count(chr(10), 0, match.start()) + 1}"
    return str(path)
