"""A run begins when all are there that are to see it, and ends when they have seen the last."""

import contextlib
import json
import os
import subprocess
import sys
import time

import psutil
import pytest

from swarm_common.model.records import CONTROL_PERIOD
from swarm_recording.bag import Bag
from tests.fakes.ros_domains import reserved_domain

SECONDS = 20
ROBOTS = ("Srobot1", "Srobot2")
RECORDER, WORLD = "swarm_recording.recorder", "swarm_sim.ros.node"
RUNNER = "swarm_commander.mission.runner"
AWAY, THERE = 1.0, 0.3  # [s] for which a recorder that is held up stands, and goes on
STATUS_PERIOD = 500_000_000  # [ns]
LATE = 12.0  # [s] that a mission process does nothing at first


@pytest.mark.parametrize(("speed", "is_held_up"), [("max", False), ("4", True)])
def test_a_short_run_is_recorded_from_its_first_tick_to_its_last(tmp_path, speed, is_held_up):
    """It began without its recorder; and what that had not heard yet left with the world."""
    with _running(tmp_path / "run", SECONDS, "--record", "--speed", speed) as swarm:
        if is_held_up:
            _hold_up(swarm)
        assert swarm.wait() == 0
    report = json.loads((tmp_path / "run" / "report.json").read_text(encoding="utf-8"))
    told = report["recording"]
    assert told["missing"] == []
    with contextlib.closing(Bag(tmp_path / "run")) as bag:
        assert bag.lost == told["lost"]
        assert told["messages"] == sum(bag.counts.values())
        for topic in ("/map", "/sim/scene", *(f"/{robot}/tf_static" for robot in ROBOTS)):
            assert bag.counts[topic] == 1
        for robot in ROBOTS:
            for name in ("odom", "cmd_vel"):
                topic = f"/{robot}/{name}"
                stamps = [item.time for item in bag.messages([topic])]
                assert stamps[0] == 0, topic
                ticks = round(SECONDS / CONTROL_PERIOD) + 1
                assert len(stamps) + bag.lost.get(topic, 0) == ticks, topic


def test_time_does_not_begin_before_the_states_of_all_robots_are_kept(tmp_path):
    """A replay had no states of a robot whose status the mission process discovered too late."""
    with _running(tmp_path / "run", 1, "--speed", "max") as swarm:
        while RUNNER not in (parts := _parts(swarm)) and swarm.poll() is None:
            time.sleep(0.01)
        parts[RUNNER].suspend()
        time.sleep(LATE)
        parts[RUNNER].resume()
        assert swarm.wait() == 0
    with contextlib.closing(Bag(tmp_path / "run" / "trace" / "replay")) as bag:
        for robot in ROBOTS:
            assert next(item.time for item in bag.messages([f"/{robot}/status"])) <= STATUS_PERIOD


@contextlib.contextmanager
def _running(folder, seconds, *flags):
    code = "from swarm_commander.cli.main import swarm_up; swarm_up()"
    usual = ("--world", "hall_12", "--swarm-size", "2", "--duration", str(seconds))
    more = ("--headless", "--no-report", "--run-dir", str(folder))
    with reserved_domain() as domain:
        yield subprocess.Popen(
            (sys.executable, "-c", code, *usual, *more, *flags),
            env=os.environ | {"ROS_DOMAIN_ID": str(domain)},
        )


def _parts(swarm):
    """Return the processes of a swarm, by the words of their commands."""
    children = psutil.Process(swarm.pid).children(recursive=True)
    return {word: child for child in children for word in child.cmdline()}


def _hold_up(swarm):
    """Stop the recorder again and again; longest when its world has gone without it."""
    while swarm.poll() is None:
        with contextlib.suppress(psutil.NoSuchProcess):
            parts = _parts(swarm)
            if {RECORDER, WORLD} <= parts.keys():
                parts[RECORDER].suspend()
                gone, _ = psutil.wait_procs([parts[WORLD]], AWAY)
                time.sleep(AWAY if gone else 0.0)
                parts[RECORDER].resume()
        time.sleep(THERE)
