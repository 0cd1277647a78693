"""Rules for the elements of an SDF file: each is read, counted, of no account, or named.

An element that is not expected at its place is told, with the closest name that is. If it may hold
something solid (a model, a link, a shape, a file), what is around it is unusable: half a world
must not pass for the whole. Elements with a prefix (`gz:policies`) belong to other programs.
"""

from __future__ import annotations

import re
import xml.etree.ElementTree as ET
from collections import Counter
from dataclasses import dataclass

from swarm_common.model.errors import WorldError, close_names
from swarm_describe.worlds.source import Source

SHAPES = "box cylinder sphere plane capsule cone ellipsoid polyline mesh empty"
SOLID = {
    *("world", "model", "include", "link", "collision", "visual", "geometry", "uri"),
    *SHAPES.split(),
}
TEMPLATE = re.compile(r"\{[%{]|<%|@[\[({]|\$[({]")  # Jinja, ERB, EmPy, xacro
SHOWN = 40  # characters of a text
MAX_DEPTH = 100  # of elements in elements: more than models may have, with what is in them


@dataclass(frozen=True, slots=True)
class Rule:
    """Children that an element may have, by tag; attributes are checked for robots only."""

    once: frozenset[str]  # read; only the first counts
    many: frozenset[str]  # read, each of them
    noted: frozenset[str]  # not read; told with their number
    quiet: frozenset[str]  # not read: they concern only looks and solvers
    attributes: frozenset[str]
    needed: frozenset[str]  # attributes that must be there

    @property
    def known(self) -> frozenset[str]:
        """All tags that have a place here."""
        return self.once | self.many | self.noted | self.quiet


def rule(
    once: str = "",
    many: str = "",
    noted: str = "",
    quiet: str = "",
    attributes: str = "",
    needed: str = "",
) -> Rule:
    """Return a rule; words are separated by blanks, and `needed` counts among the attributes."""
    words = (once, many, noted, quiet, f"{attributes} {needed}", needed)
    return Rule(*(frozenset(text.split()) for text in words))


_WORLD_NOTED = "light plugin population road wind audio audio_source particle_emitter sensor joint"
RULES = {
    "sdf": rule(once="world", noted=_WORLD_NOTED),
    "model file": rule(once="model", noted="light actor plugin"),
    "world": rule(
        many="model include actor frame state",
        noted=_WORLD_NOTED,
        quiet="gravity magnetic_field atmosphere gui physics scene spherical_coordinates",
    ),
    "model": rule(
        once="static pose",
        many="link joint frame model include",
        noted="plugin gripper light sensor particle_emitter",
        quiet="self_collide allow_auto_disable enable_wind",
        attributes="name canonical_link placement_frame",
    ),
    "include": rule(once="uri name pose static placement_frame", noted="plugin"),
    "link": rule(
        once="pose inertial",
        many="collision visual",
        noted="sensor light projector audio_source particle_emitter plugin battery",
        quiet="gravity enable_wind self_collide kinematic must_be_base_link velocity_decay frame "
        "audio_sink damping",
        needed="name",
    ),
    "inertial": rule(
        once="mass", quiet="pose frame inertia density auto_inertia_params fluid_added_mass"
    ),
    "collision": rule(
        once="pose geometry surface",
        quiet="laser_retro max_contacts frame density auto_inertia_params material",
        attributes="name",
    ),
    "surface": rule(once="friction", quiet="bounce contact soft_contact"),
    "friction": rule(once="ode bullet", quiet="torsional"),
    "ode": rule(once="mu", quiet="mu2 fdir1 slip1 slip2"),
    "bullet": rule(once="friction", quiet="friction2 fdir1 rolling_friction"),
    "geometry": rule(once=SHAPES),
    "visual": rule(
        once="pose material",
        many="geometry",
        noted="plugin",
        quiet="cast_shadows laser_retro transparency visibility_flags meta frame",
    ),
    "box": rule(once="size"),
    "cylinder": rule(once="radius length"),
    "sphere": rule(once="radius"),
    "capsule": rule(once="radius length"),
    "cone": rule(once="radius length"),
    "ellipsoid": rule(once="radii"),
    "plane": rule(once="normal", quiet="size"),
    "polyline": rule(once="height", many="point"),
    "mesh": rule(once="uri scale submesh", noted="convex_decomposition", attributes="optimization"),
    "submesh": rule(once="name", noted="center"),
    "material": rule(
        once="diffuse ambient script",
        quiet="specular emissive shader lighting pbr render_order double_sided shininess",
    ),
    "material script": rule(once="name", quiet="uri"),
    "joint": rule(
        once="parent child pose",
        noted="sensor plugin",
        quiet="axis axis2 physics frame gearbox_ratio gearbox_reference_body thread_pitch "
        "screw_thread_pitch",
    ),
    "frame": rule(once="pose", attributes="attached_to", needed="name"),
    "actor": rule(
        many="script link", noted="plugin sensor", quiet="pose skin animation static frame joint"
    ),
    "actor link": rule(
        many="collision", noted="sensor light", quiet="pose inertial visual gravity self_collide"
    ),
    "actor collision": rule(once="geometry", quiet="pose surface laser_retro max_contacts"),
    "script": rule(many="trajectory", quiet="loop delay_start auto_start"),
    "trajectory": rule(many="waypoint", quiet="type tension id"),
    "waypoint": rule(once="time pose"),
    "state": rule(
        many="model insertions deletions",
        quiet="sim_time wall_time real_time iterations light joint plugin",
    ),
    "insertions": rule(many="model include", noted="light plugin"),
    "deletions": rule(many="name"),
    "state model": rule(once="pose scale", many="model link", quiet="frame joint static"),
    "state link": rule(
        once="pose", quiet="velocity acceleration wrench collision visual frame sensor inertial"
    ),
}
# Kinds of elements that are not called by their tag alone.
KINDS = {
    ("visual", "geometry"): "seen geometry",
    ("seen geometry", "mesh"): "mesh",
    ("material", "script"): "material script",
    ("bullet", "friction"): "",
    ("state", "model"): "state model",
    ("state model", "model"): "state model",
    ("state model", "link"): "state link",
    ("world", "model"): "",  # these are gone through where they are read
    ("model", "model"): "",
    ("model file", "model"): "",
    ("insertions", "model"): "",
    ("insertions", "include"): "",
    ("world", "include"): "",
    ("model", "include"): "",
    ("sdf", "world"): "",
    ("actor", "link"): "actor link",
    ("actor link", "collision"): "actor collision",
}
RULES["seen geometry"] = rule(many=SHAPES, quiet="heightmap image")
NAMED = ("link", "joint", "frame")  # siblings whose names must differ
LEAF = rule()
LOOKS = ("visual", "seen geometry", "material")  # of which nothing is solid


def account_for(element: ET.Element, kind: str, where: str, source: Source, depth: int = 0) -> None:
    """Go through an element; models and includes in it are gone through where they are read.

    Args:
        kind: Key of `RULES`; without a rule it may have no children.
    """
    if depth > MAX_DEPTH:
        raise WorldError(f"elements are nested more than {MAX_DEPTH} deep at {where}")
    known = RULES.get(kind, LEAF)
    if kind in RULES:
        _check_text(element, where, source)
    if kind == "geometry":
        _check_one_shape(element, where, source)
    seen: Counter[str] = Counter()
    names: Counter[tuple[str, str]] = Counter()
    for child in element:
        tag = child.tag
        seen[tag] += 1
        if tag in known.noted or ":" in tag:
            source.ignored[tag] += 1
        elif tag in known.once and seen[tag] > 1:
            _reject(child, f"a second <{tag}> in {where}", "the first counts", kind, source)
        elif tag in known.once or tag in known.many:
            names[tag, child.get("name", "")] += tag in NAMED or kind == "state"
            inner = KINDS.get((kind, tag), tag)
            if inner:
                name = f" '{child.get('name')}'" if child.get("name") else ""
                account_for(child, inner, f"<{tag}>{name} of {where}", source, depth + 1)
        elif tag not in known.quiet and kind != "geometry":  # whose shapes are refused when read
            close = close_names(tag, known.known, most=1)
            advice = f"did you mean <{close[0]}>?" if close else "it has no place there"
            _reject(child, f"<{tag}> in {where}", advice, kind, source)
    for (tag, name), count in names.items():
        if count > 1:
            source.remark(f"{count} <{tag}> in {where} are called '{name}'")


def _reject(child: ET.Element, what: str, advice: str, kind: str, source: Source) -> None:
    """Record an element that is not read; raise if it may be solid."""
    solid = next((e.tag for e in child.iter() if e.tag in SOLID), None)
    if solid is None or kind in LOOKS:
        source.reject(child.tag, kind, what, advice)
        return
    inside = "" if solid == child.tag else f" holds a <{solid}>, but"
    cause = WorldError(f"{what}{inside} is not read; {advice}")
    if kind not in ("sdf", "world"):
        raise cause
    source.break_off(child.get("name") or f"<{child.tag}>", cause)


def _check_text(element: ET.Element, where: str, source: Source) -> None:
    """Record text between elements; reject that of a template which was not expanded."""
    for text in (element.text, *(child.tail for child in element)):
        words = " ".join((text or "").split())
        if not words:
            continue
        shown = words if len(words) <= SHOWN else words[:SHOWN] + "..."
        if TEMPLATE.search(words):
            raise WorldError(
                f"'{shown}' in {where}: is the file a template? Expand it, and give the result"
            )
        source.remark(f"the text '{shown}' in {where} is ignored")


def _check_one_shape(geometry: ET.Element, where: str, source: Source) -> None:
    tags = [child.tag for child in geometry if ":" not in child.tag]
    if len(tags) > 1:
        raise WorldError(f"{where} holds {', '.join(tags)}; expected one shape")
    if not tags:
        source.remark(f"{where} is empty: nothing is there")
