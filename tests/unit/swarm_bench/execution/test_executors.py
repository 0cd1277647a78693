"""Runs in other processes: the same results, whoever dies on the way."""

import dataclasses
import os
import subprocess
import sys
import time

import pytest
from rich.console import Console

from swarm_bench.execution import processes
from swarm_bench.execution.cluster import DaskExecutor
from swarm_bench.execution.executor import executor, share_of
from swarm_bench.execution.processes import LocalExecutor
from swarm_bench.execution.slurm_array import array_share
from swarm_bench.execution.task import DIED
from swarm_bench.runs.episode import RunOptions
from swarm_bench.runs.scenario import Scenario
from swarm_bench.suite.sweep import RunSweep
from swarm_common.model.errors import ConfigError
from swarm_run.record.run_record import RunRecord
from tests.fakes.tasks import die, die_once, fail, own_pid

QUIET = Console(quiet=True)
POLITE = '''
"""A method of the user's, in two files."""
from helper import SPEED
from swarm_bench.baselines.base import Baseline
from swarm_common.model.records import Twist

class Slow(Baseline):
    def prepare(self): pass
    def begin(self, target): pass
    def drive(self, target): return Twist(SPEED, 0.0, 0.1)
    def rest(self): return Twist()
'''


def test_a_run_whose_process_dies_is_repeated_and_stops_nobody(tmp_path):
    local = LocalExecutor(2)
    paths = [str(tmp_path / "a"), str(tmp_path / "b"), str(tmp_path)]
    done = sorted(local.run(die_once, paths, None), key=lambda item: item.index)
    assert [(item.value, item.error) for item in done] == [(path, "") for path in paths]
    assert {item.error for item in local.run(die, [0], None)} == {DIED}
    assert {item.error for item in LocalExecutor(apart=True).run(die, [0], None)} == {DIED}
    (failed,) = local.run(fail, [0], None)
    assert failed.error.startswith("ZeroDivisionError: no (tasks.py, line ")
    local.close()


def test_a_process_makes_room_for_a_new_one(monkeypatch):
    monkeypatch.setattr(processes, "MOST_RUNS", 2)
    local = LocalExecutor(apart=True)
    found = [done.value for done in local.run(own_pid, range(5), None)]
    local.close()
    assert found[0] == found[1] != found[2] == found[3] != found[4]


def options_of(folder, seeds):
    """Return runs of a world, a mission and a method of the user's."""
    (folder / "short.yaml").write_text("route:\n  - pose: [1.0, 0.0, 0.0]\n", encoding="utf-8")
    (folder / "slowly.py").write_text(POLITE, encoding="utf-8")
    (folder / "helper.py").write_text("SPEED = 0.1\n", encoding="utf-8")
    scenario = Scenario(
        name="own", world="hall_12", mission=str(folder / "short.yaml"), time_limit={2: 5.0}
    )
    return [
        RunOptions(scenario=scenario, robots=2, seed=seed, method="slowly:Slow") for seed in seeds
    ]


def trajectories(results):
    found = list(results)
    assert [item.error for item in found if not isinstance(item, RunRecord)] == []
    assert all(item.origin.processor and item.origin.inputs for item in found)
    return {item.seed: item.trajectory_sha256 for item in found}


def test_inputs_travel_and_shards_are_the_whole(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    options = options_of(tmp_path, range(5))
    alone = trajectories(RunSweep(options).run(QUIET))
    assert len(set(alone.values())) == 5
    with executor(2) as local:
        shards = [share_of(options, f"{number}/3") for number in (1, 2, 3)]
        sweeps = [RunSweep(shard, None, local) for shard in shards]
        for sweep in sweeps:
            sweep.check()
        for path in tmp_path.glob("*.*"):
            path.unlink()  # the workers read no file
        monkeypatch.chdir("/")
        union: dict[int, str] = {}
        for sweep in sweeps:
            union |= trajectories(sweep.run(QUIET))
    assert union == alone
    environment = {f"SLURM_ARRAY_TASK_{name}": str(value)
                   for name, value in {"ID": 7, "MIN": 5, "MAX": 7}.items()}  # fmt: skip
    assert share_of(options, "auto", environment) == shards[2]


def test_a_task_that_is_submitted_again_does_its_own_share(tmp_path, capsys):
    """Alone it took itself for the whole."""

    def share(number, first, last, count, step=1):
        values = {"ID": number, "MIN": first, "MAX": last, "COUNT": count, "STEP": step}
        environment = {f"SLURM_ARRAY_TASK_{name}": str(value) for name, value in values.items()}
        return array_share(environment, tmp_path / "array.json")

    with pytest.raises(ConfigError, match="task 3 alone does not say of how many"):
        share(3, 3, 3, 1)
    assert [share(number, 1, 4, 4) for number in (1, 2, 3, 4)] == [(n, 4) for n in (1, 2, 3, 4)]
    assert capsys.readouterr().err == ""
    assert share(3, 3, 3, 1) == (3, 4)
    assert share(4, 3, 4, 2) == (4, 4)
    assert "task 4 of the array 1-4 of before" in capsys.readouterr().err
    assert share(4, 1, 4, 3) == (4, 4)
    assert "the array has 3 of the tasks 1 to 4: the runs of the others" in capsys.readouterr().err
    assert share(1, 1, 2, 2) == (1, 2)  # another division of the whole
    assert share(5, 1, 7, 4, 2) == (3, 4)


@pytest.fixture
def scheduler(tmp_path):
    """Provide the address of a scheduler, and its three workers, which start in another folder."""
    pytest.importorskip("distributed")
    file = tmp_path / "scheduler.json"
    common = (sys.executable, "-P", "-m", "distributed.cli.")
    environment = dict(os.environ, DASK_DISTRIBUTED__SCHEDULER__WORK_STEALING="True")
    command = (*common[:-1], common[-1] + "dask_scheduler", "--host", "127.0.0.1", "--port", "0",
               "--no-dashboard", "--scheduler-file", str(file))  # fmt: skip
    processes = [subprocess.Popen(command, cwd="/", env=environment, stderr=subprocess.DEVNULL)]
    worker = (*common[:-1], common[-1] + "dask_worker", "--scheduler-file", str(file),
              "--nthreads", "1", "--no-nanny", "--no-dashboard", "--host", "127.0.0.1",
              "--local-directory", str(tmp_path / "dask"))  # fmt: skip
    processes += [
        subprocess.Popen(worker, cwd="/", env=environment, stderr=subprocess.DEVNULL)
        for _ in range(3)
    ]
    end = time.monotonic() + 20.0
    while not file.exists() or not file.read_text(encoding="utf-8"):
        assert time.monotonic() < end
        time.sleep(0.05)
    import json

    yield json.loads(file.read_text(encoding="utf-8"))["address"], processes[1:]
    for process in processes:
        process.kill()
        process.wait()


@pytest.mark.slow
@pytest.mark.filterwarnings("default")  # what Dask does that is deprecated is Dask's
def test_a_cluster_gives_the_same_although_a_worker_is_killed(scheduler, tmp_path, monkeypatch):
    from distributed import Client

    address, workers = scheduler
    monkeypatch.chdir(tmp_path)
    options = options_of(tmp_path, range(8))
    options = [
        dataclasses.replace(item, scenario=dataclasses.replace(item.scenario, time_limit={2: 60.0}))
        for item in options
    ]
    alone = trajectories(RunSweep(options).run(QUIET))
    with Client(address) as client:
        client.wait_for_workers(3, timeout=20)
        found = RunSweep(options, None, DaskExecutor(client)).run(
            QUIET, watch=lambda *_: workers[0].kill() is None
        )
        assert trajectories(found) == alone
        failing = list(DaskExecutor(client).run(fail, [0], None))
        assert "ZeroDivisionError" in failing[0].error
        monkeypatch.setattr("swarm_bench.execution.cluster.bench_edition", lambda: "other")
        with pytest.raises(ConfigError, match=r"worker tcp.* has swarm-workbench .* process other"):
            DaskExecutor(client)
