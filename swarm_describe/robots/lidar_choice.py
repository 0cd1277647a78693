"""Choice of the LiDAR among a description's ray sensors, and how it is mounted."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from swarm_common.model.errors import RobotModelError
from swarm_common.model.shapes import Transform
from swarm_describe.robots.description import RobotModel
from swarm_describe.robots.gazebo_tags import RaySensor

TILT = 0.1  # [rad] by which a scan plane may lean
FEWEST_RAYS = 8  # of a LiDAR; a sensor with fewer is a range finder
NARROWEST = 0.5  # [rad] field of view of a LiDAR
AHEAD = math.pi / 4.0  # [rad] to either side, where a robot drives to
MOSTLY = 0.5  # share of that view, from which a LiDAR looks ahead
AS_GOOD = 0.9  # of the most rays times range, from which a LiDAR is as good as the best
LOOKS = 721  # directions in which its view is looked at
POSE = ("x", "y", "z")


@dataclass(frozen=True, slots=True)
class _Candidate:
    sensor: RaySensor
    place: Transform  # base_from_sensor

    @property
    def rays(self) -> int:
        return int(self.sensor.values.get("rays", 360.0))

    @property
    def view(self) -> float:
        """Field of view [rad]."""
        return abs(self.sensor.values.get("angle_increment", math.tau / 360.0)) * (self.rays - 1)

    @property
    def tilt(self) -> float:
        """Angle [rad] between the scan plane and the ground."""
        return math.acos(min(1.0, abs(float(self.place[2, 2]))))

    @property
    def refusal(self) -> str:
        """Why it cannot be a LiDAR, empty if it may be one."""
        if self.sensor.layers > 1:
            return f"{self.sensor.layers} layers of rays"
        if self.rays < FEWEST_RAYS or self.view < NARROWEST:
            return f"{self.rays} rays within {math.degrees(self.view):.0f} degrees"
        return ""

    @property
    def reach(self) -> float:
        """Rays times range [m]."""
        return self.rays * float(self.sensor.values.get("range_max", 3.5))

    @property
    def ahead(self) -> float:
        """Share of `AHEAD` on either side of straight ahead that it sees."""
        first = self.sensor.values.get("angle_min", 0.0)
        turn = math.atan2(self.place[1, 0], self.place[0, 0])
        side = -1.0 if self.place[2, 2] < 0.0 else 1.0
        angles = turn + side * (first + np.linspace(0.0, self.view, LOOKS))
        off = np.abs((angles + math.pi) % math.tau - math.pi)
        width = self.view * float((off < AHEAD).mean())
        return round(min(1.0, width / (2.0 * AHEAD)), 1)

    @property
    def rank(self) -> tuple[float, float, float, float]:
        """Return a sort key: what looks ahead, then level ones, higher ones, those in front."""
        x, z = round(float(self.place[0, 3]), 3), round(float(self.place[2, 3]), 3)
        return self.ahead, -round(self.tilt, 3), z, x

    def __str__(self) -> str:
        reach = self.sensor.values.get("range_max", 3.5)
        return f"{self.sensor.link} ({self.rays} rays, {reach:g} m)"


def choose_lidar(
    model: RobotModel, sensors: Sequence[RaySensor], asked: Mapping[str, Any], where: str
) -> tuple[dict[str, Any], list[str]]:
    """Return the values of a `LidarSpec` as far as they follow, and notes on the choice."""
    frame = asked.get("frame")
    if frame is not None and frame not in model.fixed and not _is_posed(asked):
        raise RobotModelError(
            f"{where}: the LiDAR's link '{frame}' is none of the body's: {sorted(model.fixed)}"
        )
    known = [
        _Candidate(sensor, model.fixed[sensor.link] @ sensor.pose)
        for sensor in sensors
        if sensor.link in model.fixed and frame in (None, sensor.link)
    ]
    fit = [one for one in known if frame is not None or not one.refusal]
    level = fit if _is_posed(asked) else [one for one in fit if one.tilt <= TILT]
    if not level:
        if known and not _is_posed(asked):
            raise RobotModelError(f"{where}: {_refusals(known, fit)}")
        return (_values(model.fixed[frame], frame, where) if frame in model.fixed else {}), []
    best = _best(level)
    values = dict(best.sensor.values) | _values(best.place, best.sensor.link, where, best.tilt)
    return values, _notes(best, [one for one in known if one is not best], values)


def _best(candidates: Sequence[_Candidate]) -> _Candidate:
    """Return the LiDAR: one that looks ahead, with the most rays times range.

    Those with nearly as many are as good; among them the `rank` decides, and the first of equals.
    """
    looking = [one for one in candidates if one.ahead >= MOSTLY] or list(candidates)
    most = max(one.reach for one in looking)
    return max((one for one in looking if one.reach >= AS_GOOD * most), key=lambda one: one.rank)


def _is_posed(asked: Mapping[str, Any]) -> bool:
    return all(name in asked for name in POSE)


def _values(place: Transform, link: str, where: str, tilt: float | None = None) -> dict[str, Any]:
    """Return how a sensor is mounted, in the names of a `LidarSpec`."""
    x, y, z = place[:3, 3].tolist()
    yaw = math.atan2(place[1, 0], place[0, 0])
    values = {"x": x, "y": y, "z": z, "yaw": yaw, "frame": link}
    if place[2, 2] < 0.0:
        values["upside_down"] = True
    if tilt is None and abs(place[2, 2]) < math.cos(TILT):
        raise RobotModelError(f"{where}: {_tilted(link, math.acos(abs(place[2, 2])))}")
    return values


def _tilted(link: str, tilt: float) -> str:
    return (
        f"the LiDAR on link '{link}' is tilted by {math.degrees(tilt):.0f} degrees; write the "
        "pose of its scan plane into robot.yaml, lidar: {x: ..., y: ..., z: ..., yaw: ...}"
    )


def _refusals(known: Sequence[_Candidate], fit: Sequence[_Candidate]) -> str:
    """Return why none of the sensors is a LiDAR."""
    if fit:
        best = _best(fit)
        return _tilted(best.sensor.link, best.tilt)
    found = ", ".join(f"{one.sensor.link} ({one.refusal})" for one in known)
    return (
        f"none of its ray sensors is a planar LiDAR: {found}; write one into robot.yaml, "
        "lidar: {x: ..., y: ..., z: ..., rays: ..., range_max: ..., rate: ...}"
    )


def _notes(best: _Candidate, others: Sequence[_Candidate], values: Mapping[str, Any]) -> list[str]:
    notes = []
    if others:
        why = [
            f"{one}: {one.refusal or (f'tilted by {math.degrees(one.tilt):.0f} degrees')}"
            if one.refusal or one.tilt > TILT
            else str(one)
            for one in others
        ]
        notes.append(
            f"{best} is the LiDAR, not {', '.join(why)}; lidar: {{frame: ...}} in robot.yaml "
            "chooses another"
        )
    if values.get("upside_down"):
        notes.append(f"the LiDAR on link {best.sensor.link} hangs upside down")
    return notes
