"""Numbers, poses and colours in elements, checked as they are read."""

from __future__ import annotations

import math
import re
import xml.etree.ElementTree as ET

import numpy as np

from swarm_common.model.errors import DescriptionError
from swarm_common.model.shapes import Color, Transform, rotation_of, transform_from_xyz_rpy

MIN_SIZE = 1e-5  # [m] of a shape; smaller ones are a slip of the unit
MAX_SIZE = 10_000.0  # [m] of a shape
MAX_PLACE = 100_000.0  # [m] from the origin of whatever a pose refers to
NUMBER = re.compile(r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?", re.ASCII)
TRUE_WORDS = ("true", "1")


def text_of(element: ET.Element, tag: str, default: str = "") -> str:
    """Return the text of a child, or the default.

    Args:
        tag: May be a path like `submesh/name`.
    """
    return (element.findtext(tag) or default).strip()


def flag_of(element: ET.Element, tag: str) -> bool:
    """Return whether a child says true."""
    return text_of(element, tag).lower() in TRUE_WORDS


def floats_of(element: ET.Element | None, count: int, default: str, where: str) -> list[float]:
    """Return the numbers in an element's text."""
    text = default if element is None else (element.text or "")
    values = [value for word in text.split() for value in _values_in(word)]
    if len(values) != count or not all(math.isfinite(value) for value in values):
        tag = "" if element is None else element.tag
        raise DescriptionError(f"<{tag}> of {where} is '{text.strip()}'; expected {count} numbers")
    return values


def _values_in(word: str) -> list[float]:
    """Return the numbers in a word; a sign begins a new one, as where Gazebo reads `41.7-0.2`."""
    parts = NUMBER.findall(word)
    if "".join(parts) != word or any(part[0] not in "+-" for part in parts[1:]):
        return [math.nan]
    return [float(part) for part in parts]


def number_in(
    element: ET.Element, path: str, where: str, *, is_finite: bool = False
) -> float | None:
    """Return the number in the text of a child; None without a child, or without text in it."""
    text = element.findtext(path)
    if text is None or not text.strip():
        return None
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if math.isnan(value) or (is_finite and math.isinf(value)):
        raise DescriptionError(f"{where}: <{path}> is '{text.strip()}'; expected a number")
    return value


def sizes_of(element: ET.Element, tag: str, count: int, where: str) -> list[float]:
    """Return the lengths [m] in a child, which must be there."""
    child = element.find(tag)
    if child is None:
        raise DescriptionError(f"<{element.tag}> of {where} has no <{tag}>")
    values = floats_of(child, count, "", where)
    if min(values) <= 0.0:
        raise DescriptionError(f"<{tag}> of {where} is '{child.text}'; it must be positive")
    if min(values) < MIN_SIZE or max(values) > MAX_SIZE:
        raise DescriptionError(
            f"<{tag}> of {where} is '{child.text}'; expected lengths from {MIN_SIZE:g} to "
            f"{MAX_SIZE:g} m: is it in another unit?"
        )
    return values


def pose_of(element: ET.Element, where: str) -> Transform:
    """Return the `<pose>` (4, 4) of an element in the frame it names; the identity without one."""
    return transform_of(element.find("pose"), where)


def transform_of(pose: ET.Element | None, where: str) -> Transform:
    """Return a `<pose>`: x, y, z and roll, pitch, yaw, or a quaternion.

    Args:
        pose: None for the identity, as is one without text.
    """
    if pose is None or not (pose.text or "").strip():
        return transform_from_xyz_rpy(0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    kind = pose.get("rotation_format", "euler_rpy")
    if kind not in ("euler_rpy", "quat_xyzw"):
        raise DescriptionError(
            f"<pose> of {where} has rotation_format '{kind}'; expected euler_rpy or quat_xyzw"
        )
    values = floats_of(pose, 6 if kind == "euler_rpy" else 7, "", where)
    if max(abs(value) for value in values[:3]) > MAX_PLACE:
        raise DescriptionError(
            f"<pose> of {where} is '{(pose.text or '').strip()}'; expected a place within "
            f"{MAX_PLACE:g} m: is it in another unit?"
        )
    if kind == "quat_xyzw":
        return _from_quaternion(values, where)
    if pose.get("degrees", "false").lower() in TRUE_WORDS:
        values[3:] = np.radians(values[3:]).tolist()
    return transform_from_xyz_rpy(*values)


def color_of(element: ET.Element | None, where: str) -> Color | None:
    """Return red, green, blue and opacity from 0 to 1; None without an element.

    Args:
        element: Holds 3 or 4 numbers, which are clipped to 0 to 1.
    """
    if element is None:
        return None
    words = (element.text or "").split()
    values = floats_of(element, max(3, min(4, len(words))), "", where)
    red, green, blue, alpha = (min(1.0, max(0.0, value)) for value in [*values, 1.0][:4])
    return red, green, blue, alpha


def _from_quaternion(values: list[float], where: str) -> Transform:
    place, quaternion = values[:3], np.array(values[3:])
    length = math.hypot(*quaternion)
    if length < 1e-6:
        raise DescriptionError(f"<pose> of {where} has a quaternion of length 0")
    matrix = np.eye(4)
    matrix[:3, :3] = rotation_of(*(quaternion / length))
    matrix[:3, 3] = place
    return matrix
