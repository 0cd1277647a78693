"""Byte code of our modules where Python is told not to keep any (PYTHONDONTWRITEBYTECODE).

pip compiles what it installs whatever that variable says, as each start would else compile it
anew, in every process. It does not see interface packages, which are built here, and sources that
are used where they lie.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Iterable
from pathlib import Path

HERE = Path(__file__).resolve().parents[2]


def own_packages() -> list[Path]:
    """Return the folders of our own packages."""
    return [file.parent for file in sorted(HERE.glob("swarm_*/__init__.py"))]


def ensure_bytecode(folders: Iterable[Path]) -> None:
    """Compile the modules in folders whose byte code is missing or out of date.

    Does nothing where Python does it, and where nothing can be written.
    """
    if not sys.dont_write_bytecode:
        return
    import compileall  # needed by few

    for folder in folders:
        if folder.is_dir() and os.access(folder, os.W_OK):
            compileall.compile_dir(folder, quiet=2)
