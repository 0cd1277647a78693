"""The nursery and its children, with a navigator that does nothing."""

import json
import os
import threading
import time
from types import SimpleNamespace

import psutil
import pytest

from swarm_common.pipes import EventWriter
from swarm_nav import nursery as module
from swarm_nav.group import Group
from swarm_nav.nursery import Nursery

PACK = Group((SimpleNamespace(name="Srobot1"), SimpleNamespace(name="Srobot2")))


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


def test_a_pack_that_hangs_is_killed_and_started_anew(pipe, monkeypatch):
    reading, writing = pipe
    monkeypatch.setattr(module, "run_navigators", hang)
    monkeypatch.setattr(module, "GRACE", 0.1)
    before = set(child())
    nursery = Nursery(EventWriter(None))
    os.write(writing, json.dumps({"cmd": "go"}).encode() + b"\n")
    assert nursery.wait_for_go(reading)
    nursery.fork(PACK, None)
    (first,) = set(child()) - before
    watch = threading.Thread(target=nursery.watch, args=(SimpleNamespace(log_dir=None),))
    watch.start()
    try:
        for name in ("Srobot1", "Srobot2"):
            os.write(writing, json.dumps({"cmd": "renew", "robot": name}).encode() + b"\n")
        end = time.monotonic() + 20.0
        while not set(child()) - before - {first}:
            assert time.monotonic() < end
            time.sleep(0.05)
        time.sleep(0.3)
        assert not psutil.pid_exists(first)
        assert len(set(child()) - before) == 1
    finally:
        nursery.stop()
        watch.join()
    assert set(child()) <= before
