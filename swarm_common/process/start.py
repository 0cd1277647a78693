"""The start of our own processes: `python -P -m swarm_common.process.start MODULE [ARGUMENT ...]`.

Importing a package of ours changes nothing outside of it. A damaged file of compiled code would
end every later start, so our processes have Python's loader changed here. A
page is opened in the user's browser by a process of its own, too.
"""

from __future__ import annotations

import contextlib
import os
import runpy
import sys
from collections.abc import Iterable, Mapping
from importlib.machinery import SourceFileLoader
from importlib.util import cache_from_source
from pathlib import Path
from types import CodeType
from typing import Any

DISPLAYS = ("DISPLAY", "WAYLAND_DISPLAY")
HERE = Path(__file__).resolve().parents[2]
MODULE = "swarm_common.process.start"
_usual = SourceFileLoader.get_code


def command(module: str, *arguments: str) -> tuple[str, ...]:
    """Return the command that runs a module as a process of ours."""
    return (sys.executable, "-P", "-m", MODULE, module, *arguments)


def prepare() -> None:
    """Set up this process so that damaged files of compiled code count as missing.

    A disk that fills up, or a limit on file sizes, cuts a `.pyc` short, and Python before 3.12.8
    and 3.13.1 keeps it (https://github.com/python/cpython/issues/126606). Every import of the
    module raises EOFError or ValueError from then on.
    """
    SourceFileLoader.get_code = _code_of  # type: ignore[assignment]


def _code_of(loader: SourceFileLoader, name: str) -> CodeType | Any | None:
    """Return a module's code, compiled anew where its `.pyc` is damaged; that file is removed."""
    try:
        return _usual(loader, name)
    except (EOFError, TypeError, ValueError):  # as marshal raises them
        path = loader.get_filename(name)
        with contextlib.suppress(OSError):  # not ours to remove
            os.unlink(cache_from_source(path))
        return loader.source_to_code(loader.get_data(path), path)


def own_packages() -> list[Path]:
    """Return the folders of our own packages."""
    return [file.parent for file in sorted(HERE.glob("swarm_*/__init__.py"))]


def ensure_bytecode(folders: Iterable[Path]) -> None:
    """Compile the modules in folders whose byte code is missing or out of date.

    Does nothing unless PYTHONDONTWRITEBYTECODE is set. pip compiles what it installs all the same,
    but not the interface packages that are built here, nor an editable installation.
    """
    if not sys.dont_write_bytecode:
        return
    import compileall  # needed by few

    for folder in folders:
        if folder.is_dir() and os.access(folder, os.W_OK):
            compileall.compile_dir(folder, quiet=2)


if __name__ == "__main__":
    prepare()
    sys.argv = sys.argv[1:]
    runpy.run_module(sys.argv[0], run_name="__main__", alter_sys=True)


def has_display(environment: Mapping[str, str] = os.environ) -> bool:
    """True if this terminal can open a window."""
    return any(environment.get(name) for name in DISPLAYS)


def open_page(url: str) -> None:
    """Open a page, from a process of its own: some browsers return only when they are closed."""
    import subprocess  # slow to import, and every process of ours starts here

    nothing = subprocess.DEVNULL
    subprocess.Popen(
        [sys.executable, "-m", "webbrowser", url],
        stdin=nothing,
        stdout=nothing,
        stderr=nothing,
        start_new_session=True,
    )
