"""Share of the runs that a task of a Slurm array does, also if it is submitted again alone.

Slurm tells a task the first and the last number of its own array only. So the array of a sweep is
kept in the user's cache, and a part of it that comes later is known as one.
"""

from __future__ import annotations

import contextlib
import json
import sys
from collections.abc import Mapping
from pathlib import Path

from swarm_common.files.storage import write_whole
from swarm_common.model.errors import ConfigError


def array_share(environment: Mapping[str, str], memory: Path) -> tuple[int, int]:
    """Return which share a task does, counted from 1, and of how many.

    Args:
        environment: With the variables of the task.
        memory: File that keeps the array of this sweep.

    Raises:
        ConfigError: If this is no task of an array, or one alone of an array that is not known.
    """
    try:
        number, first, last = (
            int(environment[f"SLURM_ARRAY_TASK_{name}"]) for name in ("ID", "MIN", "MAX")
        )
        step = int(environment.get("SLURM_ARRAY_TASK_STEP", "1"))
        own = range(first, last + 1, step)
        tasks = int(environment.get("SLURM_ARRAY_TASK_COUNT", len(own)))
        share = own.index(number) + 1
    except (KeyError, ValueError):
        raise ConfigError(
            "--shard auto: this is no task of a Slurm array (SLURM_ARRAY_TASK_ID)"
        ) from None
    known = _known(memory)
    if first in known and last in known and (tasks == 1 or first > known[0]) and number in known:
        whole = f"{known[0]}-{known[-1]}" + f":{known.step}" * (known.step > 1)
        sys.stderr.write(f"--shard auto: task {number} of the array {whole} of before\n")
        return known.index(number) + 1, len(known)
    if tasks == 1:
        raise ConfigError(
            f"--shard auto: task {number} alone does not say of how many;"
            f" give --shard {max(number, 1)}/N"
        )
    if tasks < len(own):
        sys.stderr.write(
            f"--shard auto: the array has {tasks} of the tasks {first} to {last}:"
            " the runs of the others are not done\n"
        )
    else:
        with contextlib.suppress(OSError):
            memory.parent.mkdir(parents=True, exist_ok=True)
            write_whole(memory, json.dumps([first, last + 1, step]))
    return share, len(own)


def _known(memory: Path) -> range:
    """Return the numbers of the array that is kept; none if there is none."""
    try:
        return range(*map(int, json.loads(memory.read_text(encoding="utf-8"))))
    except (OSError, ValueError, TypeError):
        return range(0)
