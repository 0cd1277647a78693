"""`swarm-up` over fakes, for the tests of this folder."""

from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.fakes.swarm_up import Up


@pytest.fixture
def up(tmp_path: Path) -> Iterator[Up]:
    """Yield swarm-up; nothing of it may be left running at the end."""
    up = Up(tmp_path)
    yield up
    assert not up.end()
