"""The viewer's loop between its announcement and its end."""

import os
import signal

import pytest

from swarm_view.viewer import run_until_signal


class Stopped:
    """A viewer that only notes what it is told."""

    def __init__(self):
        self.told: list[str] = []

    def stop(self):
        self.told.append("stop")

    def run(self):
        self.told.append("run")

    def close(self):
        self.told.append("close")


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_who_ends_it_as_soon_as_it_is_announced_ends_it_properly(number):
    before = {sign: signal.getsignal(sign) for sign in (signal.SIGINT, signal.SIGTERM)}
    viewer = Stopped()
    try:
        run_until_signal(viewer, lambda: os.kill(os.getpid(), number))
    finally:
        for sign, handler in before.items():
            signal.signal(sign, handler)
    assert viewer.told == ["stop", "run", "close"]
