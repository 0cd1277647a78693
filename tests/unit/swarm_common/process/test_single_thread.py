"""What is forked must have one thread; see `quick_start`."""

import subprocess
import sys

PREPARED = """
import os
import swarm_nav.launch.fork_server_main as host
host._prepare(host.EventWriter(None))
os.write(1, str(len(os.listdir("/proc/self/task"))).encode())
os._exit(0)
"""


def test_the_fork_server_has_one_thread_when_it_is_ready_to_fork():
    """numpy, scipy, numba, rclpy and all type supports are loaded by then."""
    command = (sys.executable, "-c", PREPARED)
    done = subprocess.run(command, capture_output=True, text=True, check=True, timeout=250)
    assert done.stdout == "1", done.stderr


def test_within_it_no_thread_starts():
    code = (
        "import threading\n"
        "from swarm_common.process.quick_start import without_threads\n"
        "with without_threads():\n"
        "    try:\n"
        "        threading.Thread(target=int).start()\n"
        "    except RuntimeError as error:\n"
        "        print(error)\n"
    )
    command = (sys.executable, "-c", code)
    done = subprocess.run(command, capture_output=True, text=True, check=True, timeout=60)
    assert "can't start new thread" in done.stdout
