"""Requests to the owner of a ROS domain."""

import os
import subprocess
import sys
import threading

import pytest

from swarm_common.model.errors import ConfigError
from swarm_common.process.messages import RestartNavigator
from swarm_run import domain
from swarm_run.domain import DomainLock, ask

DOMAIN = 226


@pytest.mark.parametrize(
    ("user", "answer"), [(os.getuid(), "is active"), (os.getuid() + 1, "belongs to another user")]
)
def test_only_the_swarms_user_may_restart_robots(monkeypatch, user, answer):
    """Others were told that no swarm-up was there: "connection reset by peer"."""
    answers = []

    def restart():
        try:
            answers.append(ask(DOMAIN, RestartNavigator("Srobot1"), 10.0))
        except ConfigError as error:
            answers.append(str(error))

    monkeypatch.setattr(domain, "_user_of", lambda _: user)
    lock = DomainLock(DOMAIN)
    client = threading.Thread(target=restart)
    client.start()
    try:
        while client.is_alive():
            if (request := lock.take()) is not None:
                request.answer("Srobot1 is active again", is_done=True)
            client.join(0.01)
    finally:
        lock.release()
    assert answer in answers[0]


def test_a_claim_that_is_handed_on_holds_without_a_gap():
    """A program chose a domain, its swarm claimed it later: two programs chose the same one."""
    lock = DomainLock(DOMAIN)
    script = "import sys, time; from swarm_run.domain import DomainLock as D; "
    script += f"lock = D.of({lock.fileno()}); print(flush=True); sys.stdin.read()"
    child = subprocess.Popen(
        (sys.executable, "-c", script), pass_fds=(lock.fileno(),), text=True,
        stdin=subprocess.PIPE, stdout=subprocess.PIPE,
    )  # fmt: skip
    lock.release()
    with pytest.raises(ConfigError, match="in use by another swarm"):
        DomainLock(DOMAIN)
    assert child.stdout.readline() == "\n"
    with pytest.raises(ConfigError, match="in use by another swarm"):
        DomainLock(DOMAIN)
    child.communicate()
    DomainLock(DOMAIN).release()
