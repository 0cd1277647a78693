"""What every run leaves for its replay, in files of several processes."""

import numpy as np
import pytest
from rclpy.serialization import serialize_message
from std_msgs.msg import String

from swarm_common.middleware.cdr import TransformsWriter
from swarm_common.middleware.topic_table import robot_topic
from swarm_recording.bag import Bag
from swarm_recording.run_trace import FOLDER, TOPICS, RunTrace

TF, DESCRIPTION = TOPICS["/sim/tf"], robot_topic("Srobot1", "robot_description")


def test_the_files_of_several_processes_are_one_bag(tmp_path):
    (tmp_path / "trace").mkdir()
    world, mission = RunTrace(tmp_path / "trace", "hall_12"), RunTrace(tmp_path / "trace")
    writer = TransformsWriter("map", ["Srobot1/base_footprint"])
    for tick in range(100):
        world.write(TF, tick, writer.encode(tick, np.zeros((1, 3))))
    mission.write(DESCRIPTION, 0, serialize_message(String(data="<robot/>")))
    world.close()
    mission.close()
    told: list[str] = []
    bag = Bag(tmp_path, told.append)
    assert told == []
    assert bag.counts == {"/sim/tf": 100, "/Srobot1/robot_description": 1}
    assert (bag.start, bag.end, bag.about["world"]) == (0.0, pytest.approx(9.9), "hall_12")
    bag.close()


def test_a_trace_that_cannot_be_written_does_not_end_the_run(tmp_path, caplog):
    (tmp_path / FOLDER).write_text("no folder")
    trace = RunTrace(tmp_path)
    trace.write(TF, 0, b"")
    trace.close()
    assert "the run cannot be replayed" in caplog.text
