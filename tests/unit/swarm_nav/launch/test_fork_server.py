"""The fork server and its children, with a navigator that does nothing."""

import os
import threading
import time
from types import SimpleNamespace

import psutil
import pytest

from swarm_common.process import messages as say
from swarm_common.process.pipes import EventWriter, MessageReader
from swarm_nav.launch import fork_server as module
from swarm_nav.launch.fork_server import ForkServer
from swarm_nav.launch.process_groups import Group

PACK = Group((SimpleNamespace(name="Srobot1"), SimpleNamespace(name="Srobot2")))


def alone(name):
    return Group((SimpleNamespace(name=name),))


@pytest.fixture
def pipe():
    ends = os.pipe()
    yield ends
    for end in ends:
        os.close(end)


def hang(*_):
    import signal

    signal.signal(signal.SIGTERM, signal.SIG_IGN)
    time.sleep(60.0)


def child():
    return [process.pid for process in psutil.Process().children()]


def test_a_pack_that_hangs_is_killed_and_its_robots_are_started_anew(pipe, monkeypatch):
    reading, writing = pipe
    said, saying = os.pipe()
    monkeypatch.setattr(module, "run_navigators", hang)
    monkeypatch.setattr(module, "GRACE", 0.1)
    before = set(child())
    fork_server = ForkServer(EventWriter(saying))
    events = MessageReader(said, say.EVENTS)
    heard = []

    def tell(command):
        os.write(writing, say.encode(command))

    def wait_for(kind, robots):
        end = time.monotonic() + 20.0
        while not robots <= {event.robot for event in heard if isinstance(event, kind)}:
            assert time.monotonic() < end, heard
            heard.extend(events.read())
            time.sleep(0.05)

    tell(say.Go())
    assert fork_server.wait_for_go(reading)
    fork_server.fork(PACK, None)
    (first,) = set(child()) - before
    grouping = SimpleNamespace(log_dir=None, newcomer=lambda name, _: alone(name))
    watch = threading.Thread(target=fork_server.watch, args=(grouping,))
    watch.start()
    try:
        tell(say.KillNavigator("Srobot1"))
        wait_for(say.NavigatorDied, {"Srobot1", "Srobot2"})
        assert not psutil.pid_exists(first)
        heard.clear()
        for name in ("Srobot1", "Srobot2"):
            tell(say.StartNavigator(name, ""))
        wait_for(say.NavigatorForked, {"Srobot1", "Srobot2"})
        assert len(set(child()) - before) == 2
        heard.clear()
        tell(
            say.StartNavigator("Srobot1", "")
        )  # one of a pack that left the graph, while its process lives
        wait_for(say.NavigatorForked, {"Srobot1"})
        assert len(set(child()) - before) == 3
    finally:
        fork_server.stop()
        watch.join()
        for end in (said, saying):
            os.close(end)
    assert set(child()) <= before
