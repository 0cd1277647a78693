"""Hosts are network namespaces; without the right to make some, these tests are skipped."""

import os
import shutil
from collections.abc import Callable
from contextlib import ExitStack

import pytest

from tests.fakes.hosts.host_swarm import HostSwarm

StartHosts = Callable[[int], HostSwarm]


@pytest.fixture
def start_hosts(tmp_path):
    """Yield a function that makes hosts; they and all that runs on them go with the test."""
    if os.geteuid() != 0 or shutil.which("ip") is None:
        pytest.skip("network namespaces need root and the command ip (iproute2)")
    with ExitStack() as stack:
        yield lambda count: stack.enter_context(HostSwarm(count, tmp_path))
