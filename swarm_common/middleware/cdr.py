"""CDR bytes of the messages sent every tick: odometry, scan, command.

A robot's tick would spend most of its middleware time on converting Python messages. These
writers keep one encoded message and patch the numbers that change; the readers look only at what
a navigator or the world needs. On the wire they are the ordinary ROS messages:
`tests/graph/middleware/test_cdr.py` compares them with the ROS serialiser. Strings may have any
length, so messages of third parties are read, too.
"""

from __future__ import annotations

import math
import struct
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from swarm_common.middleware.cdr_layout import (
    HEAD,
    LITTLE,
    STAMP,
    Layout,
    after_string,
    aligned,
    byte_order,
    read_stamp,
)
from swarm_common.middleware.rejections import RejectedError
from swarm_common.model.records import Odometry, Pose, Scan, Twist, stamp_from_tick, tick_from_stamp

LITTLE_ENDIAN = b"\x00\x01\x00\x00"
MOST_DISTANCE = 1e5  # [m] that any sensor of ours measures
MOST_SPEED = 1e3  # [m/s] and [rad/s], largest speed in a message or a command
MOST_RAYS = 100_000
MOST_TURN = 2.0 * math.tau  # [rad] that the rays of a scan span
COVARIANCE = struct.pack("<36d", *([0.0] * 36))


def encode_string(text: str) -> bytes:
    """Return the CDR string: length with the closing NUL, then the characters."""
    raw = text.encode() + b"\x00"
    return struct.pack("<I", len(raw)) + raw


def read_tick(data: bytes) -> int:
    """Return the control tick in the stamp of a message that starts with one."""
    return tick_from_stamp(*read_stamp(data))


def yaw_of(qx: float, qy: float, qz: float, qw: float) -> float:
    """Return the yaw, -π to π, of a unit quaternion."""
    return math.atan2(2.0 * (qw * qz + qx * qy), 1.0 - 2.0 * (qy * qy + qz * qz))


class OdometryWriter:
    """Encodes nav_msgs/Odometry with fixed frame ids."""

    _POSE = struct.Struct("<7d")
    _TWIST = struct.Struct("<6d")
    _DIAGONAL = (0, 7, 35)  # x, y, yaw in the 6 x 6 covariances
    _VARIANCE = struct.Struct("<d")

    def __init__(self, frame: str, child_frame: str) -> None:
        """Lay out the message; all variances are 0."""
        data = bytearray(LITTLE_ENDIAN + STAMP.pack(0, 0) + encode_string(frame))
        data += bytes(aligned(len(data), 4) - len(data)) + encode_string(child_frame)
        data += bytes(aligned(len(data), 8) - len(data))
        self._pose_at = len(data)
        self._twist_at = self._pose_at + self._POSE.size + len(COVARIANCE)
        data += bytes(self._POSE.size) + COVARIANCE + bytes(self._TWIST.size) + COVARIANCE
        self._data = data

    def set_variances(self, of_pose: Sequence[float], of_twist: Sequence[float]) -> None:
        """Let the next messages have these variances.

        Args:
            of_pose: Variances of x, y [m²] and yaw [rad²].
            of_twist: Variances of vx, vy [m²/s²] and wz [rad²/s²].
        """
        for at, variances in ((self._pose_at + 56, of_pose), (self._twist_at + 48, of_twist)):
            for place, variance in zip(self._DIAGONAL, variances, strict=True):
                self._VARIANCE.pack_into(self._data, at + 8 * place, variance)

    def encode(self, tick: int, pose: Pose, twist: Twist) -> bytes:
        """Return the message of one tick."""
        data = self._data
        STAMP.pack_into(data, HEAD, *stamp_from_tick(tick))
        half = 0.5 * pose.yaw
        self._POSE.pack_into(
            data, self._pose_at, pose.x, pose.y, 0.0, 0.0, 0.0, math.sin(half), math.cos(half)
        )
        self._TWIST.pack_into(data, self._twist_at, twist.vx, twist.vy, 0.0, 0.0, 0.0, twist.wz)
        return bytes(data)


class OdometryReader:
    """Reads the planar part of nav_msgs/Odometry."""

    def __init__(self, reach: float = MOST_DISTANCE) -> None:
        """Start without a message.

        Args:
            reach: [m] from its origin at which odometry may be.
        """
        self._layout = Layout(2, 8, "7d288x6d")
        self._reach = reach

    def read(self, data: bytes) -> Odometry:
        """Return the content of a message."""
        sec, nanosec, x, y, _, qx, qy, qz, qw, vx, vy, _, _, _, wz = self._layout.unpack(data)
        reach, speed = self._reach, MOST_SPEED
        if not (-reach <= x <= reach and -reach <= y <= reach):  # also of NaN
            raise RejectedError(f"the position is ({x}, {y}); expected at most {reach:g} m")
        if not (-speed <= vx <= speed and -speed <= vy <= speed and -speed <= wz <= speed):
            raise RejectedError(f"the twist is ({vx}, {vy}, {wz}); expected at most {speed:g}")
        if not 0.8 <= qx * qx + qy * qy + qz * qz + qw * qw <= 1.2:
            raise RejectedError(f"the quaternion is ({qx}, {qy}, {qz}, {qw}); expected length 1")
        pose = Pose(x, y, yaw_of(qx, qy, qz, qw))
        return Odometry(tick_from_stamp(sec, nanosec), pose, Twist(vx, vy, wz))


class CovariantPoseWriter:
    """Encodes geometry_msgs/PoseWithCovarianceStamped with a fixed frame id."""

    _POSE = struct.Struct("<7d")
    _DIAGONAL = (0, 7, 35)  # x, y, yaw in the 6 x 6 covariance

    def __init__(self, frame: str) -> None:
        """Lay out the message."""
        data = bytearray(LITTLE_ENDIAN + STAMP.pack(0, 0) + encode_string(frame))
        data += bytes(aligned(len(data), 8) - len(data))
        self._pose_at = len(data)
        self._data = data + bytes(self._POSE.size) + COVARIANCE

    def encode(self, tick: int, pose: Pose, variances: Sequence[float]) -> bytes:
        """Return the message of one tick."""
        data = self._data
        STAMP.pack_into(data, HEAD, *stamp_from_tick(tick))
        half = 0.5 * pose.yaw
        self._POSE.pack_into(
            data, self._pose_at, pose.x, pose.y, 0.0, 0.0, 0.0, math.sin(half), math.cos(half)
        )
        covariance_at = self._pose_at + self._POSE.size
        for place, variance in zip(self._DIAGONAL, variances, strict=True):
            struct.pack_into("<d", data, covariance_at + 8 * place, variance)
        return bytes(data)


class TransformsWriter:
    """Encodes tf2_msgs/TFMessage: one frame to many others, all in the plane."""

    def __init__(self, parent: str, children: Sequence[str]) -> None:
        """Lay out the message."""
        data = bytearray(LITTLE_ENDIAN + struct.pack("<I", len(children)))
        stamps, poses = [], []
        for child in children:
            data += bytes(aligned(len(data), 4) - len(data))
            stamps.append((len(data) - HEAD) // 4)
            data += STAMP.pack(0, 0) + encode_string(parent)
            data += bytes(aligned(len(data), 4) - len(data)) + encode_string(child)
            data += bytes(aligned(len(data), 8) - len(data))
            poses.append((len(data) - HEAD) // 8)
            data += bytes(7 * 8)
        self._stamps_at = np.array(stamps, np.intp)
        self._poses_at = np.array(poses, np.intp)[:, None] + np.arange(7)
        # CDR aligns relative to the byte after the head, so the body is kept apart from it.
        self._body = np.zeros(-(-(len(data) - HEAD) // 8), "<f8")
        self._size = len(data) - HEAD
        self._body.view(np.uint8)[: self._size] = np.frombuffer(data, np.uint8, offset=HEAD)

    def encode(self, tick: int, poses: NDArray[np.float64]) -> bytes:
        """Return the message of one tick.

        Args:
            poses: x, y, yaw (n, 3) [m, rad] of each child in the parent frame.
        """
        sec, nanosec = stamp_from_tick(tick)
        words = self._body.view("<u4")
        words[self._stamps_at], words[self._stamps_at + 1] = sec, nanosec
        values = np.zeros((len(poses), 7))
        values[:, :2] = poses[:, :2]
        values[:, 5], values[:, 6] = np.sin(0.5 * poses[:, 2]), np.cos(0.5 * poses[:, 2])
        self._body[self._poses_at] = values
        return LITTLE_ENDIAN + self._body.tobytes()[: self._size]


class TransformsReader:
    """Reads tf2_msgs/TFMessage; a message whose frames are those of the last one is read fast."""

    def __init__(self) -> None:
        self._children: list[str] = []
        self._poses_at: NDArray[np.intp] = np.zeros((0, 7), np.intp)
        self._fixed = np.zeros(0, np.uint8)  # bytes of the last message, without what changes
        self._fixed_at: NDArray[np.intp] = np.zeros(0, np.intp)
        self._size = 0
        self._stamp_at = 0

    def read(self, data: bytes) -> tuple[int, list[str], NDArray[np.float64]]:
        """Return (tick, child frames, their x, y, yaw (n, 3)) of a message."""
        if byte_order(data) != LITTLE or len(data) < HEAD + 4:
            raise RejectedError(f"{len(data)} bytes are no little-endian CDR")
        if not struct.unpack_from("<I", data, HEAD)[0]:
            return 0, [], np.zeros((0, 3))
        body = np.frombuffer(data, np.uint8, offset=HEAD)
        is_known = len(data) == self._size and bool((body[self._fixed_at] == self._fixed).all())
        if not is_known:
            self._learn(data, body)
        whole = len(body) // 8 * 8
        values = body[:whole].view("<f8")[self._poses_at]
        x, y, _, qx, qy, qz, qw = values.T
        yaws = np.arctan2(2.0 * (qw * qz + qx * qy), 1.0 - 2.0 * (qy * qy + qz * qz))
        tick = tick_from_stamp(*STAMP.unpack_from(data, self._stamp_at))
        return tick, self._children, np.column_stack([x, y, yaws])

    def _learn(self, data: bytes, body: NDArray[np.uint8]) -> None:
        """Find out where everything is."""
        (count,) = struct.unpack_from("<I", data, HEAD)
        if count * (STAMP.size + 7 * 8) > len(data):
            raise RejectedError(f"{len(data)} bytes are too few for {count} transforms")
        offset, poses, texts = HEAD + 4, [], []
        self._children = []
        for _ in range(count):
            stamp_at = aligned(offset, 4)
            self._stamp_at = stamp_at
            child_at = aligned(after_string(data, stamp_at + STAMP.size), 4)
            end = after_string(data, child_at)
            self._children.append(data[child_at + 4 : end - 1].decode())
            texts.append(np.arange(child_at, end) - HEAD)
            offset = aligned(end, 8)
            poses.append((offset - HEAD) // 8)
            offset += 7 * 8
        if offset > len(data):
            raise RejectedError(f"{len(data)} bytes are too few for {count} transforms")
        self._poses_at = np.array(poses, np.intp)[:, None] + np.arange(7)
        self._fixed_at = np.concatenate(texts)
        self._fixed = body[self._fixed_at].copy()
        self._size = len(data)


class ScanWriter:
    """Encodes sensor_msgs/LaserScan with a fixed frame id and rate."""

    def __init__(self, frame: str, scan_time: float) -> None:
        """Keep what never changes."""
        head = LITTLE_ENDIAN + STAMP.pack(0, 0) + encode_string(frame)
        self._head = bytearray(head + bytes(aligned(len(head), 4) - len(head)))
        self._scan_time = scan_time

    def encode(self, scan: Scan) -> bytes:
        """Return the message of one scan.

        Args:
            scan: Ranges and angles are written as they are, rounded to float32.
        """
        STAMP.pack_into(self._head, HEAD, *stamp_from_tick(scan.tick))
        count = len(scan.ranges)
        numbers = struct.pack(
            "<7fI",
            scan.angle_min,
            scan.angle_min + scan.angle_increment * (count - 1),
            scan.angle_increment,
            0.0,
            self._scan_time,
            scan.range_min,
            scan.range_max,
            count,
        )
        ranges = np.ascontiguousarray(scan.ranges, "<f4").tobytes()
        return bytes(self._head) + numbers + ranges + b"\x00\x00\x00\x00"


def read_scan(data: bytes) -> Scan:
    """Return a sensor_msgs/LaserScan message; the ranges are a copy.

    A view would be read-only, for which numba would compile every kernel once more. A range may be
    anything, as in the message's definition: only those within the LiDAR's limits count.
    """
    order = byte_order(data)
    tick = read_tick(data)
    offset = aligned(after_string(data, HEAD + STAMP.size, order), 4)
    try:
        numbers = struct.unpack_from(f"{order}7fI", data, offset)
    except struct.error as error:
        raise RejectedError(f"{len(data)} bytes are too few: {error}") from None
    angle_min, _, increment, _, _, low, high, count = numbers
    if not 1 <= count <= min(MOST_RAYS, (len(data) - offset - 32) // 4):
        raise RejectedError(f"{len(data)} bytes cannot hold {count} ranges, or are too many")
    if not (abs(angle_min) <= math.tau and 0.0 < abs(increment) * (count - 1 or 1) <= MOST_TURN):
        raise RejectedError(f"{count} rays from {angle_min} rad on, {increment} rad apart")
    if not 0.0 <= low < high <= MOST_DISTANCE:
        raise RejectedError(f"ranges from {low} to {high} m")
    ranges = np.frombuffer(data, f"{order}f4", count, offset + 32).astype(np.float32)
    return Scan(tick, angle_min, increment, low, high, ranges)


class CommandWriter:
    """Encodes geometry_msgs/TwistStamped with a fixed frame id."""

    _TWIST = struct.Struct("<6d")

    def __init__(self, frame: str) -> None:
        """Lay out the message."""
        data = bytearray(LITTLE_ENDIAN + STAMP.pack(0, 0) + encode_string(frame))
        data += bytes(aligned(len(data), 8) - len(data))
        self._twist_at = len(data)
        self._data = data + bytes(self._TWIST.size)

    def encode(self, tick: int, twist: Twist) -> bytes:
        """Return the command that answers a tick.

        Args:
            tick: Tick that is answered; the stamp of the command.
        """
        STAMP.pack_into(self._data, HEAD, *stamp_from_tick(tick))
        self._TWIST.pack_into(
            self._data, self._twist_at, twist.vx, twist.vy, 0.0, 0.0, 0.0, twist.wz
        )
        return bytes(self._data)


class CommandReader:
    """Reads geometry_msgs/TwistStamped."""

    def __init__(self) -> None:
        self._layout = Layout(1, 8, "6d")

    def read(self, data: bytes) -> tuple[int, Twist]:
        """Return (tick, twist) of a message."""
        sec, nanosec, vx, vy, _, _, _, wz = self._layout.unpack(data)
        return tick_from_stamp(sec, nanosec), _checked_twist(vx, vy, wz)


def read_plain_command(data: bytes) -> Twist:
    """Return the twist of a geometry_msgs/Twist message."""
    order = byte_order(data)
    if len(data) < HEAD + 6 * 8:
        raise RejectedError(f"{len(data)} bytes are too few for a twist")
    vx, vy, _, _, _, wz = struct.unpack_from(f"{order}6d", data, HEAD)
    return _checked_twist(vx, vy, wz)


def _checked_twist(vx: float, vy: float, wz: float) -> Twist:
    most = MOST_SPEED
    if not (-most <= vx <= most and -most <= vy <= most and -most <= wz <= most):  # also of NaN
        raise RejectedError(f"the twist is ({vx}, {vy}, {wz}); expected at most {most:g}")
    return Twist(vx, vy, wz)
