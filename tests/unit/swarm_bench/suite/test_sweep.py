"""What a sweep says besides its results."""

import io
import time

import numba
import pytest
from rich.console import Console

from swarm_bench.execution import task
from swarm_bench.execution.executor import RunFailedError, executor, values
from swarm_bench.suite import progress


def test_a_first_compilation_is_told_once(capsys: pytest.CaptureFixture[str]) -> None:
    task._say_compiling.cache_clear()
    kernels = [numba.njit(lambda x: x + 1), numba.njit(lambda x: x + 2)]
    with executor() as here:
        assert list(values(here, lambda item: kernels[item](item), [0, 1])) == [1, 3]
    said = capsys.readouterr()
    assert said.err == "compiling kernels, once: a minute or two\n"
    assert said.out == ""


def test_compiled_kernels_are_not_mentioned(capsys: pytest.CaptureFixture[str]) -> None:
    task._say_compiling.cache_clear()
    kernel = numba.njit(lambda x: x + 1)
    kernel(0)
    with executor() as here:
        assert list(values(here, kernel, [0, 1])) == [1, 2]
    assert capsys.readouterr().err == ""


def test_a_run_that_fails_stops_no_other() -> None:
    found: list[int] = []
    with executor() as here:
        ended = values(here, lambda item: 6 // item, [3, 0, 2])
        with pytest.raises(RunFailedError, match="1 of 3 runs failed; the first: ZeroDivision"):
            found.extend(ended)
    assert found == [2, 3]


def test_a_terminal_has_bars_for_runs_and_for_compiling() -> None:
    output = io.StringIO()
    console = Console(file=output, force_terminal=True, width=100)
    kernel = numba.njit(lambda x: x + 1)
    with progress.bar(console, "runs", 2) as tell:
        with executor() as here:
            assert list(values(here, lambda item: kernel(item), [0])) == [1]
        time.sleep(0.3)  # the bars are drawn ten times a second
        tell(1, 2)
    assert "kernels compiled" in output.getvalue()
    assert "1 of 2 runs" in output.getvalue()


def test_elsewhere_there_is_no_bar() -> None:
    output = io.StringIO()
    with progress.bar(Console(file=output), "runs", 2) as tell:
        tell(1, 2)
    assert output.getvalue() == ""
