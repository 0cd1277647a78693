"""Removes shared memory of Fast DDS whose process has ended.

Our own profile uses none. A profile of the user's, or another discovery range, may bring it back;
then a process that is killed, or ends at once, leaves its segments behind for ever.
"""

from __future__ import annotations

import contextlib
import fcntl
import os
import time
from collections.abc import Iterator
from pathlib import Path

FOLDER = Path("/dev/shm")
LOCKS = ("_el", "_sl")  # names of the files that a living process has locked: alone, or with others
MIN_AGE = 1.0  # [s] of a file; one that is younger may be about to be locked


def remove_abandoned(folder: Path = FOLDER) -> int:
    """Remove segments and ports that no living process has locked, like `fastdds shm clean`.

    What belongs to other users, or has gone meanwhile, is left alone.

    Returns:
        Number of files that were removed.
    """
    removed = 0
    names = {lock.name[: -len(end)] for end in LOCKS for lock in folder.glob(f"fastrtps_*{end}")}
    for name in names:
        with contextlib.suppress(OSError), contextlib.ExitStack() as held:
            locks = [path for end in LOCKS if (path := folder / f"{name}{end}").exists()]
            for path in locks:
                held.enter_context(_locked(path))
            for path in (folder / name, *locks, folder / f"sem.{name}_mutex"):
                path.unlink(missing_ok=True)
            removed += 1
    return removed


@contextlib.contextmanager
def _locked(path: Path) -> Iterator[None]:
    """Hold a lock file."""
    descriptor = os.open(path, os.O_RDONLY | os.O_NOFOLLOW)
    try:
        status = os.fstat(descriptor)
        if status.st_uid != os.geteuid() or time.time() - status.st_mtime < MIN_AGE:
            raise PermissionError(path)
        fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
        yield
    finally:
        os.close(descriptor)
