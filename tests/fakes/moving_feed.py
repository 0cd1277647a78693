"""A feed without a graph: robots drive round circles in the factory hall."""

import math
import time
from collections.abc import Callable, Collection
from dataclasses import replace

import numpy as np
from rclpy.serialization import serialize_message
from std_msgs.msg import String
from swarm_interfaces.msg import RobotStatus, Verdict
from visualization_msgs.msg import MarkerArray

from swarm_common.files.map_io import load_map, map_path
from swarm_common.middleware import ros_io
from swarm_common.middleware.cdr import ScanWriter, TransformsWriter
from swarm_common.middleware.topic_table import ROBOT_TOPICS, WORLD_TOPICS
from swarm_common.model.records import Scan
from swarm_describe.robots.loading import open_robot
from swarm_describe.worlds.reader import load_world
from swarm_sim.ros.viewing.scene_publisher import scene_markers
from swarm_view.state import topics
from swarm_view.state.topics import Layer

STATES = ("driving", "holding", "waiting", "yielding", "recovering", "idle")
PERIOD = 0.1  # [s] of a tick


class MovingFeed:
    """`count` robots in `slim_blockage`.

    Attributes:
        wanted: What somebody wants now.
        is_standing: Whether time stands still.
        collides_at: Tick from which on a collision is counted; None for never.
    """

    def __init__(
        self,
        count: int,
        models: Collection[str] = ("turtlebot3_waffle",),
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        """Prepare all that never changes."""
        self.names = [f"Srobot{i + 1}" for i in range(count)]
        self.wanted: set[str] = set()
        self.is_standing = False
        self.collides_at: int | None = None
        self._fresh: set[str] = set()
        scene = load_world("slim_blockage")
        self._urdfs = [open_robot(model).urdf for model in models]
        self._latched = {
            topics.SCENE: serialize_message(MarkerArray(markers=scene_markers(scene))),
            topics.MAP: serialize_message(ros_io.grid_msg(load_map(map_path(scene.name)), 0)),
        }
        self.let_be(self.names)
        self._clock = clock
        self._started = clock()
        self._tick = -1

    def let_be(self, names: list[str]) -> None:
        self.names = names
        self._writer = TransformsWriter("map", [f"{name}/base_footprint" for name in names])
        for i, name in enumerate(names):
            text = serialize_message(String(data=self._urdfs[i % len(self._urdfs)]))
            self._latched[f"/{name}/{topics.DESCRIPTION}"] = text

    def topics(self) -> dict[str, str]:
        """Return all topics."""
        robots = [
            replace(topic, name=f"/{name}/{topic.name}")
            for name in self.names
            for topic in ROBOT_TOPICS
        ]
        return {topic.name: topic.type for topic in (*WORLD_TOPICS, *robots)}

    def want(self, wanted: Collection[str]) -> None:
        self._fresh |= set(wanted) - self.wanted
        self.wanted = set(wanted)

    def take(self) -> list[tuple[str, bytes]]:
        """Return what is new."""
        taken = [(t, self._latched[t]) for t in self._fresh if t in self._latched]
        self._fresh.clear()
        tick = int((self._clock() - self._started) / PERIOD + 1e-6)
        if tick == self._tick or self.is_standing:
            return taken
        self._tick = tick
        if topics.TF in self.wanted:
            taken.append((topics.TF, self._writer.encode(tick, self.poses(tick))))
        for i, name in enumerate(self.names):
            if (tick + i) % 5 == 0 and f"/{name}/{topics.STATUS}" in self.wanted:
                taken.append((f"/{name}/{topics.STATUS}", self._status(i, tick)))
            if topics.of_layer(name, Layer.SCAN) in self.wanted:
                ranges = np.full(360, 1.5, np.float32)
                scan = Scan(tick, 0.0, math.radians(1.0), 0.12, 3.5, ranges)
                taken.append(
                    (topics.of_layer(name, Layer.SCAN), ScanWriter("base_scan", 0.2).encode(scan))
                )
        if topics.VERDICT in self.wanted and tick % 5 == 0:
            verdict = Verdict(stamp=ros_io.time_msg(tick), real_time_factor=1.0)
            verdict.robots = verdict.answering = len(self.names)
            verdict.min_clearance = 0.11
            has_collided = self.collides_at is not None and tick >= self.collides_at
            verdict.collisions_robot_robot = int(has_collided)
            taken.append((topics.VERDICT, serialize_message(verdict)))
        return taken

    def poses(self, tick: int) -> np.ndarray:
        """Return where everybody is at a tick."""
        columns = math.ceil(math.sqrt(len(self.names)))
        index = np.arange(len(self.names))
        phase = 0.05 * tick + index
        x = -6.0 + 12.0 * (index % columns) / max(1, columns - 1) + 0.3 * np.cos(phase)
        y = -3.5 + 11.0 * (index // columns) / max(1, columns - 1) + 0.3 * np.sin(phase)
        return np.column_stack([x, y, phase + 0.5 * math.pi])

    def _status(self, i: int, tick: int) -> bytes:
        x, y, yaw = self.poses(tick)[i]
        status = RobotStatus(stamp=ros_io.time_msg(tick), robot=self.names[i])
        status.state = STATES[i % len(STATES)]
        status.pose.x, status.pose.y, status.pose.theta = float(x), float(y), float(yaw)
        status.goal.x, status.goal.y, status.goal.theta = float(x) + 1.0, float(y), 0.0
        status.goals_reached = i
        status.station, status.queue_place = "loader_1", i
        return serialize_message(status)

    def close(self) -> None:
        """Nothing to release."""
