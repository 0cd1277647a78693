"""Results on disk: JSON lines, one per run, which a bench that is killed leaves readable.

A store is one file. If its name ends in .gz, new lines go to a file beside it (`full.jsonl` beside
`full.jsonl.gz`; `full.1-2.jsonl` by a shard), until they are packed.
"""

from __future__ import annotations

import contextlib
import fcntl
import gzip
import json
import zlib
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Generic, Protocol, TextIO, TypeVar

from swarm_common.model.errors import ConfigError

PACKED = ".jsonl.gz"


class Kept(Protocol):
    """A result that can be kept."""

    def as_json(self) -> Mapping[str, Any]:
        """Return a dictionary for json.dump, without NaN and infinity."""


Result = TypeVar("Result", bound=Kept)


@dataclass(frozen=True, slots=True)
class Store(Generic[Result]):
    """Results of one command."""

    path: Path | None  # None keeps nothing
    parse: Callable[[Any], Result]  # makes a result of a line's data without its schema
    command: str  # that writes such lines, for errors
    shard: str = ""  # like 1/2, whose new lines have a file of their own

    def read(self) -> list[tuple[str, Result]]:
        """Return all results, each with its place: file and number of the line.

        A line that a killed bench left unfinished does not count.

        Raises:
            ConfigError: If a file cannot be read, or a complete line is not a result.
        """
        files = [] if self.path is None else [self.path, *self._newer()]
        return [item for path in files if path.is_file() for item in self._read_file(path)]

    def by_key(self, key: Callable[[Result], Any]) -> dict[Any, Result]:
        """Return the last result of each key; see `read`."""
        return {key(result): result for _, result in self.read()}

    def _read_file(self, path: Path) -> Iterator[tuple[str, Result]]:
        try:
            data = path.read_bytes()
            text = (gzip.decompress(data) if path.name.endswith(PACKED) else data).decode()
        except (OSError, EOFError, zlib.error, UnicodeDecodeError) as cause:
            raise ConfigError(f"cannot read {path}: {cause}") from cause
        lines = text.split("\n")[:-1]  # what follows the last newline is unfinished
        for number, line in enumerate(lines, 1):
            if not line.strip():
                continue
            try:
                data = json.loads(line, parse_constant=_refuse)
                data.pop("schema", None)
                result = self.parse(data)
            except (ValueError, TypeError, KeyError, AttributeError, RecursionError) as cause:
                told = f"{path}, line {number} is no result of {self.command}: {cause}"
                raise ConfigError(told) from cause
            yield f"{path}, line {number}", result

    @contextlib.contextmanager
    def adding(self) -> Iterator[Callable[[Result], None]]:
        """Provide a function that adds a result, so that it is there whatever comes next.

        An unfinished last line is cut off.

        Raises:
            ConfigError: If the file cannot be written, or another bench is writing to it.
        """
        if self.path is None:
            yield lambda result: None
            return
        path = self.path
        if path.name.endswith(PACKED):
            shard = f".{self.shard.replace('/', '-')}" if self.shard else ""
            path = path.with_name(f"{path.name.removesuffix(PACKED)}{shard}.jsonl")
        with _opened(path) as file:

            def add(result: Result) -> None:
                file.write(json.dumps(result.as_json(), allow_nan=False) + "\n")
                file.flush()

            yield add

    def pack(self, key: Callable[[Result], Any]) -> None:
        """Compress the lines of all files into one, the last of each key, by key.

        Equal lines give equal bytes. A file to which another bench is writing stays as well.

        Raises:
            ConfigError: If a file cannot be read or written.
        """
        assert self.path is not None
        with contextlib.ExitStack() as stack:
            done = []
            for path in self._newer():
                with contextlib.suppress(ConfigError):
                    stack.enter_context(_opened(path))
                    done.append(path)
            results = sorted(self.by_key(key).items(), key=lambda item: item[0])
            text = "".join(f"{json.dumps(result.as_json())}\n" for _, result in results)
            try:
                beside = self.path.with_suffix(".new")
                beside.write_bytes(gzip.compress(text.encode(), mtime=0))
                beside.replace(self.path)
                for path in done:
                    path.unlink()
            except OSError as cause:
                raise ConfigError(f"cannot write {self.path}: {cause}") from cause

    def _newer(self) -> Sequence[Path]:
        if self.path is None or not self.path.name.endswith(PACKED):
            return ()
        return sorted(self.path.parent.glob(f"{self.path.name.removesuffix(PACKED)}*.jsonl"))


@contextlib.contextmanager
def _opened(path: Path) -> Iterator[TextIO]:
    """Open a file to append to, for this process alone."""
    with contextlib.ExitStack() as stack:
        try:
            file = stack.enter_context(path.open("a+", encoding="utf-8"))
            try:
                fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
            except BlockingIOError:
                told = f"another bench is writing to {path}; wait for its end"
                raise ConfigError(told) from None
            except OSError:  # a file system without locks, as some clusters have
                pass
            data = path.read_bytes()
            if not data.endswith(b"\n"):
                file.truncate(data.rfind(b"\n") + 1)
        except OSError as cause:
            raise ConfigError(f"cannot write {path}: {cause}") from cause
        yield file


def _refuse(word: str) -> float:
    raise ValueError(f"{word} is no number")
