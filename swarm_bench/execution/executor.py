"""Which executor the options mean, and which share of the runs is this process's."""

from __future__ import annotations

import hashlib
import os
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from typing import Any, TypeVar

from swarm_bench.execution.cluster import DaskExecutor, connect
from swarm_bench.execution.processes import LocalExecutor
from swarm_bench.execution.slurm_array import array_share
from swarm_bench.execution.task import Executor
from swarm_common.files.storage import cache_folder
from swarm_common.model.errors import ConfigError

T = TypeVar("T")
AUTO = "auto"  # the share of this task of a Slurm array


@contextmanager
def executor(jobs: int = 1, cluster: Any = None, *, apart: bool = False) -> Iterator[Executor]:
    """Provide what computes runs; its processes end with the context.

    Args:
        cluster: Where else: as `--cluster`, or a `distributed.Client`; None for this machine.
        apart: Whether a run that ends its process must not end this one; see `LocalExecutor`.

    Raises:
        ConfigError: If a cluster cannot be used.
    """
    chosen: Executor
    if cluster is None:
        chosen = LocalExecutor(jobs, apart=apart)
    elif isinstance(cluster, str):
        chosen = connect(cluster, jobs)
    else:
        chosen = DaskExecutor(cluster)
    try:
        yield chosen
    finally:
        chosen.close()


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
