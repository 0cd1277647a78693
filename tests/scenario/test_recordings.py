"""A run begins when its recorder records, and ends when it has taken what was sent."""

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
AWAY, THERE = 1.0, 0.3  # [s] for which a recorder that is held up stands, and goes on


@pytest.mark.parametrize(("speed", "is_held_up"), [("max", False), ("4", True)])
def test_a_short_run_is_recorded_from_its_first_tick_to_its_last(tmp_path, speed, is_held_up):
    """It began without its recorder; and what that had not heard yet left with the world."""
    code = "from swarm_commander.cli.main import swarm_up; swarm_up()"
    flags = ("--world", "hall_12", "--swarm-size", "2", "--duration", str(SECONDS))
    more = ("--record", "--headless", "--no-report", "--speed", speed, "--run-dir")
    with reserved_domain() as domain:
        swarm = subprocess.Popen(
            (sys.executable, "-c", code, *flags, *more, tmp_path / "run"),
            env=os.environ | {"ROS_DOMAIN_ID": str(domain)},
        )
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


def _hold_up(swarm):
    """Stop the recorder again and again; longest when its world has gone without it."""
    while swarm.poll() is None:
        with contextlib.suppress(psutil.NoSuchProcess):
            children = psutil.Process(swarm.pid).children(recursive=True)
            parts = {word: child for child in children for word in child.cmdline()}
            if {RECORDER, WORLD} <= parts.keys():
                parts[RECORDER].suspend()
                gone, _ = psutil.wait_procs([parts[WORLD]], AWAY)
                time.sleep(AWAY if gone else 0.0)
                parts[RECORDER].resume()
        time.sleep(THERE)
