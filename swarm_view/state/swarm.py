"""The state of the swarm while a page is open: messages update it, the view reads it."""

from __future__ import annotations

import contextlib
import struct
from collections.abc import Callable, Iterable
from typing import Any

import numpy as np
from visualization_msgs.msg import Marker

from swarm_common.middleware import cdr
from swarm_common.middleware.ros_io import tick_of
from swarm_common.model.records import CONTROL_PERIOD, FloatArray, Pose
from swarm_view.state import decode, topics
from swarm_view.state.decode import Raster, ReportedState
from swarm_view.state.history import History
from swarm_view.state.topics import Layer
from swarm_view.state.track import Track, Trails

# What bytes raise that are not the message they should be, in our readers and in rclpy's.
UNREADABLE = (ValueError, IndexError, OverflowError, RuntimeError, struct.error)
HISTORY = 40  # ticks for which poses are kept, to place scans
DECODERS: dict[Layer, Callable[[Any], Any]] = {
    Layer.PLAN: lambda message: decode.places(message.poses),
    Layer.LOCAL_PLAN: lambda message: decode.places(message.poses),
    Layer.LOCAL_COSTMAP: decode.raster,
    Layer.GLOBAL_COSTMAP: decode.raster,
    Layer.FOOTPRINT: decode.polygon,
    Layer.PARTICLES: lambda message: decode.places(message.particles),
}


class Swarm:
    """The swarm's state according to the messages so far.

    Attributes:
        names: Robots in the order of all arrays.
        descriptions: URDF by robot.
        markers: Bodies of the scene; None before it is known.
        stations: Places (3,) of their labels in map, by name.
        layout: Nodes and ends of edges (n, 2) in map of a fleet control's layout.
        movers: Markers of the other moving bodies.
        verdict: swarm_interfaces/Verdict; None before the first.
        revision: Grows whenever scene, map, names or descriptions change.
        state_revision: Grows with every status.
    """

    def __init__(self) -> None:
        self.names: list[str] = []
        self.states: dict[str, ReportedState] = {}
        self.descriptions: dict[str, str] = {}
        self.track = Track()
        self.trails = Trails()
        self.markers: list[Any] | None = None
        self.stations: dict[str, FloatArray] = {}
        self.layout: tuple[FloatArray, FloatArray] = np.zeros((0, 2)), np.zeros((0, 2))
        self.movers: list[Any] = []
        self.map: Raster | None = None
        self.verdict: Any = None
        self.tick = 0
        self.revision = 0
        self.state_revision = 0
        self._layers: dict[str, tuple[int, bytes]] = {}
        self._decoded: dict[str, tuple[int, Any]] = {}
        self.unreadable = 0  # messages of which no sense could be made: they are not drawn
        self._history: dict[int, FloatArray] = {}
        self._places: dict[str, Pose] = {}  # of statuses, where there is no ground truth
        self._has_truth = False
        self.history: History | None = None  # told of all that comes; None in a recording
        self._reader = cdr.TransformsReader()
        self._frames: list[str] = []

    @property
    def time(self) -> float:
        """Simulated time [s]."""
        return self.tick * CONTROL_PERIOD

    def meet(self, robots: list[str]) -> None:
        """Update the list of robots."""
        if robots != self.names and not self._has_truth:
            self._rename(robots)

    def _rename(self, names: list[str]) -> None:
        """Continue with another list of robots; forget robots that are not in it."""
        known = {name: row for row, name in enumerate(self.names)}
        self.trails.rearrange([known.get(name, -1) for name in names])
        self._history.clear()  # its rows are those of the robots before
        for name in known.keys() - set(names):
            for memory in (self.states, self.descriptions, self._places):
                memory.pop(name, None)
        self.names = names
        self.revision += 1
        self.state_revision += 1

    def forget_past(self) -> None:
        """Forget what belongs to a time before; done when a recording is wound."""
        self.trails.clear()
        self._history.clear()
        self._layers.clear()
        self._decoded.clear()
        self.states.clear()
        self.state_revision += 1
        self.tick = 0

    def index(self, robot: str) -> int | None:
        """Return a robot's place in the arrays."""
        return self.names.index(robot) if robot in self.names else None

    def apply(self, taken: list[tuple[str, bytes]], now: float) -> None:
        """Apply messages in their order; `now` is wall time."""
        newest = {topic: data for topic, data in taken if topic == topics.TF}
        for topic, data in taken:
            if topic == topics.TF and newest[topic] is not data:
                continue  # at high speed there are more than can be drawn
            try:
                self._apply(topic, data, now)
            except UNREADABLE:
                self.unreadable += 1

    def _apply(self, topic: str, data: bytes, now: float) -> None:
        if topic == topics.TF:
            self._receive_poses(data, now)
        elif topic == topics.VERDICT:
            self.verdict = decode.message(topic, data)
            if self.history is not None:
                self.history.add_verdict(self.verdict)
            self.tick = max(self.tick, tick_of(self.verdict.stamp))
        elif topic == topics.MOVERS:
            self.movers = decode.message(topic, data).markers
        elif topic == topics.SCENE:
            self.markers = decode.message(topic, data).markers
            self.stations = decode.station_places(self.markers)
            read = decode.layout_points
            self.layout = read(self.markers, Marker.POINTS), read(self.markers, Marker.LINE_LIST)
            self.revision += 1
        elif topic == topics.MAP:
            self.map = decode.raster(decode.message(topic, data))
            self.revision += 1
        else:
            self._receive_of_robot(topic, data, now)

    def _receive_of_robot(self, topic: str, data: bytes, now: float) -> None:
        robot, rest = topics.split(topic)
        if rest == topics.STATUS:
            if self._has_truth and robot not in self.names:
                return  # the last word of one that was taken out
            state = decode.robot_state(data)
            self.states[robot] = state
            if self.history is not None:
                self.history.add_status(robot, state)
            self.state_revision += 1
            if not self._has_truth:
                self._receive_place(robot, state.pose_map, now)
        elif rest == topics.DESCRIPTION:
            self.descriptions[robot] = decode.message(topic, data).data
            self.revision += 1
        else:
            version = self._layers.get(topic, (0, b""))[0]
            self._layers[topic] = (version + 1, data)

    def _receive_poses(self, data: bytes, now: float) -> None:
        tick, frames, array = self._reader.read(data)
        if frames != self._frames:
            self._frames = frames
            self._rename([frame.rpartition("/")[0] for frame in frames])
        self._has_truth = True
        self.tick = max(self.tick, tick)
        self._history[tick] = array
        if len(self._history) > HISTORY:
            del self._history[min(self._history)]
        self.track.add(array, now)
        self.trails.add(array)
        if self.history is not None:
            self.history.add_poses(tick, self.names, array)

    def _receive_place(self, robot: str, pose: Pose, now: float) -> None:
        self._places[robot] = pose
        if all(name in self._places for name in self.names):
            places = [self._places[name] for name in self.names]
            array = np.array([(p.x, p.y, p.yaw) for p in places]).reshape(-1, 3)
            self.track.add(array, now)
            self.trails.add(array)

    def pose_at(self, robot: str, tick: int) -> FloatArray | None:
        """Return the pose (3,) of a robot at a tick, or the newest one."""
        index = self.index(robot)
        poses = self._history.get(tick, self.track.latest)
        return None if index is None or index >= len(poses) else poses[index]

    def true_pose(self, robot: str, tick: int) -> FloatArray | None:
        """Return where a robot really was (3,) at a tick; None if that is not known."""
        index, poses = self.index(robot), self._history.get(tick)
        return None if index is None or poses is None else poses[index]

    def layer(self, robot: str, layer: Layer) -> tuple[int, Any]:
        """Return (version, what there is to draw) of a robot's layer; version 0 is nothing."""
        topic = topics.of_layer(robot, layer)
        version, data = self._layers.get(topic, (0, b""))
        if version == 0:
            return 0, None
        known = self._decoded.get(topic)
        if known is not None and known[0] == version:
            return known
        try:
            self._decoded[topic] = version, _decode(topic, layer, data)
        except UNREADABLE:
            self.unreadable += 1
            self._decoded[topic] = known or (0, None)
        return self._decoded[topic]

    def drop_layers(self, wanted: set[str]) -> None:
        """Forget layers that no page shows any more, so that no outdated layer is shown later."""
        for topic in self._layers.keys() - wanted:
            del self._layers[topic]
            self._decoded.pop(topic, None)


def history_of(messages: Iterable[tuple[str, bytes]], period: float) -> History:
    """Return what happened by messages in their order, with poses `period` [s] apart."""
    swarm = Swarm()
    swarm.history = History(period)
    for topic, data in messages:
        with contextlib.suppress(*UNREADABLE):
            swarm._apply(topic, data, 0.0)
    return swarm.history


def _decode(topic: str, layer: Layer, data: bytes) -> Any:
    if layer is Layer.SCAN:
        return cdr.read_scan(data)
    if layer is Layer.MOTION:
        return decode.motion(data)
    return DECODERS[layer](decode.message(topic, data))
