"""Compiled modules that are damaged must not break every later start."""

from __future__ import annotations

import contextlib
import os
from importlib.machinery import SourceFileLoader
from importlib.util import cache_from_source
from types import CodeType
from typing import Any

_usual = SourceFileLoader.get_code


def read_damaged_as_missing() -> None:
    """Have this process compile a module anew where its `.pyc` is damaged, and remove that file.

    A disk that fills up, or a limit on file sizes, cuts it short, and Python before 3.12.8 and
    3.13.1 keeps what it wrote (https://github.com/python/cpython/issues/126606). Every import of
    the module raises EOFError or ValueError from then on.
    """
    SourceFileLoader.get_code = _code_of  # type: ignore[assignment]


def _code_of(loader: SourceFileLoader, name: str) -> CodeType | Any | None:
    try:
        return _usual(loader, name)
    except (EOFError, TypeError, ValueError):  # as marshal raises them
        path = loader.get_filename(name)
        with contextlib.suppress(OSError):  # not ours to remove
            os.unlink(cache_from_source(path))
        return loader.source_to_code(loader.get_data(path), path)
