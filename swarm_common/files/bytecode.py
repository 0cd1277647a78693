"""Byte code of our modules where Python is told not to keep any (PYTHONDONTWRITEBYTECODE).

pip compiles what it installs regardless of that variable; otherwise every process would compile it
again at every start. pip does not see the interface packages, which are built here, nor sources of
an editable installation.
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

    Does nothing if Python keeps byte code itself.
    """
    if not sys.dont_write_bytecode:
        return
    import compileall  # needed by few

    for folder in folders:
        if folder.is_dir() and os.access(folder, os.W_OK):
            compileall.compile_dir(folder, quiet=2)
