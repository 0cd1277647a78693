import signal
import subprocess
import sys
import threading

import pytest

from swarm_common.process.signals import late_interrupt

# Presses Ctrl-C at an import in the middle of rclpy's, as the two that connect to a graph do it.
PROGRAM = """
import os, signal, sys
from importlib.machinery import PathFinder
from types import SimpleNamespace
from swarm_workbench.external import ExternalRobot
from swarm_workbench.graph import GraphBackend

class Finder(PathFinder):
    @classmethod
    def find_spec(cls, name, *_):
        if name == "rclpy.context":
            os.kill(os.getpid(), signal.SIGINT)
sys.meta_path.insert(0, Finder)
try:
    {call}
except KeyboardInterrupt:
    print("rclpy.executors" in sys.modules)
"""
CALLS = (
    "ExternalRobot('Srobot1', print, domain=77)._connect()",
    "GraphBackend._see(SimpleNamespace(domain=77, names=['Srobot1']))",
)


def test_ctrl_c_comes_at_the_end():
    steps = []

    @late_interrupt()
    def work():
        signal.raise_signal(signal.SIGINT)
        steps.append(1)

    with pytest.raises(KeyboardInterrupt):
        work()
    assert steps == [1]
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler


def test_another_thread_changes_nothing():
    seen = []

    def look():
        with late_interrupt():
            seen.append(signal.getsignal(signal.SIGINT))

    thread = threading.Thread(target=look)
    thread.start()
    thread.join()
    assert seen == [signal.default_int_handler]


@pytest.mark.parametrize("call", CALLS)
def test_ros_is_loaded_whole(call):
    """rclpy's C++ told of a missing file when Ctrl-C came while it was imported."""
    done = subprocess.run(
        (sys.executable, "-c", PROGRAM.format(call=call)),
        capture_output=True, text=True, timeout=60, check=False,
    )  # fmt: skip
    assert done.stdout == "True\n", done.stderr
