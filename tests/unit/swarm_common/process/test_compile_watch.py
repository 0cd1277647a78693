"""What is told while numba compiles."""

import sys
from types import ModuleType

import numba
import pytest

from swarm_common.process.compile_watch import watched


@pytest.fixture
def kernels(monkeypatch):
    """A package with three kernels that are not compiled yet."""
    module = ModuleType("fresh_kernels")
    module.first = numba.njit(lambda x: x + 1)
    module.second = numba.njit(lambda x: x + 2)
    module.third = numba.njit(lambda x: x + 3)
    module.again = module.first  # imported elsewhere: counts once
    monkeypatch.setitem(sys.modules, "fresh_kernels", module)
    return module


def test_each_compilation_tells_how_many_kernels_are_ready(kernels):
    said: list[tuple[int, int]] = []
    now = iter(range(0, 1000, 10))
    with watched(lambda *counts: said.append(counts), ("fresh_kernels",), lambda: float(next(now))):
        kernels.first(1)
        kernels.second(1)
    assert said == [(0, 3), (1, 3)]
    kernels.third(1)  # nobody listens any more
    assert len(said) == 2


def test_kernels_that_are_ready_are_not_mentioned(kernels):
    kernels.first(1)
    said: list[tuple[int, int]] = []
    with watched(lambda *counts: said.append(counts), ("fresh_kernels",)):
        kernels.first(2)
    assert said == []
