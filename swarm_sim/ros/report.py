"""Reports of the world on a run: twice a second while it goes on, and at its end."""

from __future__ import annotations

import contextlib
import json
import resource
import time
from pathlib import Path
from typing import Any

from rclpy.node import Node
from rclpy.serialization import serialize_message
from swarm_interfaces.msg import Verdict as VerdictMsg

from swarm_common.files.storage import write_whole
from swarm_common.middleware import ros_io
from swarm_common.model.breaches import Collision
from swarm_common.process.messages import (
    CollisionBegan,
    CollisionCounts,
    VerdictReached,
    WorldProgress,
)
from swarm_common.process.pipes import EventWriter
from swarm_recording.run_trace import TOPICS, RunTrace
from swarm_sim.ros.pacing import SpeedMeter
from swarm_sim.ros.robots.barrier import Barrier
from swarm_sim.world.world import World


class Reporter:
    """The topic /sim/verdict, and events for swarm-up."""

    def __init__(
        self,
        node: Node,
        world: World,
        barrier: Barrier,
        events: EventWriter,
        replay: RunTrace | None = None,
    ) -> None:
        """Create the topic.

        Args:
            replay: Keeps verdicts for replays; None if nobody wants that.
        """
        self._replay = replay
        self._world = world
        self._barrier = barrier
        self._events = events
        self._meter = SpeedMeter()
        self._started = time.monotonic()
        self._verdict = node.create_publisher(VerdictMsg, "/sim/verdict", ros_io.RELIABLE)

    def start(self, now: float) -> None:
        """Begin to count the time of the run."""
        self._started = now
        self._meter.start(now, self._world.sim_time)

    def report(self, tick: int, robots: int, *, is_paused: bool) -> None:
        """Report the state of the run."""
        self._meter.update(time.monotonic(), self._world.sim_time)
        verdict = self._world.verdict
        message = VerdictMsg(stamp=ros_io.time_msg(tick))
        message.real_time_factor = self._meter.factor
        message.robots = robots
        message.answering = self._barrier.answering if self._barrier.has_started else 0
        message.collisions_robot_robot = verdict.robot_robot
        message.collisions_robot_world = verdict.robot_world
        message.min_clearance = verdict.min_clearance
        message.late_ticks = self._barrier.late_ticks
        self._verdict.publish(message)
        if self._replay is not None:
            self._replay.write(TOPICS["/sim/verdict"], tick, serialize_message(message))
        self._events.write(
            WorldProgress(
                sim_time=verdict.sim_time,
                real_time_factor=round(self._meter.factor, 3),
                collisions=CollisionCounts(verdict.robot_robot, verdict.robot_world),
                min_clearance=verdict.as_json()["min_clearance"],
                late_ticks=self._barrier.late_ticks,
                answering=message.answering,
                is_paused=is_paused,
            )
        )

    def collision(self, collision: Collision) -> None:
        """Report a collision."""
        self._events.write(CollisionBegan(collision))

    def final(self, path: str | None) -> dict[str, Any]:
        """Return the verdict of the run, and write it if `path` says where.

        Args:
            path: File to write; None for none. A disk that is full is no error.
        """
        wall_time = time.monotonic() - self._started
        usage = resource.getrusage(resource.RUSAGE_SELF)
        data = self._world.verdict.as_json() | {
            "ticks": self._world.tick,
            "wall_time": wall_time,
            "real_time_factor": self._world.sim_time / wall_time if wall_time > 0.0 else 0.0,
            "late_ticks": self._barrier.late_ticks,
            "cpu_s": usage.ru_utime + usage.ru_stime,
            "rss_mb": usage.ru_maxrss / 1024.0,
        }
        self._events.write(VerdictReached(data))  # in case that the disk is full
        if path is not None:
            with contextlib.suppress(OSError):
                write_whole(Path(path), json.dumps(data, indent=1))
        return data
