"""The private part of numba that we use: a cache on disk that is right and never in the way.

numba keeps compiled kernels beside their sources and compares the time of their file only. Another
environment compiles all of them again, and a kernel that is compiled into its callers stays in them
as it was when its own module changes. Here they are kept in the user's cache by the content of
their module and of all modules of ours that it imports.

The index of a module's compiled kernels holds the types of their arguments, pickled by name. numba
unpickles it before it checks whether the module has changed since. A NamedTuple that was renamed,
or a file that was cut short, would end every later process. Here a cache that cannot be read counts
as empty: the kernel is compiled again, and the file is written anew. One that cannot be written (a
full disk, files of another user) stays as it is.

Kernels take `njit` from here; kernels of other libraries keep numba's own cache.
"""

from __future__ import annotations

import contextlib
import functools
import hashlib
import pickle
import re
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numba
from numba.core.caching import (
    Cache,
    CompileResultCacheImpl,
    FunctionCache,
    IndexDataCacheFile,
    _CacheLocator,
)
from numba.core.dispatcher import Dispatcher

from swarm_common.process.home import NAME, cache_base
from swarm_common.process.private_parts import require

# https://docs.python.org/3/library/pickle.html#pickle.UnpicklingError names these, "but not only".
UNREADABLE = (
    AttributeError,
    EOFError,
    ImportError,
    KeyError,
    IndexError,
    TypeError,
    ValueError,
    pickle.UnpicklingError,
)
IMPORT = re.compile(r"^(?:from|import) (swarm_[\w.]+)(?: import (\([^)]*\)|.*))?", re.MULTILINE)
DIGEST = re.compile("[0-9a-f]{16}")  # name of the place of a module's kernels
MOST_KEPT = 200  # places; one edition has 34
ROOT = Path(__file__).resolve().parents[2]
PARTS: tuple[tuple[Any, str], ...] = (
    (IndexDataCacheFile, "_load_index"),
    (IndexDataCacheFile, "_load_data"),
    (Cache, "_guard_against_spurious_io_errors"),  # around whatever reads or writes files
    (Cache.__init__, "_cache_file"),
    (Cache.__init__, "_cache_path"),
    (Cache.__init__, "_impl"),
    (Cache, "_impl_class"),
    (CompileResultCacheImpl, "_locator_classes"),
    (_CacheLocator, "from_function"),
    (_CacheLocator, "ensure_cache_path"),
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


class _ContentLocator(_CacheLocator):  # type: ignore[misc]  # numba has no types
    """Place of a module's kernels, by content."""

    def __init__(self, function: Callable[..., Any], file: str) -> None:
        self._digest = _digest_of(Path(file).resolve())
        self._first_line = function.__code__.co_firstlineno

    def get_cache_path(self) -> str:
        return str(kernel_folder() / self._digest)

    def ensure_cache_path(self) -> None:
        """Make the place, in which a kernel is about to be kept; the oldest places go."""
        super().ensure_cache_path()
        places = (path for path in kernel_folder().iterdir() if DIGEST.fullmatch(path.name))
        for old in sorted(places, key=lambda path: path.stat().st_mtime)[:-MOST_KEPT]:
            shutil.rmtree(old, ignore_errors=True)

    def get_source_stamp(self) -> str:
        return self._digest

    def get_disambiguator(self) -> str:
        return str(self._first_line)

    @classmethod
    def from_function(cls, function: Callable[..., Any], file: str) -> _ContentLocator:
        """Return the place of a kernel; the file that holds it has been found by numba."""
        return cls(function, file)


class _ContentImpl(CompileResultCacheImpl):  # type: ignore[misc]  # numba has no types
    _locator_classes = (_ContentLocator,)


class _TolerantCache(FunctionCache):  # type: ignore[misc]  # numba has no types
    """The cache of one kernel; files that cannot be read or written are passed over."""

    _impl_class = _ContentImpl

    def __init__(self, function: Callable[..., Any]) -> None:
        super().__init__(function)
        stamp = self._impl.locator.get_source_stamp()
        self._cache_file = _TolerantFile(self._cache_path, self._impl.filename_base, stamp)

    def _guard_against_spurious_io_errors(self) -> contextlib.suppress:
        return contextlib.suppress(OSError)


def kernel_folder() -> Path:
    """Return the folder of all compiled kernels: NUMBA_CACHE_DIR, else one in the user's cache."""
    chosen = numba.config.CACHE_DIR
    return Path(chosen) if chosen else cache_base() / NAME / "kernels"


@functools.cache
def _digest_of(module: Path) -> str:
    """Return what names the content of a module and of all modules of ours that it imports."""
    modules, found = [module], {module}
    for each in modules:
        new = _imported_by(each) - found
        modules += sorted(new)
        found |= new
    digest = hashlib.sha256()
    for each in sorted(modules):
        digest.update(f"{each.relative_to(ROOT) if each.is_relative_to(ROOT) else each}\n".encode())
        digest.update(each.read_bytes())
    return digest.hexdigest()[:16]


@functools.cache
def _imported_by(module: Path) -> set[Path]:
    found = set()
    for name, members in IMPORT.findall(module.read_text(encoding="utf-8")):
        place = ROOT / name.replace(".", "/")
        places = [place, *(place / member for member in re.findall(r"\w+", members))]
        found |= {file for each in places if (file := each.with_suffix(".py")).is_file()}
    return found


def njit(*, cache: bool) -> Callable[[Callable[..., Any]], Any]:
    """Return a decorator that compiles as `numba.njit` does; `cache` keeps the result on disk."""

    def compiled(function: Callable[..., Any]) -> Any:
        kernel = numba.njit(function)
        if cache:
            kernel._cache = _TolerantCache(function)
        return kernel

    return compiled
