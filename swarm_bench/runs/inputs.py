"""Inputs of runs: read once per process, identified by a hash, sent to other processes.

`read_once` caches a reader of worlds, maps, missions or robots. While `gather` loads a run, it
notes all that these readers return. The hash is of their values: neither the place of a file nor
a comment in it counts. Another process that has installed the pack reads no file.
"""

from __future__ import annotations

import ast
import dataclasses
import functools
import hashlib
import importlib
import pickle
import sys
import tempfile
from collections.abc import Callable, Hashable, Iterable, Iterator, Mapping, Sequence, Set
from enum import Enum
from pathlib import Path
from typing import Any, ParamSpec, TypeVar

import msgspec
import numpy as np

from swarm_common.model.errors import ConfigError

P = ParamSpec("P")
T = TypeVar("T")
Key = tuple[str, tuple[Hashable, ...]]  # reader and arguments

MOST_KEPT = 256  # values; the oldest go first
DIGITS = 16  # of a hash

_values: dict[Key, Any] = {}
_parts: dict[Key, frozenset[Key]] = {}  # what was read for each of them, itself included
_open: list[set[Key]] = []  # what is read within each call under way, the innermost last
_installed = ""  # hash of the pack that this process has
_unpacked: list[tempfile.TemporaryDirectory[str]] = []  # folders of plug-ins


def read_once(read: Callable[P, T]) -> Callable[P, T]:
    """Return a reader that keeps its values, and lets `gather` know of them.

    Args:
        read: Reads files, or makes something of what was read; its arguments are hashable.
    """

    @functools.wraps(read)
    def reader(*args: P.args, **kwargs: P.kwargs) -> T:
        key: Key = (f"{read.__module__}.{read.__qualname__}", (*args, *sorted(kwargs.items())))
        if key not in _values:
            _open.append({key})
            try:
                value = read(*args, **kwargs)
            finally:
                parts = _open.pop()
            if len(_values) >= MOST_KEPT:
                oldest = next(iter(_values))
                del _values[oldest], _parts[oldest]
            _values[key], _parts[key] = value, frozenset(parts)
        if _open:
            _open[-1].update(_parts[key])
        result: T = _values[key]
        return result

    return reader


@dataclasses.dataclass(frozen=True, slots=True)
class Gathered:
    """Inputs of one run, or of several with equal inputs."""

    values: Mapping[Key, Any]  # of readers
    modules: Mapping[str, str]  # source of the user's modules by path from a folder of imports

    @property
    def digest(self) -> str:
        """Hash of all values and modules; the names of files are not in it."""
        values = sorted((key[0], _digest_of(value)) for key, value in self.values.items())
        return digest_of((values, sorted(self.modules.items())))


def gather(load: Callable[[], T], plugins: Callable[[T], Iterable[str]] = lambda _: ()) -> Gathered:
    """Return what is read while something is loaded.

    Args:
        load: Loads a run; what was read before is not read again.
        plugins: Returns names like module:Class from what was loaded; the source of modules
            outside of Python's own folders is gathered, with that of modules which they import.

    Raises:
        SwarmError: If `load` raises it; ConfigError for a plug-in that cannot be imported.
    """
    _open.append(set())
    try:
        loaded = load()
    finally:
        keys = _open.pop()
    modules: dict[str, str] = {}
    for plugin in plugins(loaded):
        modules |= _sources(plugin)
    return Gathered({key: _values[key] for key in keys if key in _values}, modules)


@dataclasses.dataclass(frozen=True, slots=True)
class Pack:
    """Inputs of runs on their way to another process."""

    digest: str
    data: bytes  # pickled


def packed(gathered: Iterable[Gathered]) -> Pack:
    """Return everything that runs are made from, as one pack."""
    values: dict[Key, Any] = {}
    modules: dict[str, str] = {}
    for one in gathered:
        values |= one.values
        modules |= one.modules
    data = pickle.dumps((values, {key: _parts[key] for key in values if key in _parts}, modules))
    return Pack(hashlib.sha256(data).hexdigest(), data)


def install(pack: Pack) -> None:
    """Have the readers of this process return what is in a pack, and nothing read before."""
    global _installed
    if pack.digest == _installed:
        return
    values, parts, modules = pickle.loads(pack.data)
    _values.clear()
    _parts.clear()
    _values.update(values)
    _parts.update({key: parts.get(key, frozenset((key,))) for key in values})
    _install_modules(modules)
    _installed = pack.digest


def _install_modules(modules: Mapping[str, str]) -> None:
    """Make modules importable; those of a pack before are forgotten."""
    while _unpacked:
        folder = _unpacked.pop()
        sys.path.remove(folder.name)
        folder.cleanup()
    if not modules:
        return
    folder = tempfile.TemporaryDirectory(prefix="swarm-bench-")
    for name, source in modules.items():
        path = Path(folder.name, name)
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(source, encoding="utf-8")
        dotted = ".".join(path.relative_to(folder.name).with_suffix("").parts)
        sys.modules.pop(dotted.removesuffix(".__init__"), None)
    sys.path.insert(0, folder.name)
    importlib.invalidate_caches()
    _unpacked.append(folder)


@functools.cache
def _sources(plugin: str) -> dict[str, str]:
    """Return the source of the user's modules that a plug-in consists of, by path."""
    module = plugin_module(plugin)
    if module.__file__ is None or not _is_users(Path(module.__file__)):
        return {}
    file = Path(module.__file__).resolve()
    depth = module.__name__.count(".") + (file.stem == "__init__")
    root, sources = file.parents[depth], dict[str, str]()
    waiting = [module.__name__]
    while waiting:
        path = getattr(sys.modules.get(waiting.pop()), "__file__", None)
        source = Path(path or "").resolve()
        name = str(source.relative_to(root)) if source.is_relative_to(root) else ""
        if not name or name in sources or not _is_users(source):
            continue
        sources[name] = source.read_text(encoding="utf-8")
        waiting += _imported(ast.parse(sources[name]), source.relative_to(root).parent.parts)
    return sources


def _imported(tree: ast.Module, package: tuple[str, ...]) -> Iterator[str]:
    """Yield the dotted names that may be modules which a module of a package imports."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            names = [alias.name for alias in node.names]
        elif isinstance(node, ast.ImportFrom):
            above = package[: len(package) + 1 - node.level] if node.level else ()
            base = (*above, *filter(None, (node.module,)))
            names = [".".join(base), *(".".join((*base, alias.name)) for alias in node.names)]
        else:
            continue
        for name in names:
            parts = name.split(".")
            yield from (".".join(parts[:count]) for count in range(1, len(parts) + 1))
    if package:
        yield ".".join(package)


def plugin_module(plugin: str) -> Any:
    """Return the module of a plug-in; modules are looked for in the current folder, too.

    Raises:
        ConfigError: If it cannot be imported.
    """
    name = plugin.partition(":")[0]
    if not _unpacked and "" not in sys.path and str(Path.cwd()) not in sys.path:
        sys.path.append(str(Path.cwd()))
    try:
        return importlib.import_module(name)
    except Exception as cause:  # whatever a module of the user's does when it is imported
        raise ConfigError(f"cannot import {name} of '{plugin}': {cause}") from cause


def _is_users(path: Path) -> bool:
    """Return whether a module is neither Python's, nor installed, nor ours."""
    path = path.resolve()
    ours = Path(__file__).resolve().parents[2]
    packages = {parent.name for parent in path.parents if parent.parent == ours}
    is_ours = any(name.startswith("swarm_") for name in packages)
    prefixes = {Path(prefix).resolve() for prefix in (sys.prefix, sys.base_prefix)}
    return (
        path.suffix == ".py"
        and not is_ours
        and "site-packages" not in path.parts
        and not any(path.is_relative_to(prefix / "lib") for prefix in prefixes)
    )


def digest_of(value: object) -> str:
    """Return a hash of plain data, arrays and dataclasses: equal for equal values.

    Args:
        value: Paths in it do not count: they say where something lies, not what it is.

    Raises:
        TypeError: For a value of another kind.
    """
    digest = hashlib.sha256()
    for part in _parts_of(value):
        digest.update(b"%d:" % len(part) + part)
    return digest.hexdigest()[:DIGITS]


_kept_digests: dict[int, tuple[object, str]] = {}  # by identity of values that are kept anyway


def _digest_of(value: object) -> str:
    """Return the hash of a value of a reader, computed once."""
    known = _kept_digests.get(id(value))
    if known is None or known[0] is not value:
        if len(_kept_digests) >= MOST_KEPT:
            _kept_digests.clear()
        known = _kept_digests[id(value)] = (value, digest_of(value))
    return known[1]


def _parts_of(value: object) -> Iterable[bytes]:
    match value:
        case Path():
            yield b"path"
        case Enum():
            yield str(value).encode()
        case None | bool() | int() | float() | str() | bytes():
            yield repr(value).encode()
        case np.generic():
            yield repr(value.item()).encode()
        case np.ndarray():
            yield f"{value.dtype.descr} {value.shape}".encode()
            yield np.ascontiguousarray(value).tobytes()
        case Mapping():
            yield b"mapping %d" % len(value)
            for key, item in value.items():
                yield from _parts_of(key)
                yield from _parts_of(item)
        case Set():
            yield b"set"
            yield from sorted(digest_of(item).encode() for item in value)
        case Sequence():
            yield b"sequence %d" % len(value)
            for item in value:
                yield from _parts_of(item)
        case _ if dataclasses.is_dataclass(value):
            yield type(value).__qualname__.encode()
            for field in dataclasses.fields(value):
                yield from _parts_of(getattr(value, field.name))
        case msgspec.Struct():
            yield type(value).__qualname__.encode()
            for name in value.__struct_fields__:
                yield from _parts_of(getattr(value, name))
        case _:
            raise TypeError(f"{type(value).__qualname__} has no hash of its content")
