"""A plug-in is found by name, and its faults are told once and do not pass."""

import signal
import sys
import time
from importlib.metadata import EntryPoint

import pytest

from swarm_common.model.errors import ConfigError
from swarm_common.process import plugins
from swarm_common.process.plugins import Guard, PluginError, PluginFault, load_plugin

BUILT_IN = {"usual": "collections:OrderedDict"}


def load(name):
    return load_plugin("controllers", name, BUILT_IN, "controller.plugin")


@pytest.fixture
def folder(tmp_path, monkeypatch):
    monkeypatch.setattr(sys, "path", [*sys.path])
    monkeypatch.chdir(tmp_path)
    return tmp_path


def test_a_module_of_the_working_directory_is_found(folder):
    (folder / "part_in_the_folder.py").write_text("class Mine:\n    class Inner: pass\n")
    assert load("part_in_the_folder:Mine").__name__ == "Mine"
    assert load("part_in_the_folder:Mine.Inner").__name__ == "Inner"
    assert load("usual").__name__ == "OrderedDict"


def test_an_entry_point_is_found_by_its_name(monkeypatch):
    def points(group):
        return [EntryPoint("counting", "collections:Counter", group)] * (
            group == "swarm_workbench.controllers"
        )

    monkeypatch.setattr(plugins, "entry_points", points)
    assert load("counting").__name__ == "Counter"
    with pytest.raises(ConfigError, match=r"unknown controller.plugin 'countin'.*'counting'"):
        load("countin")


@pytest.mark.parametrize(
    ("name", "source", "message"),
    [
        ("nowhere:Mine", "", "'nowhere:Mine': there is no module 'nowhere' in "),
        ("part_a:Mine", "import nowhere\n", "its module needs 'nowhere', which is missing"),
        ("part_b:Mine", "1 / 0\n", "its module does not load: ZeroDivisionError"),
        ("part_c:Mine", "class Min: pass\n", "unknown controller.plugin 'Mine' in part_c.*'Min'"),
        ("part_d:Mine", "Mine = 3\n", "'part_d:Mine', which is no class or function"),
    ],
)
def test_one_that_is_missing_is_told(folder, name, source, message):
    if source:
        (folder / f"{name.partition(':')[0]}.py").write_text(source)
    with pytest.raises(ConfigError, match=message):
        load(name)


class Part:
    def __init__(self, start=0.0):
        time.sleep(start)
        self.calls = 0

    def fine(self, number):
        return number + 1

    def wrong(self):
        raise KeyError("x")

    def endless(self):
        self.calls += 1
        while True:
            try:
                time.sleep(0.001)
            except Exception:
                continue


@pytest.fixture(autouse=True)
def _afresh(monkeypatch):
    monkeypatch.setattr(plugins, "_printed", set())
    monkeypatch.setattr(plugins, "MOST_TIME", 0.05)
    monkeypatch.setattr(plugins, "MOST_START_TIME", 0.2)


def test_what_it_raises_is_told_once(capsys):
    guards = [Guard("controller x:Part", Part) for _ in range(2)]
    for guard in guards * 2:
        with pytest.raises(PluginError, match="controller x:Part: wrong raised KeyError") as caught:
            guard.call("wrong")
        assert caught.value.fault is PluginFault.RAISED
        assert guard.call("fine", 2) == 3
    assert capsys.readouterr().err.count("controller x:Part") == 1
    with pytest.raises(KeyError):
        guards[0].call("wrong", passes=(KeyError,))


def test_an_endless_call_is_ended_and_the_plug_in_left_alone():
    rung = []
    before = signal.signal(signal.SIGALRM, lambda *_: rung.append(1))
    outer = signal.setitimer(signal.ITIMER_REAL, 0.3)
    try:
        guard = Guard("controller x:Part", Part)
        for _ in range(3):
            with pytest.raises(PluginError, match=r"longer than 0.05 s") as caught:
                guard.call("endless")
            assert caught.value.fault is PluginFault.LATE
        assert guard._own.calls == 1
        assert not rung
        time.sleep(0.5)
        assert rung == [1], "the timer of somebody else has to go on"
    finally:
        signal.setitimer(signal.ITIMER_REAL, *outer)
        signal.signal(signal.SIGALRM, before)


def test_on_a_busy_machine_the_time_of_the_processor_counts(monkeypatch):
    used = iter((0.0, 0.01, 0.02, 0.1))  # [s] at the start, and each time that the alarm rings
    monkeypatch.setattr(time, "thread_time", lambda: next(used))
    guard = Guard("controller x:Part", lambda: Part())
    used = iter((0.0, 0.01, 0.02, 0.1))
    started = time.monotonic()
    with pytest.raises(PluginError, match="longer"):
        guard.call("endless")
    assert time.monotonic() - started > 0.05 + 0.04 + 0.03 - 0.01
    with pytest.raises(StopIteration):
        next(used)


def test_one_that_cannot_be_made_fails_in_each_call():
    guard = Guard("planner x:Part", Part, 1.0)
    with pytest.raises(PluginError, match="planner x:Part: __init__ took longer"):
        guard.call("fine", 1)
    guard = Guard("planner x:Part", Part, "soon")
    with pytest.raises(PluginError, match="planner x:Part"):
        guard.call("fine", 1)
