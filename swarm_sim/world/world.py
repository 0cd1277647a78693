"""The world in lockstep: observe all robots at a tick, take their commands, advance one tick."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from swarm_common.files.convert import updated
from swarm_common.model.battery import READING_TICKS, BatteryReading
from swarm_common.model.beacon import BeaconArray, Reception
from swarm_common.model.breaches import Collision
from swarm_common.model.engines import check_engine, usual_engine
from swarm_common.model.errors import ConfigError, UnknownNameError
from swarm_common.model.records import (
    CONTROL_PERIOD,
    FloatArray,
    Odometry,
    Pose,
    RobotSpec,
    Scan,
    Twist,
    value_type,
)
from swarm_common.model.robot_names import RobotNames
from swarm_common.model.sensors import IDEAL, SensorErrors
from swarm_describe.robots.description import RobotModel
from swarm_describe.robots.loading import open_robot, taken_for
from swarm_describe.worlds.scene import GROUND_GAP, Body, Scene
from swarm_sim.physics.actors import Vehicles, Walkers
from swarm_sim.physics.drive import CommandBuffer, Odometer
from swarm_sim.physics.engine import Engine
from swarm_sim.physics.objects import Objects
from swarm_sim.physics.planar import PlanarEngine
from swarm_sim.scene.randomness import normal
from swarm_sim.scene.section import section_between
from swarm_sim.sensing import radio_kernels
from swarm_sim.sensing.lidar import Lidars
from swarm_sim.sensing.motion_sensors import Imu, MotionSensors
from swarm_sim.sensing.radio import Radio, RadioConfig
from swarm_sim.world.batteries import Batteries
from swarm_sim.world.verdict import Judge, Standstill, Verdict
from swarm_sim.world.zone_watch import ZoneWatch

ENGINES = ("bullet", "planar")
MAX_NOISE = 0.2  # of the speeds
NOISE_WORD = 73  # what a random number is for


@dataclass(frozen=True, slots=True, kw_only=True)
class WorldConfig:
    """Parameters of the simulation."""

    # bullet: rigid bodies on wheels; planar: kinematic, fast
    engine: str = field(default_factory=usual_engine)
    physics_period: float = 0.01  # [s] of a physics step
    with_lidar: bool = True
    actuation_noise: float = 0.0  # standard deviation of each speed, as a share of it, per tick
    radio: RadioConfig = field(default_factory=RadioConfig)
    realistic: bool = False  # sensors err as each robot's `sensors:` section says
    sensors: Mapping[str, Any] = field(default_factory=dict)  # in place of what it says

    def __post_init__(self) -> None:
        if self.engine not in ENGINES:
            raise UnknownNameError("engine", self.engine, ENGINES)
        check_engine(self.engine, f"engine {self.engine}")
        if not 0.0 <= self.actuation_noise <= MAX_NOISE:
            raise ConfigError(
                f"actuation_noise is {self.actuation_noise}; expected 0 to {MAX_NOISE}"
            )
        updated(IDEAL, self.sensors, "sensors")
        steps = CONTROL_PERIOD / self.physics_period if self.physics_period > 0.0 else 0.0
        if steps < 1.0 or abs(steps - round(steps)) > 1e-6:
            raise ConfigError(
                f"physics_period is {self.physics_period} s; "
                f"it must divide the control period of {CONTROL_PERIOD} s"
            )


@value_type
class Observation:
    """Readings of one robot's sensors at a tick."""

    odom: Odometry  # every tick
    scan: Scan | None  # when a revolution of its LiDAR ends at this tick, else None
    reception: Reception  # beacons heard, ordered by id
    battery: BatteryReading | None = None  # once a second of a robot that has one

    @property
    def neighbors(self) -> BeaconArray:
        """The beacons heard, copied."""
        return self.reception.beacons


class World:
    """Physics, sensors, radio and ground truth of a swarm; knows no ROS.

    Attributes:
        scene: Scene in which the robots are.
        absent: Indices of robots that were taken out.
        last_beacons: Newest beacon of each robot, kept where the world changes; None without one.
    """

    def __init__(
        self,
        scene: Scene,
        specs: Sequence[RobotSpec],
        poses: Sequence[Pose],
        config: WorldConfig | None = None,
        seed: int = 0,
        names: Sequence[str] | None = None,
        models: Mapping[str, RobotModel] | None = None,
    ) -> None:
        """Place the robots and begin at tick 0.

        Args:
            config: Parameters of the simulation; None for the defaults.
            names: Names of the robots, for verdicts; None for the usual ones.
            models: Descriptions by `RobotSpec.model`; default those in `robots/`.

        Raises:
            ValueError: If there are not as many models as poses.
        """
        if len(specs) != len(poses):
            raise ValueError(f"{len(specs)} robot models but {len(poses)} poses")
        config = config or WorldConfig()
        self.names = list(names or RobotNames().first(len(specs)))
        self.specs = list(specs)
        self._config = config
        self._tick = 0
        self._seed = seed
        if models is None and (config.with_lidar or config.engine == "bullet"):
            models = {spec.model: open_robot(spec.model).model for spec in specs}
        models = models or {}
        self._walkers = Walkers(scene.walkers, specs, poses, seed)
        heights = (GROUND_GAP, max([spec.height for spec in specs], default=1.0))
        self._objects = Objects(scene.loose, Vehicles(scene.vehicles, specs, poses, seed), heights)
        self.scene, self._models = scene, dict(models)
        self.absent: set[int] = set()
        self.last_beacons: list[np.void | None] = [None] * len(specs)
        for name, spec in {spec.model: spec for spec in specs}.items():
            if name in models:
                self.check_model(spec, models[name])
        self._engine = _make_engine(
            scene, specs, poses, models, config, self._walkers, self._objects
        )
        self._motion_sensors = MotionSensors(specs, self._errors(), seed)
        self._lidars = self._make_lidars() if config.with_lidar else None
        self._commands = CommandBuffer(specs)
        self._odometer = Odometer(len(specs))
        self._radio = Radio(config.radio, len(specs), seed)
        self._judge = Judge(self.names, self._engine.poses, self._engine.clearances)
        self._standstill = Standstill(len(specs))
        self._zone_watch = ZoneWatch(scene.sites.zones) if scene.sites.zones else None
        chargers = list(scene.sites.chargers.values())
        self._batteries = Batteries([spec.battery for spec in specs], chargers, seed)

    def check_model(self, spec: RobotSpec, model: RobotModel) -> None:
        """Check that a robot model drives in this world's physics engine, whatever it looks like.

        Raises:
            RobotModelError: If it does not; the message names cause and cure.
        """
        if self._config.engine == "bullet":
            from swarm_sim.physics.trial import check_trial  # pybullet is slow to import

            check_trial(spec, model, self._config.physics_period)

    def errors_of(self, spec: RobotSpec) -> SensorErrors:
        """Return how the sensors of a robot model err in this world."""
        config = self._config
        own = spec.sensors if config.realistic else IDEAL
        return updated(own, config.sensors, "sensors")

    def _errors(self) -> list[SensorErrors]:
        return [self.errors_of(spec) for spec in self.specs]

    def _make_lidars(self) -> Lidars:
        bodies = {name: model.bodies() for name, model in self._models.items()}
        carried = [bodies[spec.model] for spec in self.specs]
        walkers = len(self._walkers)
        lidars = Lidars(
            self.scene, self.specs, carried, self._seed, walkers, self._errors(), self.absent
        )
        lidars.watch(self._objects)
        return lidars

    @property
    def tick(self) -> int:
        """Control ticks since the start."""
        return self._tick

    @property
    def sim_time(self) -> float:
        """Simulated time [s]."""
        return round(self._tick * CONTROL_PERIOD, 6)

    @property
    def verdict(self) -> Verdict:
        """Ground truth about the run so far."""
        verdict = self._judge.verdict(self.sim_time, self._batteries.verdict)
        watch = self._zone_watch
        return verdict if watch is None else replace(verdict, zones=watch.verdict)

    @property
    def collisions(self) -> Sequence[Collision]:
        """Contact episodes so far; cheaper than `verdict`."""
        return self._judge.collisions

    def motionless(self) -> Iterator[str]:
        """Yield a sentence on each robot that is told to drive and never moves, once."""
        for robot, told in self._standstill.new(self._judge.distances):
            spec = self.specs[robot]
            about = taken_for(spec, self._models[spec.model]) if spec.model in self._models else ""
            yield (
                f"{self.names[robot]} does not move: it was told to drive {told:.1f} m, and went "
                f"{self._judge.distances[robot]:.2f} m. {about}"
            )

    def observe(self) -> list[Observation]:
        """Return the readings of each robot's sensors at the present tick."""
        scans: dict[int, Scan] = {}
        if self._lidars is not None:
            scans = self._lidars.due(self._tick, self._engine.poses, self._walkers.discs)
        twists = self._motion_sensors.twists(self._engine.twists)
        readings = self._odometer.readings(self._tick, twists)
        supplies: dict[int, BatteryReading] = {}
        if self._batteries and self._tick % READING_TICKS == 0:
            supplies = self._batteries.readings(self._tick)
        return [
            Observation(odom, scans.get(i), self._radio.reception(i), supplies.get(i))
            for i, odom in enumerate(readings)
        ]

    def step(
        self, commands: Sequence[Twist | None], beacons: Sequence[np.void | None]
    ) -> list[Collision]:
        """Advance one tick; return the collisions that began in it.

        Args:
            commands: One per robot; None if it sent none. Its last command then holds until
                it is 0.5 s old.
            beacons: One per robot; None if it sent none.
        """
        known = len(self._judge.collisions)
        if self._batteries:
            commands, beacons = self._batteries.silenced(commands, beacons)
        self._radio.send(self._tick, beacons, self._engine.poses[:, :2])
        targets = self._commands.update(commands)
        self._standstill.observe(targets)
        touches = self._engine.advance(self._disturbed(targets))
        engine = self._engine
        self._odometer.update(
            *self._motion_sensors.update(
                self._tick, engine.travels, engine.yaws_gyro, engine.twists
            )
        )
        self._judge.observe(
            self._tick * CONTROL_PERIOD,
            self._config.physics_period,
            touches,
            self._engine.poses,
            self._engine.clearances,
            self._engine.approaches,
        )
        self._tick += 1
        if self._zone_watch is not None:
            speeds = np.hypot(engine.twists[:, 0], engine.twists[:, 2])
            self._zone_watch.observe(self.sim_time, self.names, self.specs, engine.poses, speeds)
        if self._batteries:
            self._batteries.update(self._tick, engine.poses, engine.twists)
        return list(self._judge.collisions[known:])

    def _disturbed(self, targets: FloatArray) -> FloatArray:
        """Return the speeds (n, 3) that the drives make of those aimed at."""
        noise = self._config.actuation_noise
        if noise == 0.0:
            return targets
        words = np.empty(targets.shape, np.uint64)
        radio_kernels.draw((self._seed, NOISE_WORD, self._tick), words)
        disturbed: FloatArray = targets * (1.0 + noise * normal(words))
        return disturbed

    def ground_truth(self) -> list[tuple[Pose, Twist]]:
        """Return the true pose in the map frame and twist of each robot."""
        return [
            (
                Pose(float(pose[0]), float(pose[1]), float(pose[2])),
                Twist(float(twist[0]), float(twist[2]), float(twist[1])),
            )
            for pose, twist in zip(self._engine.poses, self._engine.twists, strict=True)
        ]

    def imu(self, robot: int) -> Imu:
        """Return the reading of a robot's IMU at the present tick."""
        return self._motion_sensors.imu(robot, self._tick)

    @property
    def poses(self) -> FloatArray:
        """True x, y, yaw (n, 3) in map; not to be changed."""
        return self._engine.poses

    @property
    def clearances(self) -> FloatArray:
        """Distances (n, 2) [m] to the nearest robot, obstacle; inf beyond `engine.NEAR`."""
        return self._engine.clearances

    def walkers(self) -> FloatArray:
        """Return where the walkers are (m, 3): x, y, radius [m] in map."""
        return self._walkers.discs.copy()

    @property
    def walker_names(self) -> list[str]:
        """Names of the walkers, as collisions name them."""
        return [spec.name for spec in self._walkers.specs]

    def objects(self) -> list[Body]:
        """Return movable objects and vehicles at their present places."""
        return self._objects.bodies()

    def joint_states(self, robot: int) -> tuple[list[str], list[float], list[float]]:
        """Return names, positions [rad] and velocities [rad/s] of a robot's joints."""
        return self._engine.joint_state(robot)

    def close(self) -> None:
        """Release what the physics engine holds."""
        self._engine.close()


def _make_engine(
    scene: Scene,
    specs: Sequence[RobotSpec],
    poses: Sequence[Pose],
    models: Mapping[str, RobotModel],
    config: WorldConfig,
    walkers: Walkers,
    objects: Objects,
) -> Engine:
    if config.engine == "planar":
        section = section_between(scene.fixed, *objects.heights)
        return PlanarEngine(section, specs, poses, config.physics_period, walkers, objects)
    from swarm_sim.physics.bullet.bullet_engine import BulletEngine  # pybullet is slow to import

    return BulletEngine(
        scene.fixed,
        specs,
        [models[spec.model] for spec in specs],
        poses,
        config.physics_period,
        walkers,
        objects,
    )
