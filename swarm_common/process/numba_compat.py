"""The private part of numba that we use: in our own processes its cache is never in the way.

The index of a module's compiled kernels holds the types of their arguments, pickled by name. numba
unpickles it before it looks whether the module has changed since. So a NamedTuple that was renamed
ended every process after an update, for ever; so did a file that was cut short. A cache that cannot
be read counts as none: the kernel is compiled again, and the file is written anew. One that cannot
be written is not: a full disk, files of another user.

Kernels take `njit` from here.
"""

from __future__ import annotations

import contextlib
import pickle
from typing import Any

import numba
from numba.core.caching import Cache, IndexDataCacheFile

from swarm_common.process import start
from swarm_common.process.private_parts import require

# https://docs.python.org/3/library/pickle.html#pickle.UnpicklingError names these, "but not only".
UNREADABLE = (
    AttributeError, EOFError, ImportError, KeyError, IndexError, TypeError, ValueError,
    pickle.UnpicklingError,
)  # fmt: skip
PARTS: tuple[tuple[Any, str], ...] = (
    (IndexDataCacheFile, "_load_index"),
    (IndexDataCacheFile, "_load_data"),
    (Cache, "_guard_against_spurious_io_errors"),  # around whatever reads or writes files
)

require("numba", __name__, PARTS)
_load_index, _load_data = IndexDataCacheFile._load_index, IndexDataCacheFile._load_data


def _readable_index(cache: IndexDataCacheFile) -> dict[Any, str]:
    """Return what is cached, nothing if the index cannot be read."""
    try:
        index: dict[Any, str] = _load_index(cache)
    except UNREADABLE:
        return {}
    return index


def _readable_data(cache: IndexDataCacheFile, name: str) -> Any:
    """Return a cached kernel.

    Raises:
        OSError: If it cannot be read; numba compiles it then.
    """
    try:
        return _load_data(cache, name)
    except UNREADABLE as error:
        raise OSError(f"{name}: {error}") from error


if start.is_own_process:
    IndexDataCacheFile._load_index = _readable_index
    IndexDataCacheFile._load_data = _readable_data
    Cache._guard_against_spurious_io_errors = lambda _: contextlib.suppress(OSError)
njit = numba.njit
