"""A world in which robots come and go, and robots and things are put elsewhere, between ticks.

Indices stay: a robot that was taken out keeps its row and is absent. Its body is parked far away,
where nothing senses it and it senses nothing; the others' state is carried over bit by bit.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from swarm_common.model.breaches import Collision
from swarm_common.model.records import FloatArray, Pose, RobotSpec, Twist
from swarm_common.model.shapes import Transform
from swarm_describe.robots.description import RobotModel
from swarm_describe.worlds.scene import Body
from swarm_sim.sensing.lidar import overlooked
from swarm_sim.sensing.radio import standing_beacon
from swarm_sim.world.world import World

PARKED = 1e6  # [m] from the origin
PARKING_PITCH = 100.0  # [m] between two that are parked


class ChangingWorld(World):
    """See `World`; call what changes it only between `step` and `observe`."""

    @property
    def present(self) -> list[int]:
        """Indices of the robots that are there."""
        return [robot for robot in range(len(self.specs)) if robot not in self.absent]

    @property
    def heights(self) -> tuple[float, float]:
        """Heights [m] between which things are obstacles to robots."""
        return self._objects.heights

    def overlooked(self, margin: float) -> list[str]:
        """Return whose LiDAR sees nothing, or too little, of which other model, a sentence each."""
        specs = [self.specs[robot] for robot in self.present]
        if self._lidars is None or len(specs) == 1:
            return []
        return list(overlooked(specs, specs, self._models, margin))

    def step(
        self, commands: Sequence[Twist | None], beacons: Sequence[np.void | None]
    ) -> list[Collision]:
        """Advance one tick; see `World.step`.

        Args:
            commands: One per robot, present or not; None if it sent none. Those of absent robots do
                not count.
        """
        if self.absent:
            commands = [Twist() if i in self.absent else c for i, c in enumerate(commands)]
            beacons = [None if i in self.absent else b for i, b in enumerate(beacons)]
        for robot, beacon in enumerate(beacons):
            if beacon is not None:
                self.last_beacons[robot] = beacon
        return super().step(commands, beacons)

    def add(self, name: str, robot_id: int, spec: RobotSpec, model: RobotModel, pose: Pose) -> int:
        """Add a robot; return its index."""
        place = _array(pose)
        engine = self._engine
        self.names.append(name)
        self.specs.append(spec)
        self._models.setdefault(spec.model, model)
        self._walkers.add_robot(spec)
        self._objects.vehicles.add_robot(spec)
        sensors = self._motion_sensors.extended(
            self.specs, self._errors(), engine.travels, engine.yaws_gyro
        )
        self._motion_sensors = sensors
        engine.add(spec, model, place)
        self._commands.add(spec)
        self._odometer.add()
        self._radio.add()
        self._radio.welcome(robot_id)
        self._judge.add(name, place)
        self._standstill.add()
        self._batteries.add(len(self.specs) - 1, spec.battery)
        self.last_beacons.append(None)
        self._renew_lidars()
        return len(self.specs) - 1

    def remove(self, robot: int, robot_id: int) -> None:
        """Remove a robot; its row stays."""
        self.absent.add(robot)
        self._batteries.set_present(robot, False)
        self.place(robot, Pose(PARKED + PARKING_PITCH * robot, PARKED, 0.0))
        self._radio.forget(robot_id, self.tick)
        self.last_beacons[robot] = None
        self._renew_lidars()

    def readmit(self, robot: int, robot_id: int, pose: Pose) -> None:
        """Return a removed robot to the world; its odometry begins again at 0."""
        self.absent.discard(robot)
        self._batteries.set_present(robot, True)
        self._engine.restart(robot)
        self._motion_sensors.restart(robot)
        self._odometer.restart(robot)
        self._radio.welcome(robot_id)
        self.place(robot, pose)
        self._renew_lidars()

    def place(self, robot: int, pose: Pose) -> None:
        """Put a robot elsewhere, where it stands; its odometry does not notice."""
        place = _array(pose)
        self._engine.place(robot, place)
        self._commands.stop(robot)
        self._judge.place(robot, place)
        if self._lidars is not None:
            self._lidars.forget(robot, place)

    def speak_for(self, robot: int, robot_id: int, pose: Pose) -> None:
        """Tell all where a robot stands that was put there and does not know it yet.

        One that never said where it is holds no space: all are told to forget it.
        """
        last = self.last_beacons[robot]
        if last is None:
            self._radio.forget(robot_id, self.tick)
        else:
            self.last_beacons[robot] = beacon = standing_beacon(last, pose)
            self._radio.speak_for(robot, beacon)

    def let_speak(self, robot_id: int) -> None:
        """Let a robot that was spoken for be heard again."""
        self._radio.welcome(robot_id)

    @property
    def loose(self) -> tuple[Body, ...]:
        """Bodies that can be pushed, and objects spawned at run time, at their first poses."""
        return self._objects.loose

    def place_of(self, index: int) -> Transform:
        """Return where something loose is now."""
        return self._objects.place_of(index)

    def place_object(self, index: int, place: Transform) -> None:
        """Put something loose elsewhere."""
        self._engine.place_object(index, place)

    def add_object(self, body: Body) -> int:
        """Add a thing, which can be pushed unless it is static; return its index.

        Whether there is room is not checked here.
        """
        self._engine.add_object(body)
        self._watch_objects()
        return len(self.loose) - 1

    def remove_object(self, index: int) -> None:
        """Remove something loose; those behind it move up."""
        self._engine.remove_object(index)
        self._watch_objects()

    def _watch_objects(self) -> None:
        if self._lidars is not None:
            self._lidars.watch(self._objects)

    def _renew_lidars(self) -> None:
        if self._lidars is not None:
            lidars = self._make_lidars()
            lidars.remember(self._lidars, self._engine.poses)
            self._lidars = lidars


def _array(pose: Pose) -> FloatArray:
    return np.array([pose.x, pose.y, pose.yaw], np.float64)
