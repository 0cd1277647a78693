"""Keeps every test's ROS graph on this host and out of the way of others."""

import os
import pkgutil
import signal
import sys
from importlib.util import find_spec

import pytest

from swarm_common.middleware import ros_env
from swarm_common.model.engines import NO_WHEELS
from swarm_common.model.errors import ConfigError
from swarm_common.process import start
from swarm_common.process.compiled_code import SUFFIX, SWITCH, is_compiled
from tests.fakes import ros_domains

# What imports PyBullet itself is not even collected without it.
PYBULLETS_OWN = "unit/swarm_sim/physics/test_trial.py"
collect_ignore = [] if find_spec("pybullet") else [PYBULLETS_OWN]

start.prepare()
# A shell's background jobs ignore SIGINT and SIGQUIT, those of nohup SIGHUP, and so would all that
# tests start and end. Programs that are started lose a handler, so that nohup still protects us.
for number, handler in (
    (signal.SIGINT, signal.default_int_handler),
    (signal.SIGQUIT, signal.SIG_DFL),
    (signal.SIGHUP, lambda *_: None),
):
    if signal.getsignal(number) is signal.SIG_IGN:
        signal.signal(number, handler)
ros_env.set_defaults()
RESERVATION = ros_domains.unix_socket()
os.environ["ROS_DOMAIN_ID"] = str(ros_domains.of_this_run(RESERVATION))


def pytest_report_header():
    return f"navigators: {'compiled' if is_compiled() else 'as Python; swarm-setup compiles them'}"


@pytest.fixture
def monkeypatch(monkeypatch):
    """Refuse to replace what compiled callers go on to call: the test would prove nothing."""
    replace = monkeypatch.setattr

    def replace_unless_compiled(target, *rest, **options):
        owner, name = target, rest[0]
        if isinstance(target, str):
            path, _, name = target.rpartition(".")
            owner = pkgutil.resolve_name(path)
        is_class = isinstance(owner, type)
        home = owner.__module__ if is_class else getattr(owner, "__name__", "")
        file = getattr(sys.modules.get(home), "__file__", None) or ""
        is_ours = home.startswith("swarm_") and file.endswith(SUFFIX)
        if is_ours and (is_class or callable(getattr(owner, name, None))):
            pytest.fail(f"{home}.{name} is compiled: hand the part in, or start a process with "
                        f"{SWITCH}=1 and say why")  # fmt: skip
        replace(target, *rest, **options)

    monkeypatch.setattr = replace_unless_compiled
    return monkeypatch


def _skipped_without_pybullet():
    """Skip a test that itself asks for PyBullet where there is none; what asks is refused."""
    try:
        yield
    except ConfigError as error:
        if NO_WHEELS not in str(error):
            raise
        pytest.skip("it wants PyBullet, which is not installed")


@pytest.hookimpl(wrapper=True)
def pytest_runtest_setup():
    """Skip by what a fixture asks for."""
    yield from _skipped_without_pybullet()


@pytest.hookimpl(wrapper=True)
def pytest_runtest_call():
    """Skip by what the test asks for; commands that it runs in here leave Ctrl-C as it was."""
    before = signal.getsignal(signal.SIGINT)
    try:
        yield from _skipped_without_pybullet()
    finally:
        signal.signal(signal.SIGINT, before)


def pytest_unconfigure():
    RESERVATION.close()
