"""`swarm-up` over fakes, for the tests of this folder."""

import pytest

from tests.fakes.swarm_up import Up


@pytest.fixture
def up(tmp_path):
    """Yield swarm-up; nothing of it may be left running at the end."""
    up = Up(tmp_path)
    yield up
    assert not up.end()
