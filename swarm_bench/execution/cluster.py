"""The workers of a Dask cluster, which need the wheel and nothing else."""

from __future__ import annotations

import contextlib
import platform
import shutil
from collections.abc import Callable, Sequence
from importlib import metadata
from typing import Any

from swarm_bench.execution.task import DIED, MOST_TRIES, Done, Runner, Runs, execute
from swarm_bench.runs.inputs import Pack
from swarm_bench.runs.origin import bench_edition
from swarm_common.model.errors import ConfigError

ANSWER = 5.0  # [s] in which a scheduler has to answer
FIRST_WORKER = 60.0  # [s] in which it has to have a worker; a queue of Slurm may take longer
NUMERICAL = ("numpy", "numba", "scipy")  # versions that may change a trajectory
EXTRA = "pip install 'swarm-workbench[cluster]'"


class DaskExecutor:
    """Computes runs on the workers of a `distributed.Client`."""

    def __init__(self, client: Any, *, owned: Sequence[Any] = (), patience: float = FIRST_WORKER):
        """Check that scheduler and workers have the same software as this process.

        Args:
            client: A `distributed.Client`.
            owned: Clients and clusters that `close` closes, in order.
            patience: Wall time [s] until the first worker has to be there.

        Raises:
            ConfigError: If there is no worker, or one has other software.
        """
        self._client = client
        self._owned = owned
        try:
            _check_workers(client, patience)
        except BaseException:
            self.close()
            raise

    def run(self, runner: Runner, items: Sequence[Any], pack: Pack | None) -> Runs:
        """Yield each run when it ends; see `Executor`. Dask repeats those of workers that die."""
        from distributed import as_completed

        waiting = list(range(len(items)))
        for _ in range(MOST_TRIES):
            sent = self._client.scatter(pack, broadcast=True) if pack is not None else None
            futures = {
                self._client.submit(
                    execute, runner, index, items[index], sent, pure=False, retries=0
                ): index
                for index in waiting
            }
            waiting = []
            try:
                for future in as_completed(list(futures)):
                    if future.cancelled():  # the last worker with the inputs has died
                        waiting.append(futures[future])
                        continue
                    error = future.exception()
                    yield future.result() if error is None else _failed(futures[future], error)
            finally:
                self._client.cancel([each for each in futures if not each.done()])
            if not waiting:
                return
        for index in waiting:
            yield Done(index, error=DIED)

    def close(self) -> None:
        """Leave the cluster, and end it if it was started here."""
        for each in self._owned:
            with contextlib.suppress(Exception):  # it may be gone already
                each.close()


def _failed(index: int, error: BaseException) -> Done:
    is_dead = type(error).__name__ == "KilledWorker"
    return Done(index, error=DIED if is_dead else f"{type(error).__name__}: {error}")


def connect(where: str, jobs: int) -> DaskExecutor:
    """Return the executor of a cluster.

    Args:
        where: `local`, `tcp://HOST:PORT` of a scheduler, or `slurm:` with settings.
        jobs: Workers of a local cluster; 1: as many as there are cores.

    Raises:
        ConfigError: If Dask is not installed, or nobody answers, or with other software.
    """
    scheme, _, rest = where.partition(":")
    makers: dict[str, Callable[[], DaskExecutor]] = {
        "local": lambda: _local(jobs),
        "slurm": lambda: _slurm(rest),
        "tcp": lambda: _remote(where),
        "tls": lambda: _remote(where),
    }
    if scheme not in makers or (scheme == "local" and rest):
        raise ConfigError(
            f"--cluster is '{where}'; expected local, tcp://HOST:8786 or slurm:SETTINGS"
        )
    try:
        import distributed  # noqa: F401
    except ImportError:
        raise ConfigError(f"--cluster needs Dask: {EXTRA}") from None
    return makers[scheme]()


def _local(jobs: int) -> DaskExecutor:
    from distributed import Client, LocalCluster

    cluster = LocalCluster(
        n_workers=jobs if jobs > 1 else None,
        threads_per_worker=1,
        host="127.0.0.1",
        dashboard_address="127.0.0.1:0",
        silence_logs=50,
    )
    client = Client(cluster)
    return DaskExecutor(client, owned=(client, cluster))


def _remote(address: str) -> DaskExecutor:
    from distributed import Client

    try:
        client = Client(address, timeout=ANSWER)
    except (OSError, TimeoutError, ValueError) as error:
        raise ConfigError(
            f"no scheduler answers at {address} within {ANSWER:g} s; start one with "
            f"'dask scheduler' ({type(error).__name__})"
        ) from None
    return DaskExecutor(client, owned=(client,))


def _slurm(settings: str) -> DaskExecutor:
    """Return a cluster of Slurm jobs, from settings like nodes=4,queue=short,memory=4GB."""
    try:
        from dask_jobqueue import SLURMCluster
    except ImportError:
        raise ConfigError(f"--cluster slurm needs dask-jobqueue: {EXTRA}") from None
    if shutil.which("sbatch") is None:
        raise ConfigError("--cluster slurm: no sbatch here; run this on a login node of Slurm")
    from distributed import Client

    options: dict[str, Any] = {"cores": 1, "memory": "4GB", "processes": 1}
    for setting in filter(None, settings.split(",")):
        name, equals, value = setting.partition("=")
        if not equals:
            raise ConfigError(f"--cluster has '{setting}'; expected NAME=VALUE, like nodes=4")
        options[name] = int(value) if value.isdecimal() else value
    nodes = options.pop("nodes", 1)
    options["processes"] = options["cores"]  # one run per core
    try:
        cluster = SLURMCluster(**options)
    except (TypeError, ValueError) as error:
        raise ConfigError(f"--cluster slurm:{settings}: {error}") from None
    cluster.scale(jobs=nodes)
    client = Client(cluster)
    return DaskExecutor(client, owned=(client, cluster), patience=24 * 3600.0)


def software() -> dict[str, str]:
    """Return what must be equal for equal trajectories."""
    versions = {name: metadata.version(name) for name in NUMERICAL}
    python = ".".join(platform.python_version_tuple()[:2])
    return {"swarm-workbench": bench_edition(), "Python": python, **versions}


def _check_workers(client: Any, patience: float) -> None:
    try:
        client.wait_for_workers(1, timeout=patience)
    except TimeoutError:
        raise ConfigError(
            f"{client.scheduler.address} has no worker after {patience:g} s; start one with "
            f"'dask worker {client.scheduler.address} --nthreads 1'"
        ) from None
    ours = software()
    for address, theirs in client.run(software, on_error="return").items():
        if not isinstance(theirs, dict):
            raise ConfigError(
                f"worker {address} cannot run swarm-workbench ({theirs}); install it there"
            )
        for name, version in ours.items():
            if theirs.get(name) != version:
                raise ConfigError(
                    f"worker {address} has {name} {theirs.get(name)}, this process {version}; "
                    "install the same there"
                )
