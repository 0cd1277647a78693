"""The elements and attributes of URDF and SDF robots: read, of no concern to us, or unknown.

What nothing reads would have no effect and no message: a `<colision>`, an `<inertial>` in the wrong
place, the second of two `<origin>`. Each is told.
"""

from __future__ import annotations

import xml.etree.ElementTree as ET
from collections.abc import Iterator

from swarm_common.model.errors import close_names
from swarm_describe.worlds.grammar import KINDS, LEAF, RULES, Rule, rule

_INERTIA = "ixx ixy ixz iyy iyz izz"
_RAYS = rule("scan range noise visibility_mask visibility_flags")
_BEAM = rule("samples resolution min_angle max_angle")
# Of a ray sensor and of plugins, which both have.
_SHARED: dict[str, Rule] = {
    "sensor": rule(
        "pose update_rate topic always_on alwaysOn visualize ray lidar enable_metrics gz_frame_id "
        "ignition_frame_id frame_id frame_name visibility_mask updateRate parent",
        "plugin",
        attributes="name type",
    ),
    "ray": _RAYS,
    "lidar": _RAYS,
    "scan": rule("horizontal vertical"),
    "horizontal": _BEAM,
    "vertical": _BEAM,
    "range": rule("min max resolution"),
    "noise": rule(
        "type mean stddev bias_mean bias_stddev dynamic_bias_stddev "
        "dynamic_bias_correlation_time precision",
        attributes="type",
    ),
    "plugin": rule(attributes="name filename"),  # its parameters are read elsewhere
}
_URDF: dict[str, Rule] = _SHARED | {
    "robot": rule(
        many="link joint gazebo material transmission ros2_control sensor",
        attributes="name version",
    ),
    "link": rule(
        "inertial", "visual collision collision_checking", attributes="type", needed="name"
    ),
    "inertial": rule("origin mass inertia"),
    "mass": rule(needed="value"),
    "inertia": rule(attributes=_INERTIA, needed="ixx iyy izz"),
    "collision": rule(
        "origin geometry contact_coefficients verbose material", attributes="name group"
    ),
    "geometry": rule("box cylinder sphere mesh"),
    "box": rule(needed="size"),
    "cylinder": rule(needed="radius length"),
    "sphere": rule(needed="radius"),
    "mesh": rule(attributes="scale", needed="filename"),
    "origin": rule(attributes="xyz rpy"),
    "joint": rule(
        "origin parent child axis limit calibration dynamics mimic safety_controller "
        "hardwareInterface",
        needed="name type",
    ),
    "parent": rule(needed="link"),
    "child": rule(needed="link"),
    "axis": rule(needed="xyz"),
    "limit": rule(attributes="lower upper effort velocity acceleration jerk deceleration"),
    "gazebo": rule(
        many="plugin sensor material mu mu1 mu2 fdir1 kp kd minDepth maxVel max_vel min_depth "
        "maxContacts selfCollide self_collide gravity turnGravityOff static dampingFactor "
        "laserRetro stopCfm stopErp stopKp stopKd cfmDamping fudgeFactor provideFeedback "
        "implicitSpringDamper springStiffness springReference preserveFixedJoint "
        "disableFixedJointLumping slip1 slip2 rolling_friction visual light collision link joint "
        "model frame pose inertial surface axis kinematic enable_wind velocity_decay physics "
        "dynamics limit audio initial_position initialPosition canonicalBody allow_auto_disable "
        "param particle_emitter projector rendering buoyancy gripper include ignition "
        "fluid_added_mass max_contacts topic verbose controller interface map "
        "disable_fixed_joint_lumping robot_namespace sdf",
        attributes="reference name",
    ),
}
_TEXTS = f"mass size radius length uri scale lower upper velocity parent child {_INERTIA}"
# Of a model in a world more is read, and of what a robot has less.
_SDF: dict[str, Rule] = {
    **RULES,
    **_SHARED,
    **dict.fromkeys(_TEXTS.split(), LEAF),
    "sdf": rule("model", attributes="version"),
    "pose": rule(attributes="relative_to rotation_format degrees frame"),
    "inertial": rule(
        "pose mass inertia density fluid_added_mass auto_inertia_params", attributes="auto"
    ),
    "inertia": rule(_INERTIA),
    "joint": rule(
        "pose parent child axis axis2 physics gearbox_ratio gearbox_reference_body thread_pitch "
        "screw_thread_pitch",
        "sensor",
        needed="name type",
    ),
    "axis": rule("xyz limit dynamics use_parent_model_frame initial_position mimic"),
    "xyz": rule(attributes="expressed_in"),
    "limit": rule("lower upper effort velocity stiffness dissipation"),
}
TOPS = ("robot", "sdf", "model")  # elements that messages need not name
# Elements whose inside is of no concern to us, or read elsewhere.
_CLOSED = (
    "visual material transmission ros2_control contact_coefficients verbose calibration dynamics "
    "mimic safety_controller hardwareInterface collision_checking surface"
).split()


def description_notes(root: ET.Element) -> list[str]:
    """Return a sentence on everything in a description that nothing reads and no rule knows."""
    return list(dict.fromkeys(_notes(root, "", _SDF if root.tag == "sdf" else _URDF)))


def _notes(element: ET.Element, place: str, rules: dict[str, Rule]) -> Iterator[str]:
    tag = str(element.tag)
    name = element.get("name") or element.get("reference")
    here = f"<{tag}>" if name is None else f"<{tag}> {name}"
    where = f"{here} in {place}" if place else here
    known = rules[tag]
    for attribute in element.attrib:
        if attribute not in known.attributes and "}" not in attribute:
            advice = _advice(attribute, known.attributes)
            yield f"{where}: attribute {attribute} is not known{advice}"
    for attribute in sorted(known.needed - element.attrib.keys()):
        yield f"{where} has no attribute {attribute}"
    seen: set[str] = set()
    for child in () if tag == "plugin" else element:
        kind = str(child.tag)
        if kind in known.once and kind in seen:
            yield f"{where} has more than one <{kind}>; the first counts"
        elif kind == "sensor" and tag in ("robot", "link") and rules is _URDF:
            yield (
                f"{where}: <sensor> {child.get('name')} is not used; sensors are read in "
                "<gazebo reference=...>"
            )
        elif kind not in known.known:
            if "}" not in kind:  # of another namespace
                advice = _advice(kind, known.known)
                yield f"{where}: <{kind}> is not known there, and not used{advice}"
        elif _is_looked_into(child, tag, rules):
            yield from _notes(child, "" if tag in TOPS else here, rules)
        seen.add(kind)


def _is_looked_into(element: ET.Element, parent: str, rules: dict[str, Rule]) -> bool:
    kind = str(element.tag)
    if kind in _CLOSED or kind not in rules or not KINDS.get((parent, kind), kind):
        return False
    if kind == "sensor":
        return any(element.find(tag) is not None for tag in ("ray", "lidar"))
    return parent != "gazebo" or kind == "plugin"


def _advice(name: str, known: frozenset[str]) -> str:
    close = close_names(name, known, 1)
    return f"; did you mean {close[0]}?" if close else ""
