"""Rigid-body engine: pybullet without a window, wheels turned by velocity motors."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
import pybullet

from swarm_common.model.records import CONTROL_PERIOD, FloatArray, Pose, RobotSpec
from swarm_common.model.shapes import Transform
from swarm_common.process.libm import arctan2
from swarm_describe.robots.description import RobotModel
from swarm_describe.worlds.scene import Body
from swarm_sim.physics.actors import Walkers
from swarm_sim.physics.bullet.bullet_kernels import ramp_all
from swarm_sim.physics.bullet.contacts import Contacts
from swarm_sim.physics.bullet.fixed_bodies import add_ground
from swarm_sim.physics.bullet.robot_bodies import Stance, add_robot, push, put, set_asleep, stance
from swarm_sim.physics.bullet.surroundings import Surroundings
from swarm_sim.physics.drive import Wheels, travelled
from swarm_sim.physics.engine import NearPair, Touch
from swarm_sim.physics.objects import Objects

REST_TICKS = 3  # of standstill before a robot is left out of the simulation
SETTLE_STEPS = 50  # in which the robots come to rest before tick 0


class BulletEngine:
    """Robots on wheels among fixed bodies; see `engine.Engine` for the attributes."""

    def __init__(
        self,
        bodies: Sequence[Body],
        specs: Sequence[RobotSpec],
        models: Sequence[RobotModel],
        poses: Sequence[Pose],
        physics_period: float,
        walkers: Walkers,
        objects: Objects,
    ) -> None:
        """Build the bodies and let them settle."""
        count = len(specs)
        self._steps = round(CONTROL_PERIOD / physics_period)
        self._period = physics_period
        self._client = pybullet.connect(pybullet.DIRECT)
        try:
            pybullet.setGravity(0.0, 0.0, -9.81, physicsClientId=self._client)
            self._ground = add_ground(self._client)
            self._around = Surroundings(self._client, physics_period, bodies, objects, walkers)
            self._robots = [
                add_robot(self._client, model, spec, pose)
                for model, spec, pose in zip(models, specs, poses, strict=True)
            ]
        except Exception:
            self.close()
            raise
        self._centers = np.array([robot.base_from_center for robot in self._robots])
        self._limits = np.array([[s.acc_lim_x, s.acc_lim_theta, s.acc_lim_y] for s in specs])
        self._wheels = [Wheels(spec) for spec in specs]
        self._sliders = [i for i, spec in enumerate(specs) if spec.drive != "differential"]
        self._wheelless = [i for i, robot in enumerate(self._robots) if not robot.wheels]
        self._speeds = np.zeros((count, 3))  # that the motors aim at
        self._rest_ticks = np.zeros(count, np.int64)  # for which each robot has stood
        self._joints = [np.zeros((2, len(wheels.names))) for wheels in self._wheels]
        self.poses: FloatArray = np.zeros((count, 3))
        self.twists: FloatArray = np.zeros((count, 3))
        self.travels: FloatArray = np.zeros((count, 2))
        self.yaws_gyro: FloatArray = np.zeros(count)
        self._contacts = Contacts(self._client, specs, [robot.body for robot in self._robots])
        self._surround()
        self._settle()

    @property
    def clearances(self) -> FloatArray:
        """(n, 2) to the nearest robot, obstacle; inf beyond NEAR."""
        return self._contacts.clearances

    @property
    def approaches(self) -> list[NearPair]:
        """Pairs closer than NEAR_MISS at the end of the control period."""
        return self._contacts.approaches

    def advance(self, targets: FloatArray) -> list[Touch]:
        """Run one control period towards target speeds."""
        touches: list[Touch] = []
        suspects = self._contacts.suspects()
        self._put_to_rest(targets)
        walkers, vehicles = self._around.walkers, self._around.objects.vehicles
        walkers.begin()
        vehicles.begin()
        guess = self.poses.copy()  # of the robots, for the walkers to look at
        for step in range(self._steps):
            self._drive(targets)
            self._walk(guess, step)
            pybullet.stepSimulation(physicsClientId=self._client)
            for suspect in suspects:
                touch = self._contacts.touch(suspect, step)
                if touch is not None:
                    touches.append(touch)
        touches += walkers.touches()
        touches += vehicles.touches()
        self._read()
        self._measure()
        return touches

    def add(self, spec: RobotSpec, model: RobotModel | None, pose: FloatArray) -> None:
        """Add a robot, which stands at a pose (3,)."""
        assert model is not None
        body = add_robot(self._client, model, spec, Pose(*pose.tolist()))
        index = len(self._robots)
        self._robots.append(body)
        self._wheels.append(Wheels(spec))
        self._joints.append(np.zeros((2, len(body.wheels))))
        if spec.drive != "differential":
            self._sliders.append(index)
        if not body.wheels:
            self._wheelless.append(index)
        self._centers = np.vstack([self._centers, body.base_from_center])
        limits = [spec.acc_lim_x, spec.acc_lim_theta, spec.acc_lim_y]
        self._limits = np.vstack([self._limits, limits])
        self._speeds = np.vstack([self._speeds, np.zeros(3)])
        self._rest_ticks = np.append(self._rest_ticks, 0)
        self.poses = np.vstack([self.poses, pose])
        self.twists = np.vstack([self.twists, np.zeros(3)])
        self.travels = np.vstack([self.travels, np.zeros(2)])
        self.yaws_gyro = np.append(self.yaws_gyro, 0.0)
        self._contacts.add(spec, body.body)
        self._set_motors([index])
        self._measure()

    def place(self, robot: int, pose: FloatArray) -> None:
        """Put a robot elsewhere, where it stands; wheels and gyro do not notice."""
        set_asleep(self._client, self._robots[robot], False)
        put(self._client, self._robots[robot], pose)
        self._rest_ticks[robot] = 0
        self._speeds[robot] = 0.0
        self.poses[robot], self.twists[robot] = pose, 0.0
        self._set_motors([robot])
        self._measure()

    def restart(self, robot: int) -> None:
        """Restart the readings of a robot's wheels and gyro at 0."""
        self.travels[robot], self.yaws_gyro[robot] = 0.0, 0.0

    def place_object(self, index: int, place: Transform) -> None:
        """Put something that can be pushed elsewhere."""
        self._around.bodies.put(index, place)
        self._contacts.move_objects(self._around.objects.outlines())
        self._measure()

    def add_object(self, body: Body) -> None:
        """Add a thing behind all that can be pushed."""
        self._around.add(body)
        self._surround()
        self._measure()

    def remove_object(self, index: int) -> None:
        """Remove a thing; those behind it move up."""
        self._around.remove(index)
        self._surround()
        self._measure()

    def _surround(self) -> None:
        around = self._around
        speeds = around.walkers.speeds
        self._contacts.surround(
            around.obstacles, around.outlines, around.reaches, speeds, around.tiles
        )

    def _measure(self) -> None:
        self._contacts.measure(self.poses, self._around.walkers.discs)

    def joint_state(self, robot: int) -> tuple[list[str], list[float], list[float]]:
        """Return the state of a robot's wheel joints."""
        positions, velocities = self._joints[robot].tolist()
        return list(self._robots[robot].joint_names), positions, velocities

    def stance(self, robot: int) -> Stance:
        """Return how a robot stands at the end of the last physics step."""
        return stance(self._client, self._robots[robot], self._ground)

    def close(self) -> None:
        """Disconnect; a second call does nothing."""
        if self._client >= 0:
            pybullet.disconnect(physicsClientId=self._client)
            self._client = -1

    def _walk(self, guess: FloatArray, step: int) -> None:
        """Let the walkers walk for one step among robots that move on as their motors aim."""
        around = self._around
        if around.is_still:
            return
        speed, turn, slide = self._speeds.T
        guess[:, 0] += speed * np.cos(guess[:, 2]) * self._period
        guess[:, 1] += speed * np.sin(guess[:, 2]) * self._period
        if self._sliders:
            guess[:, 0] -= slide * np.sin(guess[:, 2]) * self._period
            guess[:, 1] += slide * np.cos(guess[:, 2]) * self._period
        guess[:, 2] += turn * self._period
        if len(around.walkers):
            around.walkers.step(guess, speed, self._contacts.hulls, self._period, step)
            around.place_walkers()
        if len(around.objects.vehicles):
            around.objects.vehicles.step(guess, speed, self._contacts.hulls, self._period, step)
            around.bodies.place_vehicles()

    def _settle(self) -> None:
        self._set_motors(range(len(self._robots)))
        for _ in range(SETTLE_STEPS):
            pybullet.stepSimulation(physicsClientId=self._client)
        self._read()
        self.travels[:] = 0.0
        self.yaws_gyro[:] = 0.0
        self._measure()

    def _drive(self, targets: FloatArray) -> None:
        """Move the set speeds of the motors one physics step towards the targets."""
        changed = ramp_all(self._speeds, targets, self._limits, self._period)
        if changed.any():
            self._set_motors(np.flatnonzero(changed).tolist())
        for index in self._sliders:
            if self._rest_ticks[index] < REST_TICKS:
                push(self._client, self._robots[index], self._speeds[index], self._period)

    def _put_to_rest(self, targets: FloatArray) -> None:
        """Put robots to sleep that stand and shall stand; wake those that shall move."""
        before = self._rest_ticks >= REST_TICKS
        rests = ~(targets.any(axis=1) | self._speeds.any(axis=1))
        self._rest_ticks = np.where(rests, self._rest_ticks + 1, 0)
        after = self._rest_ticks >= REST_TICKS
        for index in np.flatnonzero(before != after):
            set_asleep(self._client, self._robots[index], bool(after[index]))

    def _set_motors(self, robots: Sequence[int]) -> None:
        for index, speeds in zip(robots, self._speeds[list(robots)].tolist(), strict=True):
            robot = self._robots[index]
            if not robot.wheels:
                continue
            rates = self._wheels[index].plain_rates(*speeds)
            pybullet.setJointMotorControlArray(
                robot.body,
                robot.wheels,
                pybullet.VELOCITY_CONTROL,
                targetVelocities=[
                    rate * sign for rate, sign in zip(rates, robot.signs.tolist(), strict=True)
                ],
                forces=[robot.torque] * len(robot.wheels),
                physicsClientId=self._client,
            )

    def _read(self) -> None:
        """Update poses, speeds and joints from the engine."""
        client = self._client
        if len(self._around.objects):
            self._around.bodies.read()
            self._contacts.move_objects(self._around.objects.outlines())
        places = np.empty((len(self._robots), 7))
        velocities = np.empty((len(self._robots), 6))
        for i, robot in enumerate(self._robots):
            position, quaternion = pybullet.getBasePositionAndOrientation(robot.body, client)
            places[i, :3], places[i, 3:] = position, quaternion
            linear, angular = pybullet.getBaseVelocity(robot.body, client)
            velocities[i, :3], velocities[i, 3:] = linear, angular
            if not robot.wheels:
                continue
            states = pybullet.getJointStates(robot.body, robot.wheels, client)
            joints = np.array([state[:2] for state in states]).T
            rolled = (joints[0] - self._joints[i][0]) * robot.signs
            self.travels[i] += self._wheels[i].travel(rolled)
            self._joints[i] = joints
        x, y, z, w = places[:, 3], places[:, 4], places[:, 5], places[:, 6]
        yaw = arctan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z))
        cos, sin = np.cos(yaw), np.sin(yaw)
        turned = yaw - self.poses[:, 2]
        self.yaws_gyro += turned - 2.0 * math.pi * np.round(turned / (2.0 * math.pi))
        before = self.poses.copy() if self._wheelless else self.poses
        self.poses[:, 0] = places[:, 0] - cos * self._centers[:, 0] + sin * self._centers[:, 1]
        self.poses[:, 1] = places[:, 1] - sin * self._centers[:, 0] - cos * self._centers[:, 1]
        self.poses[:, 2] = yaw
        for i in self._wheelless:
            self.travels[i] += travelled(before[i], self.poses[i])
        self.twists[:, 0] = cos * velocities[:, 0] + sin * velocities[:, 1]
        self.twists[:, 1] = velocities[:, 5]
        if self._sliders:
            at_center = cos * velocities[:, 1] - sin * velocities[:, 0]
            sideways = at_center - velocities[:, 5] * self._centers[:, 0]
            self.twists[self._sliders, 2] = sideways[self._sliders]  # of skid-steer ones about 0
