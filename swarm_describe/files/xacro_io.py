"""Expansion of xacro files, with errors that name file and line."""

from __future__ import annotations

import contextlib
import io
import os
import re
import xml.parsers.expat
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from swarm_common.model.errors import (
    MissingPackageError,
    RobotModelError,
    SwarmError,
    UnknownNameError,
)
from swarm_describe.files.faults import Faults
from swarm_describe.files.packages import PackageFinder

EXPRESSION = re.compile(r"when evaluating expression '(.*?)'(?: |$)", re.DOTALL | re.MULTILINE)
UNDEFINED = re.compile("[Uu]ndefined substitution argument")
COMMENT = re.compile(r"<!--.*?-->", re.DOTALL)
FIND = re.compile(r"\$\(find(?:-pkg-share)?\s+([^)\s]+)\s*\)")
ARGUMENT = re.compile(r"\$\(arg\s+([^)\s]+)\s*\)")
DECLARED = re.compile(r"<xacro:arg\b[^>]*?\bname=[\"']([^\"']+)[\"'][^>]*?\bdefault=")
ANY_ARGUMENT = re.compile(r"<xacro:arg\b[^>]*?\bname=[\"']([^\"']+)[\"']")
MACRO = re.compile(r"<xacro:macro\b[^>]*?\bname=[\"']([^\"']+)[\"']([^>]*)>")
PARAMS = re.compile(r"\bparams=[\"']([^\"']*)[\"']")
LINK = re.compile(r"<link\b")
INCLUDE = re.compile(r"<(?:xacro:)?include\b[^>]*?\bfilename=[\"']([^\"']+)[\"']")
MOST_FILES = 200  # that are searched for missing packages
PLACEHOLDERS = ("namespace", "robot_namespace", "ns", "prefix", "tf_prefix", "frame_prefix")
LONGEST = 300  # characters of xacro's own message that are shown


def expand(
    path: Path, arguments: Mapping[str, str], finder: PackageFinder, advice: str = ""
) -> str:
    """Return a xacro file as URDF text.

    Args:
        advice: Advice about an argument without a value; empty for robots.
    """
    from swarm_describe.files import xacro_compat  # slow to import, not needed for plain URDF

    noise = io.StringIO()  # xacro prints its deprecation warnings
    try:
        find = xacro_compat.packages_from(lambda package: str(finder.share(package)))
        with contextlib.redirect_stderr(noise), find:
            text = xacro_compat.expand(path, arguments, _fill_placeholders)
        _check_used(path, arguments, xacro_compat.open_files())
        return text
    except UnknownNameError:
        raise
    except RecursionError:
        raise RobotModelError(f"{path}: xacro cannot expand it: it includes itself") from None
    except Exception as cause:  # xacro raises its own and bare exceptions
        own = _own_error(cause)
        faults = Faults(str(path), RobotModelError)
        packages, names = unresolved(path, arguments, finder)
        if isinstance(own, MissingPackageError):
            own = MissingPackageError([*own.packages, *packages], own.searched)
        if own is not None:
            faults.tell([f"{path}: {own}"])
        if names and (own is not None or UNDEFINED.search(str(cause))):
            faults.tell([f"{path}: {_undefined(names, advice)}"])
        if faults:
            try:
                faults.check()
            except RobotModelError as error:
                raise error from cause
        place = _place(path, cause, xacro_compat.open_files())
        message = " ".join(str(cause).split())[:LONGEST] or type(cause).__name__
        raise RobotModelError(f"{place}: xacro cannot expand it: {message}") from cause


def macro_message(path: Path, expanded: str) -> str:
    """Return advice on a xacro file that only defines macros; empty for any other."""
    text = COMMENT.sub("", path.read_text(encoding="utf-8", errors="replace"))
    macros = MACRO.findall(text)
    if not macros or LINK.search(expanded):
        return ""
    callers = [
        other.name
        for other in sorted(path.parent.glob("*.xacro"))
        if other != path and path.name in other.read_text(encoding="utf-8", errors="replace")
    ]
    calls = []
    for name, more in macros:
        given = PARAMS.search(more)
        params = given.group(1).split() if given else []
        plain = [p for p in params if p[0] != "*" and "=" not in p]  # without a default
        blocks = "".join('<origin xyz="0 0 0"/>' for p in params if p[0] == "*")
        start = f"<xacro:{name}" + "".join(f' {p}="..."' for p in plain)
        calls.append(f"{start}>{blocks}</xacro:{name}>" if blocks else f"{start}/>")
    names = ", ".join(f"'{name}'" for name, _ in macros)
    return (
        f"{path} defines the macro{'s' if len(macros) > 1 else ''} {names} and no link: a robot "
        "is made where a macro is called. "
        + (
            f"Start with a file that includes it: {', '.join(callers)}. Or write"
            if callers
            else "Write"
        )
        + f' one beside it: <robot name="{path.name.split(".")[0]}" '
        'xmlns:xacro="http://www.ros.org/wiki/xacro"><xacro:include '
        f'filename="{path.name}"/>{calls[-1]}</robot>'
    )


def _check_used(path: Path, arguments: Mapping[str, str], files: Sequence[str]) -> None:
    """Raise RobotModelError for a given argument that no file declares or uses."""
    known: dict[str, None] = {}
    for name in [str(path), *files]:
        with contextlib.suppress(OSError):
            text = Path(name).read_text(encoding="utf-8", errors="replace")
            known |= dict.fromkeys([*ARGUMENT.findall(text), *ANY_ARGUMENT.findall(text)])
    for name in arguments:
        if name not in known:
            raise UnknownNameError("xacro argument", name, known, f"xacro_args for {path}")


def unresolved(
    path: Path, arguments: Mapping[str, str], finder: PackageFinder
) -> tuple[list[str], list[str]]:
    """Return packages that are missing to a xacro file, and arguments that it uses without a value.

    Args:
        path: The files that it includes are searched, too.
    """
    packages: dict[str, None] = {}
    used: dict[str, None] = {}
    known = set(arguments)
    waiting: list[Path] = [path]
    seen: set[Path] = set()
    while waiting:
        file = waiting.pop(0)
        if file in seen or len(seen) > MOST_FILES:
            continue
        seen.add(file)
        try:
            text = COMMENT.sub("", file.read_text(encoding="utf-8", errors="replace"))
        except OSError:
            continue
        used |= dict.fromkeys(ARGUMENT.findall(text))
        known |= set(DECLARED.findall(text))
        for package in FIND.findall(text):
            with contextlib.suppress(RobotModelError):
                finder.share(package)
                continue
            packages[package] = None
        for name in INCLUDE.findall(text):
            with contextlib.suppress(RobotModelError):
                whole = FIND.sub(lambda match: str(finder.share(match.group(1))), name)
                waiting.append(file.parent / whole)
    return list(packages), [name for name in used if name not in known]


def _undefined(names: Sequence[str], advice: str) -> str:
    values = ", ".join(f"{name}: ..." for name in names)
    return (
        f"$(arg {names[0]}) has no value"
        + "".join(f", nor has $(arg {name})" for name in names[1:])
        + f"; {advice or f'write it into robot.yaml, xacro_args: {{{values}}}'}"
    )


def _own_error(error: BaseException | None) -> SwarmError | None:
    """Return our package finder's message, which xacro wraps in errors of its own."""
    while error is not None and not isinstance(error, SwarmError):
        error = error.__cause__ or error.__context__
    return error


def _fill_placeholders(document: Any) -> None:
    """Define as empty the properties that packages expect from the spawner of the robot."""
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
