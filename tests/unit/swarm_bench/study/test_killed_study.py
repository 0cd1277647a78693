"""A study that somebody ends, in whatever way, goes on where it was."""

import signal
import subprocess
import sys
import time

import psutil
import pytest

from swarm_bench.study.experiments import FIRST_SEED
from swarm_bench.study.trials.line import store_of

EXPERIMENT = """
question: Does it go on?
methods: [ours]
cells:
  - {scenario: doorway, robots: 2, seconds: 60}
"""
LIMIT = 120.0  # [s] of wall time, on a busy machine


@pytest.mark.long  # that a killed sweep goes on is a test that always runs
@pytest.mark.timeout(600)
def test_a_killed_study_goes_on_where_it_was(tmp_path):
    (tmp_path / "speed.yaml").write_text(EXPERIMENT, encoding="utf-8")
    folder = tmp_path / "study"
    words = ["study", "--experiments", str(tmp_path), "--folder", str(folder), "--jobs", "2",
             "-o", str(tmp_path / "study.md")]  # fmt: skip
    command = [sys.executable, "-c", "from swarm_bench.cli import main; main()", *words]
    store, known = store_of(folder, "full"), 0
    for kind in (signal.SIGKILL, signal.SIGTERM):
        with subprocess.Popen(command) as bench:
            end = time.monotonic() + LIMIT
            while len(store.read()) == known:
                assert time.monotonic() < end
                time.sleep(0.05)
            workers = psutil.Process(bench.pid).children(recursive=True)
            bench.send_signal(kind)
        assert not psutil.wait_procs(workers, timeout=LIMIT)[1]
        known = len(store.read())
    with (folder / "full.jsonl").open("a", encoding="utf-8") as file:
        file.write('{"schema": 1, "exper')  # killed while it wrote
    ended = subprocess.run(command, capture_output=True, text=True, check=False)
    assert ended.returncode == 0, ended.stdout + ended.stderr
    assert f"{known} runs are in" in ended.stdout
    assert [line.seed for _, line in store.read()] == list(range(FIRST_SEED, FIRST_SEED + 20))
    assert not list(folder.glob("*.jsonl"))
