"""Frames of a robot for its viewers: what robot_state_publisher would send."""

from __future__ import annotations

import math
import xml.etree.ElementTree as ET
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from geometry_msgs.msg import TransformStamped

from swarm_common.middleware.ros_io import transform_msg
from swarm_common.model.records import FloatArray

Quaternion = tuple[float, float, float, float]  # x, y, z, w


@dataclass(frozen=True, slots=True)
class Joint:
    """A joint of a URDF: parent ← child at position zero."""

    name: str
    parent: str
    child: str
    xyz: FloatArray
    quaternion: Quaternion
    axis: FloatArray
    is_fixed: bool
    is_sliding: bool


def read_joints(urdf: str) -> list[Joint]:
    """Return the joints of a URDF text that `robot_model` has accepted."""
    return [_joint(element) for element in ET.fromstring(urdf).findall("joint")]


def _joint(element: ET.Element) -> Joint:
    origin, axis = element.find("origin"), element.find("axis")
    return Joint(
        name=element.get("name", ""),
        parent=_link(element, "parent"),
        child=_link(element, "child"),
        xyz=_numbers(None if origin is None else origin.get("xyz"), "0 0 0"),
        quaternion=from_rpy(_numbers(None if origin is None else origin.get("rpy"), "0 0 0")),
        axis=_numbers(None if axis is None else axis.get("xyz"), "1 0 0"),
        is_fixed=element.get("type") == "fixed",
        is_sliding=element.get("type") == "prismatic",
    )


def _link(element: ET.Element, tag: str) -> str:
    child = element.find(tag)
    return "" if child is None else child.get("link", "")


def _numbers(text: str | None, default: str) -> FloatArray:
    return np.array([float(word) for word in (text or default).split()])


def from_rpy(rpy: Sequence[float] | FloatArray) -> Quaternion:
    """Return the quaternion of URDF's roll, pitch, yaw."""
    (sr, cr), (sp, cp), (sy, cy) = ((math.sin(0.5 * a), math.cos(0.5 * a)) for a in rpy)
    return (
        sr * cp * cy - cr * sp * sy,
        cr * sp * cy + sr * cp * sy,
        cr * cp * sy - sr * sp * cy,
        cr * cp * cy + sr * sp * sy,
    )


def product(a: Quaternion, b: Quaternion) -> Quaternion:
    """Return the quaternion a ∘ b."""
    ax, ay, az, aw = a
    bx, by, bz, bw = b
    return (
        aw * bx + ax * bw + ay * bz - az * by,
        aw * by - ax * bz + ay * bw + az * bx,
        aw * bz + ax * by - ay * bx + az * bw,
        aw * bw - ax * bx - ay * by - az * bz,
    )


def fixed_transforms(joints: Sequence[Joint]) -> list[TransformStamped]:
    """Return the transforms for tf_static."""
    return [
        transform_msg(joint.parent, joint.child, joint.xyz, joint.quaternion, 0)
        for joint in joints
        if joint.is_fixed
    ]


def moving_transforms(
    joints: Sequence[Joint], positions: Mapping[str, float], tick: int
) -> list[TransformStamped]:
    """Return the transforms of the joints that move; unknown positions count as zero.

    Args:
        positions: [rad] or [m] by name of the joint.
    """
    return [
        _moved(joint, positions.get(joint.name, 0.0), tick)
        for joint in joints
        if not joint.is_fixed
    ]


def _moved(joint: Joint, position: float, tick: int) -> TransformStamped:
    if joint.is_sliding:
        xyz = joint.xyz + rotated(joint.quaternion, joint.axis * position)
        return transform_msg(joint.parent, joint.child, xyz, joint.quaternion, tick)
    x, y, z = math.sin(0.5 * position) * joint.axis
    turn = product(joint.quaternion, (float(x), float(y), float(z), math.cos(0.5 * position)))
    return transform_msg(joint.parent, joint.child, joint.xyz, turn, tick)


def rotated(quaternion: Quaternion, vector: FloatArray) -> FloatArray:
    """Return the vector turned by a unit quaternion."""
    axis, w = np.array(quaternion[:3]), quaternion[3]
    cross = 2.0 * np.cross(axis, vector)
    return vector + w * cross + np.cross(axis, cross)
