"""A run begins when its recorder records, and its end says what the recording lacks."""

import contextlib
import json
import os
import subprocess
import sys

from swarm_common.model.records import CONTROL_PERIOD
from swarm_recording.bag import Bag
from tests.fakes.ros_domains import reserved_domain

SECONDS = 20
ROBOTS = ("Srobot1", "Srobot2")


def test_a_short_fast_run_is_recorded_from_its_first_tick(tmp_path):
    """Nobody waited for the recorder: it came when the run was over, or in its midst."""
    code = "from swarm_commander.cli.main import swarm_up; swarm_up()"
    flags = ("--world", "hall_12", "--swarm-size", "2", "--duration", str(SECONDS))
    more = ("--record", "--headless", "--no-report", "--speed", "max", "--run-dir")
    with reserved_domain() as domain:
        subprocess.run(
            (sys.executable, "-c", code, *flags, *more, tmp_path / "run"),
            env=os.environ | {"ROS_DOMAIN_ID": str(domain)}, check=True,
        )  # fmt: skip
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
                # On a busy machine messages are lost: no later one tells of the last tick's, which
                # is not answered any more either.
                lacks_last = stamps[-1] < round(SECONDS * 1e9)
                assert len(stamps) + bag.lost.get(topic, 0) + lacks_last == ticks, topic
