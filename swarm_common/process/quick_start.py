"""Quick start of a process: its user waits for all that it does before its work begins."""

from __future__ import annotations

import contextlib
import gc
import importlib
import sys
from collections.abc import Iterator
from types import ModuleType

BLAS = "scipy.linalg.cython_blas"


@contextlib.contextmanager
def without_collector() -> Iterator[None]:
    """Disable garbage collection within it; objects alive at its end are never collected.

    Imports and compiled kernels make a million objects and hardly any garbage.
    """
    gc.disable()
    try:
        yield
    finally:
        gc.freeze()
        gc.enable()


def load_numba() -> None:
    """Load what numba needs for its first kernel, without scipy.linalg.

    numba imports that, slowly, only to learn whether kernels may multiply matrices. Ours do not.
    """
    if BLAS in sys.modules:
        return
    hidden: dict[str, ModuleType | None] = {BLAS: None}  # importing it raises ImportError
    sys.modules.update(hidden)  # type: ignore[arg-type]
    try:
        importlib.import_module("numba.np.arraymath")
    finally:
        del sys.modules[BLAS]
