"""What a sweep says besides its results."""

import numba
import pytest

from swarm_bench.execution import task
from swarm_bench.suite import sweep


def test_a_first_compilation_is_told_once(capsys: pytest.CaptureFixture[str]) -> None:
    task._say_compiling.cache_clear()
    kernels = [numba.njit(lambda x: x + 1), numba.njit(lambda x: x + 2)]
    assert list(sweep.in_processes([0, 1], 1, lambda item: kernels[item](item))) == [1, 3]
    said = capsys.readouterr()
    assert said.err == "compiling kernels, once: a minute or two\n"
    assert said.out == ""


def test_compiled_kernels_are_not_mentioned(capsys: pytest.CaptureFixture[str]) -> None:
    task._say_compiling.cache_clear()
    kernel = numba.njit(lambda x: x + 1)
    kernel(0)
    assert list(sweep.in_processes([0, 1], 1, kernel)) == [1, 2]
    assert capsys.readouterr().err == ""
