"""Modules that processes are started from by name."""

from __future__ import annotations

import importlib.util
from itertools import chain

import pytest

from swarm_commander.hosts import robots_run, world_run
from swarm_commander.run import local_run

NAMES = set(
    chain(
        local_run.MODULES.values(),
        robots_run.OWN_MODULES.values(),
        world_run.OWN_MODULES.values(),
    )
)


@pytest.mark.parametrize("name", sorted(NAMES))
def test_a_process_is_started_from_a_module_that_exists(name: str) -> None:
    assert importlib.util.find_spec(name) is not None
