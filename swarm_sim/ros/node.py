"""The world's process: `python -m swarm_sim.ros.node CONFIG.json [--event-fd N] [--control-fd M]`.

At each tick it publishes what every robot senses, waits for the answers of all that live, and
advances the world. Nothing in it is decided by the wall clock except who is late.
"""

from __future__ import annotations

import os
import signal
import sys
import time

import rclpy
from rclpy.signals import SignalHandlerOptions

from swarm_common.middleware import ros_env
from swarm_common.middleware.participants import prepare
from swarm_common.middleware.ros_io import map_digest
from swarm_common.model.errors import SwarmError
from swarm_common.process.messages import Note, Ready, Refused, TimeOver, WorldBuilt
from swarm_common.process.pipes import EventWriter, child_options
from swarm_common.process.quick_start import load_numba, without_collector
from swarm_sim.ros.build import BROKEN, build
from swarm_sim.ros.settings import read_settings
from swarm_sim.ros.world_node import WorldNode

END_PERIOD = 0.02  # [s] of wall time between two looks for the end


def main() -> int:
    """Run the world until it is told to stop; return the exit code, 2 for bad settings."""
    options = child_options("World of a swarm")
    events = EventWriter(options.event_fd)
    try:
        settings = read_settings(options.config)
        with without_collector():
            load_numba()
            setup, world = build(settings)
    except SwarmError as error:
        events.write(Refused(str(error)))
        sys.stderr.write(f"{error}\n")
        return 2
    for note in setup.scene.notes:
        events.write(Note(note))
    poses = [(pose.x, pose.y, pose.yaw) for pose in setup.starts]
    unseen = list(setup.unseen(settings.body_margin, BROKEN))
    events.write(WorldBuilt(poses, map_digest(setup.grid), unseen))
    ros_env.set_defaults()
    robots = len(settings.robots)
    profile = options.config.resolve().with_suffix(".xml")
    is_large = prepare(robots, settings.processes or robots, profile)
    rclpy.init(signal_handler_options=SignalHandlerOptions.NO)
    node = WorldNode(setup, world, settings, events, is_large=is_large)
    ending: list[int] = []

    def end(number: int, _: object) -> None:
        ending.append(number)
        node.stop()

    for number in (signal.SIGTERM, signal.SIGINT):
        signal.signal(number, end)
    if options.control_fd is not None:
        node.listen(options.control_fd)
    events.write(Ready())
    node.run()
    node.finish()
    if node.is_over:
        events.write(TimeOver())
    while options.control_fd is not None and not ending:  # swarm-up says when all has been taken
        time.sleep(END_PERIOD)
    node.destroy()
    return 0


if __name__ == "__main__":
    code = main()
    sys.stdout.flush()
    sys.stderr.flush()
    os._exit(code)  # the interpreter's own end takes seconds with numba, pybullet and DDS in it
