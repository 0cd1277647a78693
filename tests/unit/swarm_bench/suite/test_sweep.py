"""What a sweep says besides its results."""

import io
import time

import msgspec
import numba
import pytest
from rich.console import Console

from swarm_bench.execution import task
from swarm_bench.execution.executor import executor
from swarm_bench.execution.store import Store
from swarm_bench.execution.sweep import Sweep, bar
from swarm_common.model.errors import ConfigError


def test_a_first_compilation_is_told_once(capsys):
    task._say_compiling.cache_clear()
    kernels = [numba.njit(lambda x: x + 1), numba.njit(lambda x: x + 2)]
    with executor() as here:
        assert [
            done.value for done in here.run(lambda item: kernels[item](item), [0, 1], None)
        ] == [1, 3]
    said = capsys.readouterr()
    assert said.err == "compiling kernels, once: a minute or two\n"
    assert said.out == ""


class Half(msgspec.Struct):
    of: int
    half: int

    def as_json(self):
        return {"schema": 1, "of": self.of, "half": self.half}


def half(item):
    return Half(item, 12 // item // 2)


def sweep_of(items, path, shard=""):
    return Sweep(
        items=items, runner=half, key=lambda item: item, key_of=lambda result: result.of,
        store=Store(path, lambda data: msgspec.convert(data, Half), "halve", shard),
        line=lambda result: f"{result.of}: {result.half}",
    )  # fmt: skip


def test_a_run_that_fails_stops_no_other_and_is_made_again(tmp_path):
    console = Console(file=io.StringIO(), width=170)
    for _ in range(2):
        sweep = sweep_of([3, 0, 2, 3], tmp_path / "a.jsonl")
        assert [result.half for result in sweep.run(console)] in ([2, 3], [2, 3, 2])
        assert len(sweep.failed) == 1
    said = console.file.getvalue()
    assert said.count("0: failed: ZeroDivisionError") == 2
    assert "2 of 4 runs are in" in said


def test_a_sweep_ends_when_its_time_is_up():
    assert len(sweep_of([3, 2, 1], None).run(Console(quiet=True), seconds=0.0)) == 1


def test_lines_are_packed_and_those_that_somebody_writes_stay(tmp_path):
    path = tmp_path / "a.jsonl.gz"
    for items, shard in (([1], "1/2"), ([2], "2/2")):
        sweep_of(items, path, shard).run(Console(quiet=True))
    store = sweep_of([], path).store
    with sweep_of([], path, "2/2").store.adding() as add:
        add(Half(4, 1))
        with pytest.raises(ConfigError, match=r"another bench is writing to .*a\.2-2\.jsonl"):
            with sweep_of([], path, "2/2").store.adding():
                pass
        store.pack(lambda result: result.of)
        add(Half(6, 1))
    assert {file.name for file in tmp_path.iterdir()} == {"a.jsonl.gz", "a.2-2.jsonl"}
    assert sorted(store.by_key(lambda result: result.of)) == [1, 2, 4, 6]
    store.pack(lambda result: result.of)
    assert [file.name for file in tmp_path.iterdir()] == ["a.jsonl.gz"]
    (tmp_path / "a.jsonl").write_text('{"schema": 1, "of"', encoding="utf-8")  # killed here
    assert len(store.read()) == 4
    with store.adding() as add:
        add(Half(8, 1))
    assert sorted(store.by_key(lambda result: result.of)) == [1, 2, 4, 6, 8]
    packed = path.read_bytes()
    path.write_bytes(packed[:-20])
    with pytest.raises(ConfigError, match="cannot read"):
        store.read()


def test_a_terminal_has_bars_and_elsewhere_there_is_none():
    output = io.StringIO()
    console = Console(file=output, force_terminal=True, width=100)
    kernel = numba.njit(lambda x: x + 1)
    with bar(console, "runs", 2) as tell:
        with executor() as here:
            assert [done.value for done in here.run(lambda item: kernel(item), [0], None)] == [1]
        time.sleep(0.3)  # the bars are drawn ten times a second
        tell(1, 2)
    assert "kernels compiled" in output.getvalue()
    assert "1 of 2 runs" in output.getvalue()
    output = io.StringIO()
    with bar(Console(file=output), "runs", 2) as tell:
        tell(1, 2)
    assert output.getvalue() == ""
