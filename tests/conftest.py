"""Keeps every test's ROS graph on this host and out of the way of others."""

from __future__ import annotations

import os
import signal
from collections.abc import Iterator
from importlib.util import find_spec

import pytest

# Tests replace parts of robots; the Makefile takes the compiled navigators for real runs.
os.environ.setdefault("SWARM_INTERPRETED", "1")
from swarm_common.middleware import ros_env
from swarm_common.model.engines import NO_WHEELS
from swarm_common.model.errors import ConfigError
from swarm_common.process import start
from tests.fakes import ros_domains

# What imports PyBullet itself is not even collected without it.
PYBULLETS_OWN = "unit/swarm_sim/physics/test_trial.py"
collect_ignore = [] if find_spec("pybullet") else [PYBULLETS_OWN]

start.prepare()
ros_env.set_defaults()
RESERVATION = ros_domains.unix_socket()
os.environ["ROS_DOMAIN_ID"] = str(ros_domains.of_this_run(RESERVATION))


def _skipped_without_pybullet() -> Iterator[None]:
    """Skip a test that itself asks for PyBullet where there is none; what asks is refused."""
    try:
        yield
    except ConfigError as error:
        if NO_WHEELS not in str(error):
            raise
        pytest.skip("it wants PyBullet, which is not installed")


@pytest.hookimpl(wrapper=True)
def pytest_runtest_setup() -> Iterator[None]:
    """Skip by what a fixture asks for."""
    yield from _skipped_without_pybullet()


@pytest.hookimpl(wrapper=True)
def pytest_runtest_call() -> Iterator[None]:
    """Skip by what the test asks for; commands that it runs in here leave Ctrl-C as it was."""
    before = signal.getsignal(signal.SIGINT)
    try:
        yield from _skipped_without_pybullet()
    finally:
        signal.signal(signal.SIGINT, before)


def pytest_unconfigure() -> None:
    """Let others have the domain."""
    RESERVATION.close()
