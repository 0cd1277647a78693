"""On a robots' host: gives each robot its part of the batch of beacons that came from the world.

python -m swarm_commander.hosts.distributor CONFIG.json --event-fd N --control-fd M
"""

from __future__ import annotations

import json
import os
import signal
import sys
import time

from std_msgs.msg import UInt8MultiArray
from swarm_interfaces.msg import NeighborArray

from swarm_common.middleware import ros_io
from swarm_common.middleware.beacon_batch import KIND, BatchReader, topic_of
from swarm_common.middleware.rclpy_compat import join_graph
from swarm_common.middleware.rejections import Rejections
from swarm_common.middleware.ros_poll import PolledTopic, Waiter
from swarm_common.middleware.sealed import ForgedError
from swarm_common.middleware.secret import VARIABLE
from swarm_common.process.pipes import EventWriter, child_options, leave

WAIT_SLICE = 0.25  # [s] after which signals are looked at


def main() -> None:
    """Run until SIGTERM."""
    options = child_options("Beacons for the robots of a host")
    config = json.loads(options.config.read_text(encoding="utf-8"))
    reader = BatchReader(os.environ.pop(VARIABLE), config["run"], config["host"])
    stopping: list[int] = []
    signal.signal(signal.SIGTERM, lambda number, _: stopping.append(number))
    node = join_graph(f"beacons_{config['host']}", "sim")
    robots = {
        int(number): node.create_publisher(NeighborArray, f"/{name}/neighbors", ros_io.RELIABLE)
        for number, name in config["robots"].items()
    }
    topic = PolledTopic(node, UInt8MultiArray, topic_of(config["host"]), ros_io.TICK_INPUT)
    waiter = Waiter(node.context)
    events = EventWriter(options.event_fd)
    rejections = Rejections(events, lambda line: sys.stderr.write(line + "\n"))
    while not stopping:
        waiter.wait([topic], WAIT_SLICE)
        rejections.tell(time.monotonic())
        while (message := topic.take()) is not None:
            try:
                heard = reader.decode(message)
            except ForgedError as error:
                rejections.reject(KIND, "the network", error)
                continue
            for number, data in heard:
                if number in robots:
                    robots[number].publish(data)


if __name__ == "__main__":
    main()
    leave()
