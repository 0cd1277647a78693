"""Real swarms in ROS domains of their own."""

import contextlib
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from tests.fakes.ros_domains import reserved_domain
from tests.faults.real_swarm import RealSwarm


@pytest.fixture
def start(tmp_path: Path) -> Iterator[Callable[..., RealSwarm]]:
    """Yield a function that starts a swarm; at the end nothing may be left of any."""
    with contextlib.ExitStack() as stack:

        def begin(*flags: str) -> RealSwarm:
            domain = stack.enter_context(reserved_domain())
            folder = tmp_path / str(domain)
            folder.mkdir()
            swarm = RealSwarm(folder, domain, *flags)
            stack.callback(swarm.check_nothing_left)
            stack.callback(swarm.close)
            return swarm

        yield begin
