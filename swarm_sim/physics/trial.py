"""The trial of a robot model: alone on the ground, half a metre ahead, a quarter turn, a curve.

A description may be well-formed and yet drive nowhere: wheels in the air, a centre of mass over
the caster, inertias of another robot. That is seen by driving it once, in the physics engine that
the run uses. The result is kept by the content of the model.
"""

from __future__ import annotations

import functools
import math
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from swarm_common.files.storage import kept
from swarm_common.model.engines import BULLET, check_engine
from swarm_common.model.errors import RobotModelError
from swarm_common.model.records import CONTROL_PERIOD, Pose, RobotSpec, wrap_angle
from swarm_describe.robots.description import RobotModel
from swarm_describe.robots.loading import taken_for
from swarm_sim.physics import actors, objects
from swarm_sim.physics.bullet.robot_bodies import base_and_wheels
from swarm_sim.physics.bullet.supports import SAG, SPRING, depths, find_supports, heights

AHEAD = 0.5  # [m]
TURN = math.pi / 2.0
LONGEST = 10.0  # [s] of either motion; a slow robot goes less far
CURVE_TIME = 2.0  # [s] of a curve, at half the speed and half the rate of the other motions
REST = 1.0  # [s] after each motion
SHARE_OFF = 0.05  # of a motion, by which it may be off
WAY_OFF = 0.01  # [m] by which it may be off in addition
ANGLE_OFF = 0.03  # [rad] likewise
LEAST_LOAD = 0.05  # of the weight that the driven wheels of either side carry
MOST_TILT = math.radians(5.0)
GRAVITY = 9.81  # [m/s²]
MODULES = (
    "bullet/bullet_engine", "bullet/bullet_kernels", "bullet/collision_shapes",
    "bullet/fixed_bodies", "bullet/probe", "bullet/robot_bodies", "bullet/supports", "drive",
    "trial",
)  # fmt: skip
CURE = "let the inertias follow from the shapes, in robot.yaml: inertia: shapes"


@dataclass(frozen=True, slots=True, kw_only=True)
class Trial:
    """Motion of a robot that was told to go ahead, then to turn, then to drive a curve."""

    way: float  # [m] that it was to go ahead
    turn: float  # [rad] that it was to turn then
    ahead: float  # [m] that it went
    aside: float  # [m] that it went to the left meanwhile
    swerve: float  # [rad] that it turned meanwhile
    turned: float  # [rad] when it was to turn
    strayed: float  # [m] that it moved meanwhile
    curve: float  # [rad] that it was to turn in the curve
    curved: float  # [rad] that it turned there
    rolled: float  # [m] that its wheels report for the way ahead
    side: float  # [m] that it was to go to the left; 0 unless it is omnidirectional
    slid: float  # [m] that it went there
    side_rolled: float  # [m] that its wheels report for that
    tilt: float  # [rad] at most
    left: float  # share of its weight that the left driven wheels carry, on average
    right: float  # of the right ones
    # link that reaches further below the wheels than a spring takes up, and by how much [m]
    deepest: tuple[str, float] | None
    # link of which the engine lacks a shape, and where that is [m] in base_footprint
    lost: tuple[str, float, float, float] | None

    @property
    def goes_ahead(self) -> bool:
        """Whether it went where it was told to."""
        off = max(abs(self.ahead - self.way), abs(self.aside))
        return off <= SHARE_OFF * self.way + WAY_OFF and abs(self.swerve) <= ANGLE_OFF

    @property
    def turns(self) -> bool:
        """Whether it turned on the spot as it was told to."""
        is_turned = abs(self.turned - self.turn) <= SHARE_OFF * self.turn + ANGLE_OFF
        return is_turned and self.strayed <= 2.0 * WAY_OFF

    @property
    def curves(self) -> bool:
        """Whether it turned in a curve as it was told to."""
        return abs(self.curved - self.curve) <= SHARE_OFF * self.curve + ANGLE_OFF

    @property
    def slides(self) -> bool:
        """Whether it went to the left as it was told to, and its wheels report it."""
        off = max(abs(self.slid - self.side), abs(self.side_rolled - self.side))
        return off <= SHARE_OFF * self.side + WAY_OFF

    @property
    def stands(self) -> bool:
        """Whether the driven wheels of both sides carry it, and it is upright."""
        return min(self.left, self.right) >= LEAST_LOAD and self.tilt <= MOST_TILT


def check_trial(spec: RobotSpec, model: RobotModel, period: float) -> Trial:
    """Let a robot model drive once, or take the result of its last trial from the cache.

    Raises:
        RobotModelError: If it does not do what it is told; the message names cause and cure.
    """
    parts = [*_code(), repr(period), repr(spec), *_content(model)]
    trial: Trial = kept("trials", parts, lambda: drive(spec, model, period))
    if trial.lost:
        link, x, y, z = trial.lost
        raise RobotModelError(
            f"robot '{spec.model}': the physics engine lacks a collision shape of link {link} "
            f"around ({x:.2f}, {y:.2f}, {z:.2f}) in base_footprint; simplify that link's shapes"
        )
    is_good = trial.stands and trial.goes_ahead and trial.turns and trial.curves and trial.slides
    if trial.deepest or not is_good:
        raise RobotModelError(
            f"robot '{spec.model}' does not drive. Alone on the ground in the physics engine, told "
            f"to go {trial.way:.2f} m ahead and to turn by {math.degrees(trial.turn):.0f} degrees, "
            f"it went {trial.ahead:.2f} m ahead and {trial.aside:.2f} m to the left while it "
            f"turned by {math.degrees(trial.swerve):.0f} degrees, and then turned by "
            f"{math.degrees(trial.turned):.0f}; in a curve it turned by "
            f"{math.degrees(trial.curved):.0f} instead of {math.degrees(trial.curve):.0f}; "
            f"{_sideways(trial)}"
            f"the driven wheels carry {trial.left:.0%} (left) "
            f"and {trial.right:.0%} (right) of its weight. {_cause(trial, spec, model)}"
        )
    return trial


def _sideways(trial: Trial) -> str:
    """Return the sideways motion of an omnidirectional robot."""
    if trial.side == 0.0:
        return ""
    return (
        f"told to go {trial.side:.2f} m to the left, it went {trial.slid:.2f} m, and its wheels "
        f"report {trial.side_rolled:.2f} m; "
    )


def drive(spec: RobotSpec, model: RobotModel, period: float) -> Trial:
    """Drive a robot that is alone on the ground; return what it did."""
    check_engine(BULLET, "a trial of a robot model")
    from swarm_sim.physics.bullet.bullet_engine import BulletEngine

    start = [Pose(0.0, 0.0, 0.0)]
    nobody = actors.Walkers((), [spec], start, 0)
    nothing = objects.Objects((), actors.Vehicles((), [spec], start, 0), (0.0, spec.height))
    engine = BulletEngine((), [spec], [model], start, period, nobody, nothing)
    weight = GRAVITY * sum(group.mass for group in model.groups)
    loads, tilt = [], 0.0

    def move(speed: float, rate: float, seconds: float, side: float = 0.0) -> None:
        """Drive, and note how the robot stands."""
        nonlocal tilt
        for _ in range(round(seconds / CONTROL_PERIOD)):
            engine.advance(np.array([[speed, rate, side]]))
            stance = engine.stance(0)
            tilt = max(tilt, stance.tilt)
            loads.append(stance.wheel_loads)

    try:
        speed, ahead_for = _motion(AHEAD, spec.max_vel_x, spec.acc_lim_x)
        rate, turn_for = _motion(TURN, spec.max_vel_theta, spec.acc_lim_theta)
        begin = engine.poses[0].copy()
        move(speed, 0.0, ahead_for)
        move(0.0, 0.0, speed / spec.acc_lim_x + REST)
        middle, rolled = engine.poses[0].copy(), float(engine.travels[0, 0])
        gyro = float(engine.yaws_gyro[0])
        move(0.0, rate, turn_for)
        move(0.0, 0.0, rate / spec.acc_lim_theta + REST)
        end = engine.poses[0].copy()
        turned = float(engine.yaws_gyro[0]) - gyro
        move(speed / 2.0, rate / 2.0, CURVE_TIME)
        move(0.0, 0.0, max(speed / spec.acc_lim_x, rate / spec.acc_lim_theta) + REST)
        curved = float(engine.yaws_gyro[0]) - gyro - turned
        side = side_for = slid = side_rolled = 0.0
        if spec.is_omni:
            side, side_for = _motion(AHEAD, spec.max_vel_y, spec.acc_lim_y)
            place, seen = engine.poses[0].copy(), float(engine.travels[0, 1])
            move(0.0, 0.0, side_for, side)
            move(0.0, 0.0, side / spec.acc_lim_y + REST)
            x, y = (engine.poses[0] - place)[:2].tolist()
            slid = math.cos(place[2]) * y - math.sin(place[2]) * x
            side_rolled = float(engine.travels[0, 1]) - seen
    finally:
        engine.close()
    carried = np.mean(loads, axis=0) / weight if weight > 0.0 else np.zeros(len(loads[0]))
    half = len(spec.wheels_left)
    sides = (float(carried[:half].sum()), float(carried[half:].sum()))
    left, right = sides if len(carried) else (0.5, 0.5)  # a drive without wheels of its own
    return Trial(
        way=speed * ahead_for,
        turn=rate * turn_for,
        ahead=float(middle[0] - begin[0]),
        aside=float(middle[1] - begin[1]),
        swerve=wrap_angle(float(middle[2] - begin[2])),
        turned=turned,
        strayed=float(np.hypot(*(end[:2] - middle[:2]))),
        curve=rate / 2.0 * CURVE_TIME,
        curved=curved,
        rolled=rolled,
        side=side * side_for,
        slid=slid,
        side_rolled=side_rolled,
        tilt=tilt,
        left=left,
        right=right,
        deepest=_deepest(spec, model),
        lost=_lost(spec, model),
    )


def _lost(spec: RobotSpec, model: RobotModel) -> tuple[str, float, float, float] | None:
    from swarm_sim.physics.bullet.probe import lacking_of_robot

    found = lacking_of_robot(model, spec)
    return None if found is None else (found[0], *found[1].tolist())


def _deepest(spec: RobotSpec, model: RobotModel) -> tuple[str, float] | None:
    base, wheels = base_and_wheels(model, spec)
    level = find_supports(base, wheels, spec).level
    return next((item for item in depths(base, level) if item[1] > SPRING), None)


def _motion(way: float, most: float, acceleration: float) -> tuple[float, float]:
    """Return a speed and for how long [s] to ask for it, to cover a way and stop behind it."""
    speed = min(most, math.sqrt(way * acceleration), acceleration * LONGEST)
    ticks = max(1, round(min(LONGEST, way / speed) / CONTROL_PERIOD))
    return speed, ticks * CONTROL_PERIOD


def _cause(trial: Trial, spec: RobotSpec, model: RobotModel) -> str:
    """Return why a robot does not drive, and what to do."""
    _, wheels = base_and_wheels(model, spec)
    gaps = heights(wheels, spec.wheel_radius)
    if len(gaps) and gaps.max() > SAG:
        joint = wheels[int(gaps.argmax())].joint
        return (
            f"Cause: wheel height: the wheel of joint {joint} ends {1000.0 * gaps.max():.0f} mm "
            "above the lowest one. Correct the origin of the joint, or name the wheels that stand "
            "on the ground in robot.yaml: wheels: {left: [...], right: [...]}"
        )
    if trial.deepest:
        link, depth = trial.deepest
        origin = model.origins.get("wheel_radius", "robot.yaml")
        return (
            f"Cause: caster, or wheels: link {link} reaches {1000.0 * depth:.0f} mm below the "
            f"driven wheels, and springs take up {1000.0 * SPRING:.0f} mm. Correct the origin of "
            f"its <collision>, or the wheels' radius, {spec.wheel_radius:.4g} m ({origin}), or "
            f"which wheels drive. {taken_for(spec, model)}"
        )
    if trial.stands and trial.goes_ahead and trial.turns and trial.curves:
        return (
            "Cause: drive: wheels that roll sideways are four, or the robot is moved as a whole; "
            f"these do not. {taken_for(spec, model)}"
        )
    x, y, z = _center(model)
    place = f"({x:.2f}, {y:.2f}, {z:.2f}) in base_footprint"
    if not trial.stands:
        return (
            f"Cause: inertia: the centre of mass is at {place}, so that the casters carry the "
            f"robot, or it tips over. Correct the <inertial> of the heavy links, or {CURE}"
        )
    rolls = abs(trial.rolled - trial.way) <= SHARE_OFF * trial.way + WAY_OFF
    if rolls and (not trial.goes_ahead or trial.turns):
        return (
            "Cause: friction: the wheels turn as told, and slip; they carry too little for the "
            f"accelerations (centre of mass at {place}). Lower acc_lim_x or acc_lim_theta in "
            f"robot.yaml, or {CURE}"
        )
    heaviest = max(model.groups, key=lambda group: float(np.max(group.inertia)))
    return (
        f"Cause: inertia: the motors do not move it as told; link {heaviest.name} has "
        f"{float(np.max(heaviest.inertia)):.3g} kg m² at {heaviest.mass:.3g} kg. Lower acc_lim_x "
        f"or acc_lim_theta in robot.yaml, correct the <inertial>, or {CURE}"
    )


def _center(model: RobotModel) -> tuple[float, float, float]:
    """Return the centre of mass [m] of a robot in base_footprint."""
    places = model.root_from_groups()
    total = sum(group.mass for group in model.groups)
    center = np.zeros(3)
    for group, place in zip(model.groups, places, strict=True):
        center += group.mass * (place[:3, :3] @ group.center + place[:3, 3])
    x, y, z = (center / total).tolist()
    return x, y, z


@functools.cache
def _code() -> list[bytes]:
    folder = Path(str(sys.modules[__name__].__file__)).parent
    return [(folder / f"{name}.py").read_bytes() for name in MODULES]


def _content(model: RobotModel) -> Iterator[str | bytes]:
    """Yield everything in a model that affects its motion."""
    for group in model.groups:
        yield repr((group.name, group.joint, group.parent, group.mass, group.links))
        for array in (group.parent_from_group, group.axis, group.center, group.inertia):
            yield np.ascontiguousarray(array, np.float64).tobytes()
        for part in group.parts:
            yield repr(part.shape)
            yield np.ascontiguousarray(part.body_from_part, np.float64).tobytes()
