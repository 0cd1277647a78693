"""Files that are there whole or not at all, and results kept in the user's cache between runs.

Importing yourdfpy takes one of the six seconds of a start; a description that was read before is
not read again.
"""

from __future__ import annotations

import contextlib
import hashlib
import os
import pickle
import tempfile
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import TypeVar

from swarm_common.process.home import NAME, cache_base


def write_whole(path: Path, content: str | bytes) -> None:
    """Replace a file; the old contents stay until all of the new ones are on disk.

    Raises:
        OSError: If it cannot be written; the old contents are then unchanged.
    """
    descriptor, name = tempfile.mkstemp(dir=path.parent, prefix=f".{path.name}-")
    try:
        with os.fdopen(descriptor, "wb") as file:
            file.write(content.encode() if isinstance(content, str) else content)
            file.flush()
            os.fchmod(file.fileno(), 0o644)
            os.fsync(file.fileno())
        Path(name).replace(path)
    except OSError:
        Path(name).unlink(missing_ok=True)
        raise


MOST_KEPT = 100  # results of a kind; the oldest go first

Result = TypeVar("Result")


def cache_folder() -> Path:
    """Return the folder for files that are made once and kept."""
    return cache_base() / NAME


def kept(kind: str, parts: Iterable[str | bytes], make: Callable[[], Result]) -> Result:
    """Return the result of `make` for these parts; only the first call with them runs it.

    A cache that can't be read or written counts as empty.
    """
    digest = hashlib.sha256()
    for part in parts:
        data = part.encode() if isinstance(part, str) else part
        digest.update(b"%d:" % len(data) + data)
    path = cache_folder() / kind / f"{digest.hexdigest()}.pickle"
    with contextlib.suppress(Exception):  # whatever a file that was cut off makes pickle raise
        result: Result = pickle.loads(path.read_bytes())
        return result
    result = make()
    with contextlib.suppress(OSError):
        path.parent.mkdir(parents=True, exist_ok=True)
        write_whole(path, pickle.dumps(result))
        results = sorted(path.parent.iterdir(), key=lambda file: file.stat().st_mtime)
        for old in results[:-MOST_KEPT]:
            old.unlink(missing_ok=True)
    return result
