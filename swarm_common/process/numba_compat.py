"""The private part of numba that we use: a cache on disk that is never in the way.

The index of a module's compiled kernels holds the types of their arguments, pickled by name. numba
unpickles it before it checks whether the module has changed since. A NamedTuple that was renamed,
or a file that was cut short, would end every later process. Here a cache that cannot be read counts
as empty: the kernel is compiled again, and the file is written anew. One that cannot be written (a
full disk, files of another user) stays as it is.

Kernels take `njit` from here; kernels of other libraries keep numba's own cache.
"""

from __future__ import annotations

import contextlib
import pickle
from collections.abc import Callable
from typing import Any

import numba
from numba.core.caching import Cache, FunctionCache, IndexDataCacheFile
from numba.core.dispatcher import Dispatcher

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
    (Cache.__init__, "_cache_file"),
    (Cache.__init__, "_cache_path"),
    (Cache.__init__, "_impl"),
    (Dispatcher.enable_caching, "_cache"),
)
require("numba", __name__, PARTS)


class _TolerantFile(IndexDataCacheFile):  # type: ignore[misc]  # numba has no types
    """Files of one kernel; damaged ones count as missing."""

    def _load_index(self) -> dict[Any, str]:
        try:
            index: dict[Any, str] = super()._load_index()
        except UNREADABLE:
            return {}
        return index

    def _load_data(self, name: str) -> Any:
        try:
            return super()._load_data(name)
        except UNREADABLE as error:
            raise OSError(f"{name}: {error}") from error  # numba compiles it then


class _TolerantCache(FunctionCache):  # type: ignore[misc]  # numba has no types
    """The cache of one kernel; files that cannot be read or written are passed over."""

    def __init__(self, function: Callable[..., Any]) -> None:
        super().__init__(function)
        stamp = self._impl.locator.get_source_stamp()
        self._cache_file = _TolerantFile(self._cache_path, self._impl.filename_base, stamp)

    def _guard_against_spurious_io_errors(self) -> contextlib.suppress:
        return contextlib.suppress(OSError)


def njit(*, cache: bool) -> Callable[[Callable[..., Any]], Any]:
    """Return a decorator that compiles as `numba.njit` does; `cache` keeps the result on disk."""

    def compiled(function: Callable[..., Any]) -> Any:
        kernel = numba.njit(function)
        if cache:
            kernel._cache = _TolerantCache(function)
        return kernel

    return compiled
