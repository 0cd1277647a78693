"""The elements and attributes of URDF and SDF: read, of no concern to us, or unknown.

What nothing reads would have no effect and no message: a `<colision>`, an `<inertial>` in the wrong
place, the second of two `<origin>`. Each is told.
"""

from __future__ import annotations

import xml.etree.ElementTree as ET
from collections.abc import Iterator
from dataclasses import dataclass

from swarm_common.model.errors import close_names


@dataclass(frozen=True, slots=True)
class _Rule:
    """Children and attributes that an element may hold."""

    one: tuple[str, ...] = ()  # children that may occur once
    any: tuple[str, ...] = ()  # children that may occur more often
    attributes: tuple[str, ...] = ()
    needed: tuple[str, ...] = ()  # attributes that must be there
    is_open: bool = False  # may hold any children, which are read elsewhere


_POSE = ("xyz", "rpy")
_INERTIA = ("ixx", "ixy", "ixz", "iyy", "iyz", "izz")
_PLAIN = _Rule()  # text, without children
_RAYS = _Rule(("scan", "range", "noise", "visibility_mask", "visibility_flags"))
_BEAM = _Rule(("samples", "resolution", "min_angle", "max_angle"))
# Of a ray sensor and of plugins, which both have.
_SHARED: dict[str, _Rule] = {
    "sensor": _Rule(
        (
            "pose", "update_rate", "topic", "always_on", "alwaysOn", "visualize", "ray", "lidar",
            "enable_metrics", "gz_frame_id", "ignition_frame_id", "frame_id", "frame_name",
            "visibility_mask", "updateRate", "parent",
        ),
        ("plugin",),
        ("name", "type"),
    ),
    "ray": _RAYS,
    "lidar": _RAYS,
    "scan": _Rule(("horizontal", "vertical")),
    "horizontal": _BEAM,
    "vertical": _BEAM,
    "range": _Rule(("min", "max", "resolution")),
    "noise": _Rule(
        (
            "type", "mean", "stddev", "bias_mean", "bias_stddev", "dynamic_bias_stddev",
            "dynamic_bias_correlation_time", "precision",
        ),
        attributes=("type",),
    ),
    "plugin": _Rule(attributes=("name", "filename"), is_open=True),
}  # fmt: skip
_URDF: dict[str, _Rule] = _SHARED | {
    "robot": _Rule(
        any=("link", "joint", "gazebo", "material", "transmission", "ros2_control", "sensor"),
        attributes=("name", "version"),
    ),
    "link": _Rule(
        ("inertial",), ("visual", "collision", "collision_checking"), ("name", "type"), ("name",)
    ),
    "inertial": _Rule(("origin", "mass", "inertia")),
    "mass": _Rule(attributes=("value",), needed=("value",)),
    "inertia": _Rule(attributes=_INERTIA, needed=("ixx", "iyy", "izz")),
    "collision": _Rule(
        ("origin", "geometry", "contact_coefficients", "verbose", "material"), (), ("name", "group")
    ),
    "geometry": _Rule(("box", "cylinder", "sphere", "mesh")),
    "box": _Rule(attributes=("size",), needed=("size",)),
    "cylinder": _Rule(attributes=("radius", "length"), needed=("radius", "length")),
    "sphere": _Rule(attributes=("radius",), needed=("radius",)),
    "mesh": _Rule(attributes=("filename", "scale"), needed=("filename",)),
    "origin": _Rule(attributes=_POSE),
    "joint": _Rule(
        (
            "origin", "parent", "child", "axis", "limit", "calibration", "dynamics", "mimic",
            "safety_controller", "hardwareInterface",
        ),
        (),
        ("name", "type"),
        ("name", "type"),
    ),
    "parent": _Rule(attributes=("link",), needed=("link",)),
    "child": _Rule(attributes=("link",), needed=("link",)),
    "axis": _Rule(attributes=("xyz",), needed=("xyz",)),
    "limit": _Rule(
        attributes=("lower", "upper", "effort", "velocity", "acceleration", "jerk", "deceleration")
    ),
    "gazebo": _Rule(
        any=(
            "plugin", "sensor", "material", "mu", "mu1", "mu2", "fdir1", "kp", "kd", "minDepth",
            "maxVel", "max_vel", "min_depth", "maxContacts", "selfCollide", "self_collide",
            "gravity", "turnGravityOff", "static", "dampingFactor", "laserRetro", "stopCfm",
            "stopErp", "stopKp", "stopKd", "cfmDamping", "fudgeFactor", "provideFeedback",
            "implicitSpringDamper", "springStiffness", "springReference", "preserveFixedJoint",
            "disableFixedJointLumping", "slip1", "slip2", "rolling_friction", "visual", "light",
            "collision", "link", "joint", "model", "frame", "pose", "inertial", "surface", "axis",
            "kinematic", "enable_wind", "velocity_decay", "physics", "dynamics", "limit", "audio",
            "initial_position", "initialPosition", "canonicalBody", "allow_auto_disable", "param",
            "particle_emitter", "projector", "rendering", "buoyancy", "gripper", "include",
            "ignition", "fluid_added_mass", "max_contacts", "topic", "verbose", "controller",
            "interface", "map", "disable_fixed_joint_lumping", "robot_namespace", "sdf",
        ),
        attributes=("reference", "name"),
    ),
}  # fmt: skip
_TEXTS = (
    "mass",
    "size",
    "radius",
    "length",
    "uri",
    "scale",
    *_INERTIA,
    "lower",
    "upper",
    "velocity",
)
_SDF: dict[str, _Rule] = _SHARED | dict.fromkeys(_TEXTS, _PLAIN) | {
    "sdf": _Rule(("model",), (), ("version",)),
    "model": _Rule(
        ("pose", "static", "self_collide", "allow_auto_disable", "enable_wind"),
        ("link", "joint", "frame", "plugin", "gripper"),
        ("name", "canonical_link", "placement_frame"),
    ),
    "link": _Rule(
        (
            "pose", "inertial", "gravity", "enable_wind", "self_collide", "kinematic",
            "must_be_base_link", "velocity_decay",
        ),
        (
            "visual", "collision", "sensor", "light", "battery", "projector", "audio_sink",
            "audio_source", "particle_emitter",
        ),
        ("name",),
        ("name",),
    ),
    "frame": _Rule(("pose",), (), ("name", "attached_to"), ("name",)),
    "pose": _Rule(attributes=("relative_to", "rotation_format", "degrees", "frame")),
    "inertial": _Rule(
        ("pose", "mass", "inertia", "density", "fluid_added_mass", "auto_inertia_params"),
        (),
        ("auto",),
    ),
    "inertia": _Rule(_INERTIA),
    "collision": _Rule(
        (
            "pose", "geometry", "surface", "laser_retro", "max_contacts", "density",
            "auto_inertia_params",
        ),
        (),
        ("name",),
    ),
    "geometry": _Rule(("box", "cylinder", "sphere", "capsule", "mesh")),
    "box": _Rule(("size",)),
    "cylinder": _Rule(("radius", "length")),
    "capsule": _Rule(("radius", "length")),
    "sphere": _Rule(("radius",)),
    "mesh": _Rule(("uri", "scale", "submesh", "convex_decomposition"), (), ("optimization",)),
    "joint": _Rule(
        (
            "pose", "parent", "child", "axis", "axis2", "physics", "gearbox_ratio",
            "gearbox_reference_body", "thread_pitch", "screw_thread_pitch",
        ),
        ("sensor",),
        ("name", "type"),
        ("name", "type"),
    ),
    "parent": _PLAIN,
    "child": _PLAIN,
    "axis": _Rule(
        ("xyz", "limit", "dynamics", "use_parent_model_frame", "initial_position", "mimic")
    ),
    "xyz": _Rule(attributes=("expressed_in",)),
    "limit": _Rule(("lower", "upper", "effort", "velocity", "stiffness", "dissipation")),
}  # fmt: skip
TOPS = ("robot", "sdf", "model")  # elements that messages need not name
# Elements whose inside is of no concern to us, or read elsewhere.
_CLOSED = (
    "visual", "material", "transmission", "ros2_control", "contact_coefficients", "verbose",
    "calibration", "dynamics", "mimic", "safety_controller", "hardwareInterface",
    "collision_checking",
)  # fmt: skip


def description_notes(root: ET.Element) -> list[str]:
    """Return a sentence on everything in a description that nothing reads and no rule knows."""
    return list(dict.fromkeys(_notes(root, "", _SDF if root.tag == "sdf" else _URDF)))


def _notes(element: ET.Element, place: str, rules: dict[str, _Rule]) -> Iterator[str]:
    tag = str(element.tag)
    name = element.get("name") or element.get("reference")
    here = f"<{tag}>" if name is None else f"<{tag}> {name}"
    where = f"{here} in {place}" if place else here
    rule = rules[tag]
    for attribute in element.attrib:
        if attribute not in rule.attributes and "}" not in attribute:
            advice = _advice(attribute, rule.attributes)
            yield f"{where}: attribute {attribute} is not known{advice}"
    for attribute in rule.needed:
        if attribute not in element.attrib:
            yield f"{where} has no attribute {attribute}"
    seen: set[str] = set()
    for child in () if rule.is_open else element:
        kind = str(child.tag)
        if kind in rule.one and kind in seen:
            yield f"{where} has more than one <{kind}>; the first counts"
        elif kind == "sensor" and tag in ("robot", "link") and rules is _URDF:
            yield (
                f"{where}: <sensor> {child.get('name')} is not used; sensors are read in "
                "<gazebo reference=...>"
            )
        elif kind not in (*rule.one, *rule.any):
            if "}" not in kind:  # of another namespace
                known = (*rule.one, *rule.any)
                yield f"{where}: <{kind}> is not known there, and not used{_advice(kind, known)}"
        elif _is_looked_into(child, tag, rules):
            yield from _notes(child, "" if tag in TOPS else here, rules)
        seen.add(kind)


def _is_looked_into(element: ET.Element, parent: str, rules: dict[str, _Rule]) -> bool:
    kind = str(element.tag)
    if kind in _CLOSED or kind not in rules:
        return False
    if kind == "sensor":
        return any(element.find(tag) is not None for tag in ("ray", "lidar"))
    return parent != "gazebo" or kind == "plugin"


def _advice(name: str, known: tuple[str, ...]) -> str:
    close = close_names(name, known, 1)
    return f"; did you mean {close[0]}?" if close else ""
