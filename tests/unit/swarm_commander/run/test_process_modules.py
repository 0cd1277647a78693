"""Modules that processes are started from by name."""

import importlib.util

import pytest

from swarm_commander.run.process_table import ROBOTS_TABLE, TABLE

NAMES = {row.module for row in (*TABLE, *ROBOTS_TABLE)}


@pytest.mark.parametrize("name", sorted(NAMES))
def test_a_process_is_started_from_a_module_that_exists(name):
    assert importlib.util.find_spec(name) is not None
