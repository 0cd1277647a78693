"""A child process that cannot be started."""

import errno
import os
import subprocess

import pytest

from swarm_commander.run.processes.launch import ProcessChild
from swarm_commander.run.processes.supervisor import ProcessSpec


def test_a_user_who_may_have_no_more_processes_is_told_so(tmp_path, monkeypatch):
    """It was "cannot go on: [Errno 11] Resource temporarily unavailable"."""

    def refuse(*_, **__):
        raise BlockingIOError(errno.EAGAIN, os.strerror(errno.EAGAIN))

    monkeypatch.setattr(subprocess, "Popen", refuse)
    with pytest.raises(OSError, match=r"cannot start world: .* no more processes .ulimit -u"):
        ProcessChild(ProcessSpec("world", ("true",), 1.0), tmp_path / "world.log", {})
