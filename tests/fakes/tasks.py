"""Tasks for other processes, which import nothing else for them."""

import os
import signal
from pathlib import Path


def die_once(path):
    """Die where no process has died yet."""
    if not Path(path).exists():
        Path(path).touch()
        os.kill(os.getpid(), signal.SIGKILL)
    return path


def die(_):
    os.kill(os.getpid(), signal.SIGKILL)


def fail(_):
    raise ZeroDivisionError("no")


def own_pid(_):
    return os.getpid()
