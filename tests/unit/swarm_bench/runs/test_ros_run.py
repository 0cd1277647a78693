"""A run on the ROS graph takes its swarm along, however the bench ends."""

import signal
import subprocess
import sys
import time

import psutil
import pytest

CODE = """
import signal, sys
from swarm_bench.runs import ros_run
from swarm_bench.runs.scenario import load_scenario
from swarm_bench.runs.episode import RunOptions

ros_run.SWARM_UP = (sys.executable, "-c", sys.argv[1], sys.argv[2])
ros_run.run_on_graph(RunOptions(scenario=load_scenario("station"), robots=2))
"""
SWARM = "import os, sys, time; open(sys.argv[1], 'w').write(f'{os.getpid()}\\n'); time.sleep(60)"


@pytest.mark.parametrize(
    "number", [signal.SIGKILL, pytest.param(signal.SIGINT, marks=pytest.mark.long)]
)
def test_no_swarm_is_left_of_a_bench_that_ended(tmp_path, number):
    note = tmp_path / "pid"
    bench = subprocess.Popen((sys.executable, "-c", CODE, SWARM, note), stderr=subprocess.DEVNULL)
    while not (note.is_file() and note.read_text().endswith("\n")):
        assert bench.poll() is None
        time.sleep(0.05)
    swarm = psutil.Process(int(note.read_text()))
    bench.send_signal(number)
    bench.wait(10.0)
    gone, _ = psutil.wait_procs([swarm], timeout=10.0)
    assert gone
