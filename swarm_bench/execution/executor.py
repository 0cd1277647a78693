"""Which executor the options mean, and which share of the runs is this process's."""

from __future__ import annotations

import contextlib
import hashlib
import os
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from typing import Any, TypeVar

from swarm_bench.execution.cluster import DaskExecutor, connect
from swarm_bench.execution.processes import LocalExecutor
from swarm_bench.execution.slurm_array import array_share
from swarm_bench.execution.task import Executor
from swarm_bench.runs.inputs import gather, packed
from swarm_common.files.cache import cache_folder
from swarm_common.model.errors import ConfigError, SwarmError

T = TypeVar("T")
R = TypeVar("R")
AUTO = "auto"  # the share of this task of a Slurm array


@contextmanager
def executor(jobs: int = 1, cluster: Any = None) -> Iterator[Executor]:
    """Provide what computes runs; its processes end with the context.

    Args:
        cluster: Where else: as `--cluster`, or a `distributed.Client`; None for this machine.

    Raises:
        ConfigError: If a cluster cannot be used.
    """
    chosen: Executor
    if cluster is None:
        chosen = LocalExecutor(jobs)
    elif isinstance(cluster, str):
        chosen = connect(cluster, jobs)
    else:
        chosen = DaskExecutor(cluster)
    try:
        yield chosen
    finally:
        chosen.close()


class RunFailedError(SwarmError):
    """Runs have no result."""


def values(
    chosen: Executor,
    runner: Callable[[T], R],
    items: Sequence[T],
    load: Callable[[T], object] | None = None,
) -> Iterator[R]:
    """Yield the result of each run as it comes.

    Args:
        load: Reads what a run reads, which goes to other processes; None: they read it themselves.

    Raises:
        RunFailedError: At the end, if runs failed.
    """
    pack = None
    if load is not None and items:
        pack = packed([gather(lambda: [load(item) for item in items])])
    errors = []
    with contextlib.closing(chosen.run(runner, items, pack)) as ended:
        for done in ended:
            if done.error:
                errors.append(done.error)
            else:
                yield done.value
    if errors:
        raise RunFailedError(f"{len(errors)} of {len(items)} runs failed; the first: {errors[0]}")


def share_of(
    items: Sequence[T], shard: str | None, environment: Mapping[str, str] = os.environ
) -> list[T]:
    """Return the runs of one shard; all shards together have each run once.

    Args:
        shard: Like 2/8, or `auto`; None for all.
        environment: For `auto`: with the variables of a Slurm array.

    Raises:
        ConfigError: If it is malformed, or this is no task of an array.
    """
    if shard is None:
        return list(items)
    if shard == AUTO:
        sweep = hashlib.sha256(f"{os.getcwd()} {items!r}".encode()).hexdigest()
        number, count = array_share(environment, cache_folder() / "arrays" / f"{sweep}.json")
    else:
        number, count = _numbers(shard)
    if not 1 <= number <= count:
        raise ConfigError(f"--shard is '{shard}'; expected 1/N to N/N")
    return list(items[number - 1 :: count])


def _numbers(shard: str) -> tuple[int, int]:
    first, _, last = shard.partition("/")
    if not (first.isdecimal() and last.isdecimal()):
        raise ConfigError(f"--shard is '{shard}'; expected a share like 2/8, or {AUTO}")
    return int(first), int(last)
