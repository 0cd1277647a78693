"""Every ROS message that is not sent each tick, to and from our records; and the QoS profiles.

The messages of the tick itself (odom, scan, cmd_vel, beacon, neighbors) travel as bytes, see
`cdr` and `beacon`.
"""

from __future__ import annotations

import array
import hashlib
import math
from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np
from builtin_interfaces.msg import Time
from geometry_msgs.msg import Point32, PoseStamped, TransformStamped
from geometry_msgs.msg import Pose as PoseMsg
from nav_msgs.msg import OccupancyGrid, Path
from numpy.typing import NDArray
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from rclpy.serialization import deserialize_message
from sensor_msgs.msg import BatteryState
from std_msgs.msg import Header

from swarm_common.files.map_io import MAX_PLACE, MAX_RESOLUTION, MIN_RESOLUTION
from swarm_common.middleware.cdr import yaw_of
from swarm_common.middleware.rejections import RejectedError
from swarm_common.model.battery import BatteryReading, BatterySpec, SupplyStatus
from swarm_common.model.grid import Grid
from swarm_common.model.records import FloatArray, Pose, stamp_from_tick, tick_from_stamp

RESOURCES = ("entity_resource", "world_resource")
BATTERY = "battery_state"  # topic
MOST_CELLS = 100_000_000  # of a map
RELIABLE = QoSProfile(depth=10)
LATEST = QoSProfile(depth=1)
# For complete states that are sent repeatedly. A reliable topic would hold back what comes after
# a lost message until that is there, seconds later, although nobody needs it any more.
NEWEST = QoSProfile(depth=1, reliability=ReliabilityPolicy.BEST_EFFORT)
SENSOR = QoSProfile(depth=5, reliability=ReliabilityPolicy.BEST_EFFORT)
SCAN = QoSProfile(depth=5)  # reliable, which serves subscribers of both kinds
LATCHED = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
# What one tick needs is repeated until it is answered, so its readers ask for no acknowledgement.
# The queue is deep because messages of foreign publishers wait in it, too.
TICK_INPUT = QoSProfile(depth=200, reliability=ReliabilityPolicy.BEST_EFFORT)
STATIC_TRANSFORMS = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
TRANSFORMS = QoSProfile(depth=100)
START, MOST_DIGITS = "start_at_tick ", 12  # of a goal that begins later
ANY_HEADING = "any_heading"  # `behavior_tree` of a goal whose last pose is one of position only
BACKWARDS = "backwards"  # `controller_id` of a path that is driven backwards


def time_msg(tick: int) -> Time:
    """Return the stamp of a control tick."""
    sec, nanosec = stamp_from_tick(tick)
    return Time(sec=sec, nanosec=nanosec)


def tick_of(stamp: Time) -> int:
    """Return the control tick nearest to a stamp."""
    return tick_from_stamp(stamp.sec, stamp.nanosec)


def start_text(tick: int) -> str:
    """Return the `behavior_tree` of a goal that is to begin at a tick, not at once.

    Args:
        tick: 0 for at once.
    """
    return f"{START}{tick}" if tick else ""


def start_in(behavior_tree: str) -> int:
    """Return the tick at which a goal is to begin, from its `behavior_tree`; 0 for at once.

    Args:
        behavior_tree: From a client; a file of Nav2's, or any other text, means at once.

    Raises:
        RejectedError: If it names a start that is no tick.
    """
    words = behavior_tree.split()
    if words[:1] != [START.strip()]:
        return 0
    digits = words[1] if len(words) == 2 else ""
    if not (digits.isascii() and digits.isdigit()) or len(digits) > MOST_DIGITS:
        raise RejectedError(
            f"behavior_tree is '{behavior_tree[:60]}'; expected {START.strip()} and the number of a"
            " control tick, ten a second"
        )
    return int(digits)


def header(tick: int, frame: str) -> Header:
    """Return a header."""
    return Header(stamp=time_msg(tick), frame_id=frame)


def pose_msg(pose: Pose) -> PoseMsg:
    """Return a planar pose as geometry_msgs/Pose."""
    message = PoseMsg()
    message.position.x = float(pose.x)
    message.position.y = float(pose.y)
    message.orientation.z = math.sin(0.5 * pose.yaw)
    message.orientation.w = math.cos(0.5 * pose.yaw)
    return message


def pose_from_msg(message: PoseMsg) -> Pose:
    """Return the planar part of a pose; an all-zero quaternion counts as yaw 0, as in Nav2.

    Raises:
        ValueError: If a number is not finite or the quaternion is not of unit length.
    """
    q = message.orientation
    numbers = (message.position.x, message.position.y, q.x, q.y, q.z, q.w)
    if not all(math.isfinite(number) for number in numbers):
        raise ValueError("the pose has a number that is not finite")
    norm = math.hypot(q.x, q.y, q.z, q.w)
    if norm == 0.0:
        return Pose(message.position.x, message.position.y, 0.0)
    if abs(norm - 1.0) > 0.1:
        raise ValueError(f"the quaternion has length {norm:.3f}; it must be 1")
    return Pose(message.position.x, message.position.y, yaw_of(q.x, q.y, q.z, q.w))


def pose_stamped(pose: Pose, tick: int) -> PoseStamped:
    """Return geometry_msgs/PoseStamped in map."""
    return PoseStamped(header=header(tick, "map"), pose=pose_msg(pose))


def path_msg(points_map: FloatArray, tick: int) -> Path:
    """Return nav_msgs/Path of points (n, 2) or (n, 3); without a yaw it follows the path."""
    message = Path(header=header(tick, "map"))
    if len(points_map) == 0:
        return message
    yaws = points_map[:, 2] if points_map.shape[1] > 2 else path_yaws(points_map)
    head = message.header
    message.poses = [
        PoseStamped(header=head, pose=pose_msg(Pose(float(x), float(y), float(yaw))))
        for (x, y), yaw in zip(points_map[:, :2], yaws, strict=True)
    ]
    return message


def path_yaws(points_map: FloatArray) -> FloatArray:
    """Return the direction at each point of a polyline (n, 2).

    Args:
        points_map: In any frame; columns behind x and y do not count.

    Returns:
        (n,) [rad]; the last point has the direction of the one before, a single point 0.
    """
    if len(points_map) < 2:
        return np.zeros(len(points_map))
    steps = np.diff(points_map[:, :2], axis=0)
    yaws = np.arctan2(steps[:, 1], steps[:, 0])
    return np.append(yaws, yaws[-1])


def grid_msg(grid: Grid, tick: int) -> OccupancyGrid:
    """Return the map as nav_msgs/OccupancyGrid."""
    origin = (grid.origin_x, grid.origin_y)
    message = occupancy_msg(grid.cells, grid.resolution, origin, tick, "map")
    message.info.origin = pose_msg(Pose(*origin, grid.origin_yaw))
    return message


def occupancy_msg(
    cells: NDArray[np.int8], resolution: float, origin: tuple[float, float], tick: int, frame: str
) -> OccupancyGrid:
    """Return nav_msgs/OccupancyGrid of cells (height, width).

    Args:
        cells: Rows from the origin upwards; -1 unknown, else 0 to 100.
        origin: x, y [m] of the lower left corner in the frame.
    """
    message = OccupancyGrid(header=header(tick, frame))
    message.info.map_load_time = message.header.stamp
    message.info.resolution = float(resolution)
    message.info.height, message.info.width = cells.shape
    message.info.origin = pose_msg(Pose(origin[0], origin[1], 0.0))
    message.data = array.array("b", np.ascontiguousarray(cells, np.int8).tobytes())
    return message


def grid_from_msg(message: OccupancyGrid) -> Grid:
    """Return the map in an OccupancyGrid."""
    info = message.info
    # float32 on the wire: 0.05 arrives as 0.0500000007
    resolution = round(float(info.resolution), 6)
    cells = np.frombuffer(message.data, np.int8)
    if len(cells) != info.width * info.height or not 0 < len(cells) <= MOST_CELLS:
        raise RejectedError(
            f"the map of {info.width} x {info.height} cells carries {len(cells)} values; it may"
            f" have {MOST_CELLS}"
        )
    if not MIN_RESOLUTION <= resolution <= MAX_RESOLUTION:
        raise RejectedError(f"the map has a resolution of {resolution} m per cell")
    try:
        origin = pose_from_msg(info.origin)
    except ValueError as error:
        raise RejectedError(f"the map's origin: {error}") from None
    if max(abs(origin.x), abs(origin.y)) > MAX_PLACE:
        raise RejectedError(f"the map's origin is ({origin.x}, {origin.y})")
    yaw = origin.yaw if abs(origin.yaw) > 1e-6 else 0.0
    return Grid(cells.reshape(info.height, info.width).copy(), resolution, origin.x, origin.y, yaw)


def unpacked(data: bytes, kind: Any) -> Any:
    """Return the message of a type in CDR bytes."""
    try:
        return deserialize_message(data, kind)
    except (RuntimeError, ValueError, MemoryError, SystemError) as error:
        text = str(error) or type(error).__name__
        raise RejectedError(f"{len(data)} bytes are no {kind.__name__}: {text}") from None


def message_digest(message: OccupancyGrid) -> str:
    """Return the SHA-256 of what a map says: its geometry and its cells.

    Args:
        message: The map; its stamps do not count.
    """
    info, origin = message.info, message.info.origin
    q = origin.orientation
    resolution = float(np.float32(info.resolution))  # as on the wire
    numbers = (resolution, origin.position.x, origin.position.y, q.x, q.y, q.z, q.w)
    digest = hashlib.sha256(repr((info.width, info.height, *numbers)).encode())
    digest.update(message.data)
    return digest.hexdigest()


def map_digest(grid: Grid) -> str:
    """Return the digest of the message that brings a map to the robots."""
    return message_digest(grid_msg(grid, 0))


def _nav2_scale() -> NDArray[np.int8]:
    table = np.zeros(256, np.int8)
    costs = np.arange(1, 253)
    table[1:253] = 1 + (97 * (costs - 1)) // 251
    table[253], table[254], table[255] = 99, 100, -1
    return table


OCCUPANCY_FROM_COST = _nav2_scale()


def points32(points: Iterable[Sequence[float]]) -> list[Point32]:
    """Return points of a polygon."""
    return [Point32(x=float(x), y=float(y)) for x, y in points]


def transform_msg(
    parent: str,
    child: str,
    xyz: Sequence[float] | FloatArray,
    quaternion: Sequence[float],
    tick: int,
) -> TransformStamped:
    """Return parent ← child as geometry_msgs/TransformStamped.

    Args:
        quaternion: x, y, z, w, of length 1.
    """
    message = TransformStamped(header=header(tick, parent), child_frame_id=child)
    move, turn = message.transform.translation, message.transform.rotation
    move.x, move.y, move.z = (float(value) for value in xyz)
    turn.x, turn.y, turn.z, turn.w = (float(value) for value in quaternion)
    return message


def planar_transform(parent: str, child: str, pose: Pose, tick: int) -> TransformStamped:
    """Return parent ← child for a planar pose."""
    half = 0.5 * pose.yaw
    turn = (0.0, 0.0, math.sin(half), math.cos(half))
    return transform_msg(parent, child, (pose.x, pose.y, 0.0), turn, tick)


def battery_message(reading: BatteryReading, battery: BatterySpec) -> BatteryState:
    """Return the message of a reading; charges are in Ah at the battery's voltage."""
    capacity = battery.capacity / battery.voltage
    message = BatteryState(header=header(reading.tick, ""), present=True)
    message.voltage = battery.voltage
    message.temperature = math.nan
    message.current = reading.power / battery.voltage
    message.charge = reading.share * capacity
    message.capacity = message.design_capacity = capacity
    message.percentage = reading.share
    message.power_supply_status = int(reading.status)
    message.power_supply_health = BatteryState.POWER_SUPPLY_HEALTH_GOOD
    return message


def read_battery(data: bytes) -> BatteryReading:
    """Return the reading in a message."""
    message = unpacked(data, BatteryState)
    share = float(message.percentage)
    if not 0.0 <= share <= 1.0:
        raise RejectedError(f"percentage is {share:g}; expected 0 to 1")
    status = int(message.power_supply_status)
    is_known = status in (SupplyStatus.CHARGING, SupplyStatus.FULL)
    return BatteryReading(
        tick=tick_from_stamp(message.header.stamp.sec, message.header.stamp.nanosec),
        share=share,
        power=float(message.current) * float(message.voltage),
        status=SupplyStatus(status) if is_known else SupplyStatus.DISCHARGING,
    )


def resource_in(message: Any) -> Any:
    """Return the part of a message that has `uri`: a field, or in 1.x often the message itself."""
    return next((getattr(message, name) for name in RESOURCES if hasattr(message, name)), message)
