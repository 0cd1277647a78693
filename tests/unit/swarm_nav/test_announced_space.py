"""Braking ends in the space that a robot announces, whatever happens to it on the way."""

import copy
import dataclasses
import math
import random

import numpy as np
import pytest

from swarm_common.model.records import CONTROL_PERIOD, Pose, Twist, wrap_angle
from swarm_describe.robots.fleet import limits_of
from swarm_describe.robots.loading import load_robot
from swarm_nav.control.dwa_kernels import held_gap
from swarm_nav.core.config import config_from_parameters
from swarm_nav.core.goals import GoalKind
from tests.fakes.navigation import NOTHING_SEEN, Squad, room

DEVIATION = 0.04  # [m] from the announced polyline; two safety margins are made for 0.037
FINE = 10  # steps of a period
WAFFLE = load_robot("turtlebot3_waffle")
FAST = dataclasses.replace(WAFFLE, max_vel_x=1.0, max_vel_theta=1.5, acc_lim_theta=2.0)


class Body:
    """A drive that ramps, in fine steps, as that of the planar engine."""

    def __init__(self, pose, spec):
        self.pose, self.twist, self.spec = pose, Twist(), spec
        self.command = Twist()
        self.track: list[tuple[float, float]] = []

    def step(self, command):
        self.command = command
        step = CONTROL_PERIOD / FINE
        ramps = [limit * step for limit in (self.spec.acc_lim_x, self.spec.acc_lim_y or 0.0)]
        turn = self.spec.acc_lim_theta * step
        vx, vy, wz, pose = self.twist.vx, self.twist.vy, self.twist.wz, self.pose
        for _ in range(FINE):
            vx += max(-ramps[0], min(ramps[0], command.vx - vx))
            vy += max(-ramps[1], min(ramps[1], command.vy - vy))
            wz += max(-turn, min(turn, command.wz - wz))
            yaw = pose.yaw + 0.5 * wz * step
            x = pose.x + step * (vx * math.cos(yaw) - vy * math.sin(yaw))
            y = pose.y + step * (vx * math.sin(yaw) + vy * math.cos(yaw))
            pose = Pose(x, y, wrap_angle(pose.yaw + wz * step))
            self.track.append((x, y))
        self.pose, self.twist = pose, Twist(vx, vy, wz)

    def way_to_stop(self, command):
        """Return the places that it passes with a command for a period, and braking after it."""
        body = copy.copy(self)
        body.track = []
        body.step(command)
        while math.hypot(body.twist.vx, body.twist.vy) > 1e-9:
            body.step(Twist())
        return body.track


class Trial:
    """One robot in a room, to which things happen at random."""

    def __init__(self, spec, seed):
        parameters = config_from_parameters({**limits_of(spec), "costmap.scan_timeout": 0.0})
        self.squad = Squad(room(6.0, 5.0), [Pose(1.5, 2.5, 0.0)], parameters, spec=spec)
        self.body = self.squad.bodies[0] = Body(Pose(1.5, 2.5, 0.0), spec)
        self.robot = self.squad.robots[0]
        self.rng = random.Random(seed)
        self.crate: tuple[float, float] | None = None
        self.until = {"deaf": 0, "crate": 0}
        self.squad.scan = self.scan

    def scan(self, index, pose):
        if self.crate is None:
            return NOTHING_SEEN
        lidar = pose.compose(Pose(self.body.spec.lidar.x, 0.0, 0.0))
        angles = lidar.yaw + np.arange(360) * math.tau / 360
        dx, dy = self.crate[0] - lidar.x, self.crate[1] - lidar.y
        along = dx * np.cos(angles) + dy * np.sin(angles)
        half = 0.06**2 - (dx * dx + dy * dy - along * along)
        is_hit = (half > 0.0) & (along > 0.0)
        return np.where(is_hit, along - np.sqrt(np.maximum(half, 0.0)), np.inf).astype(np.float32)

    def goal(self):
        yaw = self.rng.choice((math.nan, self.rng.uniform(-3.0, 3.0)))
        return Pose(self.rng.uniform(1.0, 5.0), self.rng.uniform(1.0, 4.0), yaw)

    def happen(self):
        what = self.rng.choice(
            ("goal", "cancel", "deaf", "pose", "back up", "again", "crate", "replan")
        )
        tick, pose = self.squad.tick, self.body.pose
        match what:
            case "goal":
                self.squad.send(0, self.goal())
            case "cancel":
                self.robot.services.cancel_goal()
            case "deaf":
                self.until["deaf"] = tick + self.rng.randint(1, 6)
            case "pose":
                self.robot.services.on_initial_pose(self.robot.pose_map)
            case "back up":
                self.squad.send(0, kind=GoalKind.BACKUP, distance=0.4, speed=0.15)
            case "again":
                self.robot.services.deactivate()
                self.robot.services.activate()
            case "crate":
                angle = pose.yaw + self.rng.uniform(-1.5, 1.5)
                far = self.rng.uniform(0.45, 0.9)
                self.crate = pose.x + far * math.cos(angle), pose.y + far * math.sin(angle)
                self.until["crate"] = tick + 20
            case "replan":
                self.robot._goal_manager.replan()
        return what

    def worst(self, ticks):
        """Return the largest distance [m] of a way to stop from what is announced, when and why."""
        worst: tuple[float, int, list[str]] = (0.0, 0, [])
        what: list[str] = []
        for tick in range(ticks):
            if tick == self.until["crate"]:
                self.crate = None
                self.robot.services.clear_costmap()
            if tick > 25 and self.robot.services.goal_id is None and self.rng.random() < 0.2:
                self.squad.send(0, self.goal())
            if tick > 25 and self.rng.random() < 0.03:
                what = [*what[-2:], f"{tick} {self.happen()}"]
            before = copy.copy(self.body)
            self.squad.run(1, deaf=(0,) if tick < self.until["deaf"] else ())
            beacon = self.squad.beacons[0]
            held = np.ascontiguousarray(beacon["held"][: beacon["held_size"]], np.float64)
            track = before.way_to_stop(self.body.command)
            off = max(held_gap(held, len(held) - 1, x, y) for x, y in track)
            if off > worst[0]:
                worst = off, tick, what
        return worst


@pytest.mark.parametrize(
    "seed", [0, 1, *(pytest.param(k, marks=pytest.mark.long) for k in range(2, 40))]
)
@pytest.mark.parametrize("model", ["turtlebot3_waffle", "carrier", "linorobot2_mecanum", "fast"])
def test_braking_ends_in_the_announced_space(model, seed):
    spec = FAST if model == "fast" else load_robot(model)
    trial = Trial(spec, seed)
    off, tick, what = trial.worst(400)
    assert off <= DEVIATION, f"{off:.4f} m at tick {tick}, after {what}"
