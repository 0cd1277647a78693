import subprocess
import sys


def test_no_kernel_is_compiled_after_the_warm_up():
    """A robot that compiles stands still for seconds, and the whole swarm with it."""
    script = (sys.executable, "-m", "tests.unit.swarm_nav.warm_swarm")
    done = subprocess.run(script, capture_output=True, text=True, timeout=280, check=True)
    assert done.stdout == ""
