"""Requests to the owner of a ROS domain."""

from __future__ import annotations

import os
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
