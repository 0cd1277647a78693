"""CDR messages to what the view draws: arrays in the map frame."""

from __future__ import annotations

import math
import struct
from dataclasses import dataclass
from functools import lru_cache
from importlib import import_module
from typing import Any

import numpy as np
from numpy.typing import NDArray
from rclpy.serialization import deserialize_message
from visualization_msgs.msg import Marker

from swarm_common.middleware import cdr, cdr_layout
from swarm_common.model.beacon import deserialize_beacon
from swarm_common.model.palette import BUSY_STATES
from swarm_common.model.records import FloatArray, Pose, Scan
from swarm_view.state.topics import type_of


@dataclass(frozen=True, slots=True)
class Raster:
    """An occupancy grid: int8 cells (height, width), row 0 at the lowest y."""

    cells: NDArray[np.int8]
    resolution: float
    origin: tuple[float, float]  # lower left corner in map

    @property
    def size(self) -> tuple[float, float]:
        """Width and height [m]."""
        height, width = self.cells.shape
        return width * self.resolution, height * self.resolution

    @property
    def center(self) -> tuple[float, float]:
        """Its middle in map."""
        width, height = self.size
        return self.origin[0] + 0.5 * width, self.origin[1] + 0.5 * height


@dataclass(frozen=True, slots=True)
class CommittedMotion:
    """Committed motion of a robot: polylines (n, 2) [m] in map."""

    held: FloatArray
    wanted: FloatArray
    intent: FloatArray


@dataclass(frozen=True, slots=True)
class ReportedState:
    """The latest status of a robot."""

    tick: int
    state: str
    detail: str
    pose_map: Pose  # estimated by the robot itself
    goal_map: Pose | None
    station: str
    queue_place: int
    distance_remaining: float
    hold_time: float
    wait_time: float
    goals_reached: int
    goals_failed: int
    battery: float = math.nan  # charge by capacity; NaN without a battery


@lru_cache(maxsize=64)
def message_class(kind: str) -> Any:
    """Return the class of a type like `nav_msgs/msg/Path`."""
    package, space, name = kind.split("/")
    return getattr(import_module(f"{package}.{space}"), name)


def message(topic: str, data: bytes) -> Any:
    """Return the ROS message of a topic that the view reads."""
    return deserialize_message(data, message_class(type_of(topic)))


def raster(grid: Any) -> Raster:
    """Return nav_msgs/OccupancyGrid."""
    info = grid.info
    cells = np.frombuffer(grid.data, np.int8).reshape(info.height, info.width)
    return Raster(cells, float(info.resolution), (info.origin.position.x, info.origin.position.y))


def station_places(markers: list[Any]) -> dict[str, FloatArray]:
    """Return the places (3,) in map of the names among the scene's markers."""
    named = {m.text: m.pose.position for m in markers if m.type == Marker.TEXT_VIEW_FACING}
    return {str(name): np.array([place.x, place.y, place.z]) for name, place in named.items()}


def layout_points(markers: list[Any], kind: int) -> FloatArray:
    """Return points (n, 2) in map of a fleet control's layout.

    Args:
        markers: All markers of the scene, of any kind.
        kind: `Marker.POINTS` for its nodes; `Marker.LINE_LIST` for its edges, two points each.
    """
    points = [(p.x, p.y) for m in markers if m.type == kind for p in m.points]
    return np.array(points, np.float64).reshape(-1, 2)


def places(stamped: Any) -> FloatArray:
    """Return the places (n, 2) of messages with a pose, of a path or a cloud of particles."""
    points = [(p.pose.position.x, p.pose.position.y) for p in stamped]
    return np.array(points, np.float64).reshape(-1, 2)


def polygon(message: Any) -> FloatArray:
    """Return the corners (n, 2) of geometry_msgs/PolygonStamped."""
    return np.array([(p.x, p.y) for p in message.polygon.points], np.float64).reshape(-1, 2)


def motion(data: bytes) -> CommittedMotion:
    """Return what a swarm_interfaces/Beacon claims."""
    beacon = deserialize_beacon(data)
    held, wanted, intent = (
        beacon[name][: int(beacon[f"{name}_size"])].astype(np.float64)
        for name in ("held", "wanted", "intent")
    )
    return CommittedMotion(held, wanted, intent)


def scan_points(scan: Scan) -> FloatArray:
    """Return where the rays ended (n, 2) in base_scan; rays that hit nothing are left out."""
    hits = np.flatnonzero((scan.ranges >= scan.range_min) & (scan.ranges <= scan.range_max))
    angles = scan.angle_min + scan.angle_increment * hits
    ranges = scan.ranges[hits].astype(np.float64)
    return np.column_stack([ranges * np.cos(angles), ranges * np.sin(angles)])


_POSES = struct.Struct("<6d")
_NUMBERS = struct.Struct("<I2fiI2f3I")
_BATTERY = struct.Struct("<16xf")  # behind them: counts of no use here come first


def robot_state(data: bytes) -> ReportedState:
    """Return swarm_interfaces/RobotStatus; taken apart here, as many come every second."""
    texts, offset = [], cdr_layout.HEAD + cdr_layout.STAMP.size
    for _ in range(3):  # robot, state, detail
        text, offset = _string(data, offset)
        texts.append(text)
    offset = cdr_layout.aligned(offset, 8)
    x, y, yaw, goal_x, goal_y, goal_yaw = _POSES.unpack_from(data, offset)
    station, offset = _string(data, offset + _POSES.size)
    offset = cdr_layout.aligned(offset, 4)
    numbers = _NUMBERS.unpack_from(data, offset)
    offset += _NUMBERS.size
    has_battery = len(data) >= offset + _BATTERY.size  # recordings of earlier releases end here
    (battery,) = _BATTERY.unpack_from(data, offset) if has_battery else (math.nan,)
    queue_place, remaining, _, _, _, hold_time, wait_time, _, reached, failed = numbers
    is_under_way = math.isfinite(goal_x) and texts[1] not in BUSY_STATES
    return ReportedState(
        tick=cdr.read_tick(data),
        state=texts[1],
        detail=texts[2],
        pose_map=Pose(x, y, yaw),
        goal_map=Pose(goal_x, goal_y, goal_yaw) if is_under_way else None,
        station=station,
        queue_place=queue_place,
        distance_remaining=remaining,
        hold_time=hold_time,
        wait_time=wait_time,
        goals_reached=reached,
        goals_failed=failed,
        battery=battery,
    )


def _string(data: bytes, offset: int) -> tuple[str, int]:
    """Return the CDR string that starts at `offset` (4-aligned), and the offset behind it."""
    offset = cdr_layout.aligned(offset, 4)
    end = cdr_layout.after_string(data, offset)
    return data[offset + 4 : end - 1].decode(), end
