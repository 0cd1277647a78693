"""A world before it starts: scene, robots, starts and map, for the world process and the bench."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import TypeVar

from swarm_common.files.map_io import load_map, map_of_world
from swarm_common.model.errors import RobotModelError
from swarm_common.model.grid import Grid
from swarm_common.model.records import Pose, RobotSpec
from swarm_describe.robots.loading import Robot
from swarm_describe.worlds.scene import Scene
from swarm_sim.maps.draw_map import Reach, draw_world, with_touchable
from swarm_sim.maps.spawn import Start, check_apart, deal_places
from swarm_sim.sensing.lidar import overlooked
from swarm_sim.world.world import World, WorldConfig

W = TypeVar("W", bound=World)


@dataclass(frozen=True, slots=True, kw_only=True)
class WorldSetup:
    """A world that is ready to start; sequences have an entry per robot."""

    config: WorldConfig
    seed: int
    scene: Scene
    names: Sequence[str]
    specs: Sequence[RobotSpec]
    starts: Sequence[Pose]  # in map
    grid: Grid  # the map that the robots get
    robots: Mapping[str, Robot]  # bodies by `RobotSpec.model`; empty where nothing looks at them
    silent: Collection[int] = ()  # indices of robots that never do or say anything

    def start(self, world_class: type[W]) -> W:
        """Return the world at tick 0."""
        models = {name: robot.model for name, robot in self.robots.items()}
        return world_class(
            self.scene, self.specs, self.starts, self.config, self.seed, self.names, models
        )

    def unseen(self, margin: float, word: str) -> Iterator[str]:
        """Yield a sentence on each model whose LiDAR sees too little of the silent robots.

        Args:
            margin: [m] that robots allow for what their LiDARs do not see of a body.
            word: Word for a silent robot.
        """
        if not self.silent:
            return
        if not self.config.with_lidar or not self.robots:
            yield f"without LiDARs no robot sees the {word} ones: it may hit them"
            return
        living = [spec for index, spec in enumerate(self.specs) if index not in self.silent]
        silent = [self.specs[index] for index in sorted(self.silent)]
        models = {name: robot.model for name, robot in self.robots.items()}
        for sentence in overlooked(living, silent, models, margin):
            yield f"{sentence}: it may hit one that is {word}"


def starts_of(
    scene: Scene,
    specs: Sequence[RobotSpec],
    spawns: Sequence[Start],
    fixed_map: Sequence[Pose | None],
) -> list[Pose]:
    """Return where each robot starts: on its spawn's places in order, or where its user says.

    Args:
        fixed_map: Pose of each robot that stands where its user says; None for the others.

    Raises:
        WorldError: If there is no room.
    """
    free = [index for index, pose in enumerate(fixed_map) if pose is None]
    widest = max(specs, key=lambda spec: spec.circumscribed_radius)
    dealt = deal_places(scene, [specs[i] for i in free], [spawns[i] for i in free], widest)
    places = iter(dealt)
    poses = [pose or next(places) for pose in fixed_map]
    check_apart(poses, specs, scene.name)
    return poses


def map_of(
    scene: Scene, height: float, reach: Reach, starts: Sequence[Pose], grid: Grid | None = None
) -> Grid:
    """Return the map of a world with all that a robot of the swarm can touch.

    Args:
        height: [m] of the lowest LiDAR above the ground.
        reach: Heights between which robots can touch something.
        starts: Starts of the robots; a map that is drawn has open ground around them.
        grid: Upright map of the world; None to draw one.
    """
    if grid is None:
        return draw_world(scene, height, starts=starts, reach=reach)
    return with_touchable(grid, scene, height, reach)


def map_file_of(scene: Scene, chosen: str | None = None) -> Grid | None:
    """Return the map in a file, or in that which comes with a world; None without one."""
    path = chosen or map_of_world(scene.file)
    return None if path is None else load_map(path).upright().refined()


def check_model_names(models: Mapping[str, RobotSpec]) -> None:
    """Refuse two models of one name.

    Args:
        models: By their names or paths.

    Raises:
        RobotModelError: For the first two.
    """
    names: dict[str, str] = {}
    for path, spec in models.items():
        other = names.setdefault(spec.model, path)
        if other != path:
            raise RobotModelError(
                f"{other} and {path} are both models called '{spec.model}'; "
                "write another name into one's robot.yaml, model: ..."
            )
