"""Rooms, beacons and ideal unicycles: what a navigator needs to run without world and ROS."""

import functools
import math
from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from swarm_common.model.beacon import BEACON_DTYPE, FLAG_ACTIVE, BeaconArray, reception_of
from swarm_common.model.grid import OCCUPIED, Grid
from swarm_common.model.records import (
    CONTROL_PERIOD,
    Odometry,
    Pose,
    RobotSpec,
    Scan,
    Twist,
    wrap_angle,
)
from swarm_common.model.sites import Sites
from swarm_describe.robots.loading import load_robot
from swarm_nav.behaviour.navigator import Navigator
from swarm_nav.core.config import NavConfig, config_from_parameters
from swarm_nav.core.goals import Event, Goal, GoalEnded, GoalKind
from swarm_nav.perception.dynamic_obstacles import WALK_TICKS
from swarm_nav.reservation.tube import padded
from swarm_nav.traffic.robot_state import RobotState, initial_state

RADIUS = 0.285  # [m] safety radius of a waffle with the default margin
SUBSTEPS = 10


@functools.cache
def waffle() -> RobotSpec:
    return load_robot("turtlebot3_waffle")


NOTHING_SEEN = np.full(360, np.inf, np.float32)


def room(
    width: float, height: float, *walls: tuple[float, float, float, float], resolution: float = 0.05
) -> Grid:
    """Return a walled room from (0, 0); further walls are (x_min, y_min, x_max, y_max)."""
    cells = np.zeros((round(height / resolution), round(width / resolution)), np.int8)
    cells[0, :] = cells[-1, :] = cells[:, 0] = cells[:, -1] = OCCUPIED
    for x_min, y_min, x_max, y_max in walls:
        rows = slice(round(y_min / resolution), round(y_max / resolution))
        columns = slice(round(x_min / resolution), round(x_max / resolution))
        cells[rows, columns] = OCCUPIED
    return Grid(cells, resolution, 0.0, 0.0)


def without_lidar(parameters: NavConfig | None = None) -> NavConfig:
    return config_from_parameters({"costmap.scan_timeout": 0.0}, parameters)


def config(**changes: Any) -> NavConfig:
    """Return the default parameters with changes; `traffic__push_ticks` is traffic.push_ticks."""
    return config_from_parameters({k.replace("__", "."): v for k, v in changes.items()})


def robot_in(
    grid: Grid, pose: Pose, robot_id: int = 1, parameters: NavConfig | None = None
) -> RobotState:
    s = initial_state(parameters or NavConfig(), waffle(), grid, robot_id, pose)
    s.tick = 100
    return s


def beacon(robot_id: int, x: float, y: float, **fields: Any) -> np.void:
    """Return the beacon of a robot that stands at (x, y); `fields` replaces members.

    `held`, `wanted` and `intent` are lists of points, `priority` one number.
    """
    record = np.zeros(1, BEACON_DTYPE)[0]
    record["id"] = robot_id
    record["radius"] = RADIUS
    record["pose"] = (x, y, 0.0)
    record["flags"] = FLAG_ACTIVE
    record["target"] = record["station"] = (math.nan, math.nan)
    points = {"held": [(x, y)], "wanted": [], "intent": []}
    points |= {name: fields.pop(name) for name in tuple(points) if name in fields}
    for name, values in points.items():
        block = np.array(values, np.float64).reshape(-1, 2)
        record[name], record[f"{name}_size"] = padded(block, len(record[name]))
    priority = fields.pop("priority", 0)
    record["priority"] = (priority >> 32, priority & 0xFFFFFFFF)
    for name, value in fields.items():
        record[name] = value
    return record


def hear(s: RobotState, *beacons: np.void, tick: int | None = None) -> None:
    batch = np.array(list(beacons), BEACON_DTYPE)
    batch["tick"] = s.tick - 1 if tick is None else tick
    batch["heard"][:, 0] = s.robot_id << 16 | max(0, s.tick - 1)
    s.neighbors.receive(batch, s.pose.x, s.pose.y)
    s.neighbors.refresh(s.tick)


def let_walk(s: RobotState, *places: tuple[float, float]) -> None:
    history, marks = s.obstacles._dynamic_obstacles, np.array(places)
    history.update(marks, marks[:0], marks, marks, s.tick - WALK_TICKS)
    history.update(marks, marks, marks, marks, s.tick)
    history.clear()  # they are gone, but for where they walked


def seen(tick: int, *places: tuple[float, float]) -> list[np.void]:
    told = [beacon(90 + k, 1.0, 0.6 * k + 0.3, blocked_ticks=99) for k in range(len(places))]
    for k, (x, y) in enumerate(places):
        told[k]["sighted_id"][0], told[k]["sighted_tick"][0] = 30 + k, tick
        told[k]["sighted_at"][0] = (x, y)
    return told


@dataclass
class Unicycle:
    """Follows its commands exactly, within the acceleration limits of the drive."""

    pose: Pose
    twist: Twist = field(default_factory=Twist)
    spec: RobotSpec = field(default_factory=waffle)

    def step(self, command: Twist) -> None:
        """Advance one control period."""
        dt = CONTROL_PERIOD / SUBSTEPS
        v, w, pose = self.twist.vx, self.twist.wz, self.pose
        for _ in range(SUBSTEPS):
            v += max(-self.spec.acc_lim_x * dt, min(self.spec.acc_lim_x * dt, command.vx - v))
            change = self.spec.acc_lim_theta * dt
            w += max(-change, min(change, command.wz - w))
            yaw = pose.yaw + 0.5 * w * dt
            pose = Pose(
                pose.x + v * dt * math.cos(yaw),
                pose.y + v * dt * math.sin(yaw),
                wrap_angle(pose.yaw + w * dt),
            )
        self.pose, self.twist = pose, Twist(v, 0.0, w)


class Squad:
    """Navigators on ideal unicycles that hear each other's beacons one tick later."""

    def __init__(
        self,
        grid: Grid,
        poses: Sequence[Pose],
        parameters: NavConfig | None = None,
        sites: Sites | None = None,
        first_tick: int = 0,
        spec: RobotSpec | None = None,
    ) -> None:
        sites = sites or Sites()
        parameters = parameters or NavConfig()
        self.tick = first_tick
        spec = spec or waffle()
        self.bodies = [Unicycle(pose, spec=spec) for pose in poses]
        self.robots = [
            Navigator(parameters, spec, grid, sites, index + 1, pose)
            for index, pose in enumerate(poses)
        ]
        self.events: list[list[Event]] = [[] for _ in poses]
        self.beacons: list[np.void | None] = [None] * len(poses)
        self.extra_beacons: list[np.void] = []
        self.scan: Callable[[int, Pose], np.ndarray | None] = lambda index, pose: NOTHING_SEEN

    def send(
        self, index: int, *poses: Pose, kind: GoalKind = GoalKind.NAVIGATE, **fields: Any
    ) -> None:
        self.robots[index].set_goal(Goal(kind=kind, poses_map=poses, **fields))

    def run(self, ticks: int, deaf: Collection[int] = (), dead: Collection[int] = ()) -> None:
        """Advance; the deaf get no neighbours, the dead do nothing (indices)."""
        for _ in range(ticks):
            self._step(deaf, dead)

    def run_until(self, condition: Callable[[], bool], ticks: int, **kinds: Collection[int]) -> int:
        """Advance until `condition` holds; return the ticks taken, fail after `ticks`."""
        for count in range(ticks):
            if condition():
                return count
            self._step(kinds.get("deaf", ()), kinds.get("dead", ()))
        raise AssertionError(f"not so after {ticks} ticks: {[r.status() for r in self.robots]}")

    def ended(self, index: int) -> list[GoalEnded]:
        return [event for event in self.events[index] if isinstance(event, GoalEnded)]

    def distance(self, index: int, pose: Pose) -> float:
        return self.bodies[index].pose.distance(pose)

    def _step(self, deaf: Collection[int], dead: Collection[int]) -> None:
        sent = [b for b in self.beacons if b is not None] + self.extra_beacons
        for record in self.extra_beacons:
            record["tick"] = max(0, self.tick - 1)
            for index in range(len(self.robots)):  # such robots hear everything
                record["heard"][index] = index + 1 << 16 | max(0, self.tick - 2)
        outputs: dict[int, Twist] = {}
        published: list[np.void | None] = []
        for index, (robot, body) in enumerate(zip(self.robots, self.bodies, strict=True)):
            if index in dead:
                published.append(None)
                continue
            robot.on_odom(Odometry(self.tick, body.pose, body.twist))
            if index not in deaf:
                robot.on_reception(reception_of(self._others(sent, index + 1)))
            ranges = self.scan(index, body.pose)
            if ranges is not None:
                robot.on_scan(Scan(self.tick, 0.0, math.tau / len(ranges), 0.12, 3.5, ranges))
            output = robot.tick(self.tick)
            outputs[index] = output.twist
            published.append(output.beacon)
            self.events[index].extend(output.events)
        for index, body in enumerate(self.bodies):
            body.step(outputs.get(index, Twist()))
        self.beacons = published
        self.tick += 1

    @staticmethod
    def _others(sent: Sequence[np.void], own_id: int) -> BeaconArray:
        heard = [b for b in sent if int(b["id"]) != own_id]
        return np.array(sorted(heard, key=lambda b: int(b["id"])), BEACON_DTYPE)
