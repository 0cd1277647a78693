"""Robot models: what world and navigator must agree on, from `robot.yaml` and the description.

What `robot.yaml` says counts; the rest is derived from the URDF or xacro. A `robot.yaml` that says
everything spares the reading of the description.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from swarm_common.model.errors import RobotModelError
from swarm_common.model.records import CONTROL_PERIOD, RobotSpec
from swarm_common.model.shapes import Transform
from swarm_describe.files.faults import Faults
from swarm_describe.robots.derived import (
    BASE,
    FASTEST_WHEEL,
    SCAN,
    Asked,
    Described,
    describe,
    scan_place,
    with_scan_frame,
)
from swarm_describe.robots.description import Origin, RobotModel, parse_urdf
from swarm_describe.robots.source import RobotSource, find_robot
from swarm_describe.robots.spec import (
    LIDAR_REQUIRED,
    REQUIRED,
    SIDEWAYS,
    VALUES,
    read_values,
    spec_of,
)
from swarm_describe.robots.urdf_tree import DESCRIBED, fixed_places, read_tree

OFF = 0.01  # share by which a rate or speed may be off what is stated, unmentioned


@dataclass(frozen=True, slots=True)
class Robot:
    """All about a robot model."""

    spec: RobotSpec  # what world and navigator must agree on
    urdf: str  # its description
    model: RobotModel  # its bodies, in base_footprint


@dataclass(frozen=True, slots=True)
class Account:
    """All values of a robot model, and where each is from."""

    where: str  # the file
    rows: tuple[tuple[str, Any, str], ...]  # name of a value, the value, and what it is from
    missing: tuple[tuple[str, str], ...]  # names of values that nothing tells, and why if known
    notes: tuple[str, ...]  # what was assumed, and what was not used


def account_of(name_or_path: str | Path) -> Account:
    """Return all values of a robot model with where each is from; limits may be missing."""
    source = find_robot(name_or_path)
    faults = Faults(source.where, RobotModelError)
    values, described = _values(source, faults)
    lacking = _missing(values)
    spec = spec_of(source.name, _checkable(values), source.file, faults)
    faults.check()
    file = source.settings.name
    origins = {} if described is None else described.model.origins
    doubts = {} if described is None else described.doubts
    rows: list[tuple[str, Any, str]] = []
    for name in VALUES:
        if name == "lidar" and "lidar" in values:
            rows += _lidar_rows(values["lidar"], source, origins.get(name), spec)
        elif name == "wheels" and ("wheels" in values or "wheels_left" in values):
            sides = values.get("wheels") or {
                side: list(values[f"wheels_{side}"]) for side in ("left", "right")
            }
            rows.append((name, sides, _said(name, source, origins.get(name))))
        elif name in values:
            rows.append((name, values[name], _said(name, source, origins.get(name))))
        elif spec is not None and getattr(spec, name, None):
            about = f"default: {name.replace('_y', '_x')}" if name in SIDEWAYS else "default"
            about = "name of the file" if name == "model" else about
            rows.append((name, getattr(spec, name), about))
    why = [
        (name, doubts.get(name, f"neither {file} nor the description tells it")) for name in lacking
    ]
    notes = () if described is None else described.model.notes
    if spec is not None:
        notes += tuple(_remarks(spec, None if described is None else described.model))
    return Account(source.where, tuple(rows), tuple(why), notes)


def taken_for(spec: RobotSpec, model: RobotModel) -> str:
    """Return the assumed drive of a robot, the reason, and how to state another one."""
    sides = [", ".join(side) or "none" for side in (spec.wheels_left, spec.wheels_right)]
    values = {
        "drive": f"drive {spec.drive}",
        "wheels": f"wheels {sides[0]} (left) and {sides[1]} (right)",
        "wheel_radius": f"radius {spec.wheel_radius:.4g} m",
        "wheel_separation": f"separation {spec.wheel_separation:.4g} m",
    }
    said = [
        f"{text} ({model.origins[name]})" if name in model.origins else text
        for name, text in values.items()
    ]
    return (
        f"It was taken for: {'; '.join(said)}. If that is not so, state it in robot.yaml: "
        "drive: ..., wheels: {left: [...], right: [...]}, wheel_radius: ..., wheel_separation: ..."
    )


def _lidar_rows(
    lidar: object, source: RobotSource, origin: Origin | None, spec: RobotSpec | None
) -> list[tuple[str, Any, str]]:
    """Return a row for each value of the LiDAR."""
    if not isinstance(lidar, dict):
        return []
    own = source.data.get("lidar") or {}
    rows = [
        (f"lidar.{key}", value, source.settings.name if key in own else str(origin))
        for key, value in lidar.items()
    ]
    if spec is not None:
        every = dataclasses.asdict(spec.lidar)
        rows += [(f"lidar.{k}", every[k], "default") for k in every if k not in lidar]
    return rows


def _said(name: str, source: RobotSource, origin: Origin | None) -> str:
    if name in source.data or origin is None:
        return source.settings.name
    return str(origin)


def load_robot(name_or_path: str | Path) -> RobotSpec:
    """Return the properties of a robot on which world and navigator must agree.

    Args:
        name_or_path: Name of a folder in `robots/`, or a path to a folder, URDF, xacro or
            `robot.yaml`.
    """
    source = find_robot(name_or_path)
    faults = Faults(source.where, RobotModelError)
    return _specified(source, faults)[0]


def open_robot(name_or_path: str | Path) -> Robot:
    """Return all about a robot."""
    source = find_robot(name_or_path)
    faults = Faults(source.where, RobotModelError)
    spec, described = _specified(source, faults)
    if described is not None:
        text, model = described.urdf, described.model
    else:
        text = source.text()
        moving = (*spec.wheels_left, *spec.wheels_right)
        directory = source.settings.parent if source.urdf is None else source.urdf.parent
        inertia = _asked(source, faults).inertia
        model = parse_urdf(text, source.where, moving, source.finder(), directory, inertia)
    model = dataclasses.replace(model, notes=(*model.notes, *_remarks(spec, model)))
    return Robot(spec, with_scan_frame(text, model, spec.lidar), model)


def _remarks(spec: RobotSpec, model: RobotModel | None) -> Iterator[str]:
    """Yield what a run does not do as stated, or does beyond what the description allows."""
    comes = 1.0 / (spec.lidar.period_ticks * CONTROL_PERIOD)
    if abs(comes - spec.lidar.rate) > OFF * comes:
        yield (
            f"the LiDAR's rate is {spec.lidar.rate:g} Hz; its scans come at {comes:.4g} Hz, "
            f"whole ticks of {CONTROL_PERIOD:g} s apart"
        )
    joints = (*spec.wheels_left, *spec.wheels_right)
    wheels = [] if model is None else [g for g in model.groups if g.joint in joints]
    slowest = min(wheels, key=lambda wheel: wheel.speed_limit, default=None)
    if slowest is None or slowest.speed_limit > FASTEST_WHEEL:
        return
    half = (spec.wheel_separation + (spec.wheel_base if spec.is_omni else 0.0)) / 2.0
    for name, speed in (
        ("max_vel_x", spec.max_vel_x),
        ("max_vel_theta", spec.max_vel_theta * half),
    ):
        if speed / spec.wheel_radius > (1.0 + OFF) * slowest.speed_limit:
            yield (
                f"{name} {getattr(spec, name):g} takes {speed / spec.wheel_radius:.3g} rad/s of the"
                f" wheels; the velocity limit of joint {slowest.joint} is"
                f" {slowest.speed_limit:g} rad/s, and does not count against it"
            )


def fixed_frames(name_or_path: str | Path) -> dict[str, Transform]:
    """Return base_footprint_from_link of every fixed link of a robot, as tf_static has them."""
    source = find_robot(name_or_path)
    spec, described = _specified(source, Faults(source.where, RobotModelError))
    text = source.text() if described is None else described.urdf
    root = read_tree(text, source.where, source.data.get("inertia", DESCRIBED))
    return {BASE: np.eye(4)} | fixed_places(root) | {SCAN: scan_place(spec.lidar)}


def _specified(source: RobotSource, faults: Faults) -> tuple[RobotSpec, Described | None]:
    """Return a model, and its description if that was asked."""
    values, described = _values(source, faults)
    if described is not None and (missing := _missing(values)):
        faults.tell([_untold(source, missing, described.doubts)])
    spec = spec_of(source.name, _checkable(values), source.file, faults)
    faults.check()
    assert spec is not None
    return spec, described


def _values(source: RobotSource, faults: Faults) -> tuple[dict[str, Any], Described | None]:
    """Return the values of robot.yaml over those of the description, which is read if needed."""
    data = source.data
    asked = _asked(source, faults)
    if _is_complete(data):
        return dict(data), None
    if source.urdf is None:
        faults.tell([_undescribed(source)])
        return dict(data), None
    described = describe(source, asked, faults)
    seen = {} if described is None else described.values
    merged = {**seen, **data}
    own = data.get("lidar")
    if own is None or isinstance(own, dict):
        merged["lidar"] = {**seen.get("lidar", {}), **(own or {})}
    return merged, described


def _untold(source: RobotSource, missing: Sequence[str], doubts: Mapping[str, str]) -> str:
    why = dict.fromkeys(doubts[name] for name in missing if name in doubts)
    return (
        f"{source.where} does not tell {', '.join(missing)}"
        + "".join(f" ({text})" for text in why)
        + f"; write {'them' if len(missing) > 1 else 'it'} into {source.settings.absolute()}"
    )


def _checkable(values: Mapping[str, Any]) -> dict[str, Any]:
    """Return values without those of a LiDAR whose place is missing."""
    is_placed = not any(name.startswith("lidar.") for name in _missing(values))
    return {name: value for name, value in values.items() if name != "lidar" or is_placed}


def _is_complete(data: Mapping[str, Any]) -> bool:
    lidar = data.get("lidar")
    return all(name in data for name in REQUIRED) and (
        not isinstance(lidar, dict) or all(name in lidar for name in LIDAR_REQUIRED)
    )


def _undescribed(source: RobotSource) -> str:
    return (
        f"{source.settings} lacks {', '.join(_missing(source.data))}; there is no description "
        "beside it to derive that from"
    )


def _asked(source: RobotSource, faults: Faults) -> Asked:
    """Return the values of robot.yaml for what else follows from the description."""
    data = source.data
    lidar = data.get("lidar")  # which may lack what the description has
    own = read_values({n: v for n, v in data.items() if n != "lidar"}, source.settings, faults)
    wheels, files = own.get("wheels"), own.get("controllers", ())
    paths = [source.settings.parent / name for name in files]
    faults.tell(
        f"{source.settings}: controllers: there is no file {path}"
        for path in paths
        if not path.is_file()
    )
    return Asked(
        drive=own.get("drive"),
        wheels=None if wheels is None else (wheels.left, wheels.right),
        wheel_radius=own.get("wheel_radius"),
        lidar=lidar if isinstance(lidar, dict) else {},
        controllers=[path for path in paths if path.is_file()],
        stated=tuple(data),
        inertia=own.get("inertia", DESCRIBED),
    )


def _missing(values: Mapping[str, Any]) -> list[str]:
    missing = [name for name in REQUIRED if name not in values]
    lidar = values.get("lidar")
    if isinstance(lidar, dict):
        missing += [f"lidar.{name}" for name in LIDAR_REQUIRED if name not in lidar]
    return missing
