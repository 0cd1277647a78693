"""A shell's background job, and one of nohup, tests what a foreground job tests."""

import signal
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).parents[2]
IGNORED = (signal.SIGINT, signal.SIGQUIT, signal.SIGHUP)
CODE = """
import subprocess
import tests.conftest
print(subprocess.check_output(["cat", "/proc/self/status"], text=True))
"""


def ignore():
    for number in IGNORED:
        signal.signal(number, signal.SIG_IGN)


def test_what_tests_start_ignores_no_signal_that_the_shell_had_them_ignore():
    done = subprocess.run(
        (sys.executable, "-c", CODE),
        cwd=ROOT,
        preexec_fn=ignore,
        capture_output=True,
        text=True,
        check=True,
    )
    masks = dict(line.split(":", 1) for line in done.stdout.splitlines() if ":" in line)
    ignored = int(masks["SigIgn"], 16)
    assert [number for number in IGNORED if ignored >> (number - 1) & 1] == []
