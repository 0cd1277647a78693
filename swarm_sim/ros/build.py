"""Construction of a world from the settings: everything that can be rejected is rejected here."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from swarm_common.files.map_io import load_map, map_of_world
from swarm_common.model.errors import ConfigError, MapError, RobotModelError
from swarm_common.model.grid import Grid
from swarm_common.model.records import Pose, RobotSpec
from swarm_describe.robots.description import RobotModel
from swarm_describe.robots.loading import Robot, open_robot
from swarm_describe.worlds.actors import load_actors
from swarm_describe.worlds.reader import load_world
from swarm_describe.worlds.scene import Scene
from swarm_sim.maps.check import check_map, check_sites, check_vehicles, check_walkers
from swarm_sim.maps.draw_map import Reach, draw_world, reach_of, with_touchable
from swarm_sim.maps.map_difference import compare
from swarm_sim.maps.passages import check_ways
from swarm_sim.maps.spawn import check_apart, deal_places
from swarm_sim.maps.world_check import checked
from swarm_sim.ros.settings import RobotEntry, Settings
from swarm_sim.sensing.visibility import overlooked
from swarm_sim.world.changing_world import ChangingWorld
from swarm_sim.world.world import WorldConfig

PICTURE = "map_difference.png"


@dataclass(frozen=True, slots=True)
class WorldSetup:
    """A world that is ready to run."""

    scene: Scene  # what the world file says
    world: ChangingWorld  # physics, sensors and radio
    grid: Grid  # the map that the robots get
    specs: tuple[RobotSpec, ...]  # model of each robot
    urdfs: tuple[str, ...]  # description of each robot
    poses_map: tuple[Pose, ...]  # where each robot starts
    unseen: tuple[str, ...]  # whose LiDAR sees too little of broken robots, a sentence each


def build(settings: Settings) -> WorldSetup:
    """Return the world that the settings ask for."""
    scene = load_world(
        settings.world,
        skip_missing=settings.skip_missing,
        skip_broken=settings.skip_broken,
        sites=settings.sites,
    )
    if settings.actors is not None:
        actors = load_actors(settings.actors)
        scene = dataclasses.replace(scene, walkers=actors.walkers, vehicles=actors.vehicles)
    robots = _robots(settings)
    specs = tuple(_spec_of(entry, robots) for entry in settings.robots)
    notes = [f"{r.spec.model}: {note}" for r in robots.values() for note in r.model.notes]
    models = {robot.spec.model: robot.model for robot in robots.values()}
    unseen = tuple(_unseen(settings, specs, models))
    notes += unseen
    widest = max(specs, key=lambda spec: spec.circumscribed_radius)
    notes += check_sites(scene, widest, settings.stations)
    scene = dataclasses.replace(scene, notes=(*scene.notes, *notes))
    check_walkers(scene, scene.walkers)
    check_vehicles(scene, scene.vehicles)
    poses = _places(scene, specs, settings)
    check_ways(scene, specs, poses)
    scene = checked(
        scene,
        [spec.lidar.z for spec in specs],
        reach_of(specs),
        with_physics=settings.engine == "bullet",
        skip_broken=settings.skip_broken,
    )
    grid = _map(settings, scene, specs, poses)
    scene.sites.zones.mark(grid)  # raises for a zone that lies beside it
    _check_starts(grid, poses, settings)
    _check_names(scene, settings)
    world = ChangingWorld(
        scene,
        specs,
        poses,
        WorldConfig(
            engine=settings.engine,
            with_lidar=settings.with_lidar,
            radio=settings.radio,
            actuation_noise=settings.actuation_noise,
            realistic=settings.realistic,
            sensors=settings.sensors,
        ),
        settings.seed,
        settings.names.listed,
        models,
    )
    if all(robot.broken_at is None for robot in settings.robots):
        scene = dataclasses.replace(
            scene, notes=(*scene.notes, *silent_notes(world, settings.body_margin))
        )
    urdfs = tuple(robots[entry.model].urdf for entry in settings.robots)
    return WorldSetup(scene, world, grid, specs, urdfs, tuple(poses), unseen)


def _check_names(scene: Scene, settings: Settings) -> None:
    """Raise ConfigError for the first robot that is called like something of the world."""
    things = {body.name.partition("::")[0] for body in (*scene.fixed, *scene.loose)}  # models
    things |= {walker.name for walker in scene.walkers}
    things |= {vehicle.name for vehicle in scene.vehicles}
    for name in settings.names.listed:
        if name in things:
            raise ConfigError(
                f"a robot and something of world '{settings.world}' are both called '{name}';"
                " give the robots other names (--names, or names: in the fleet)"
            )


def _spec_of(entry: RobotEntry, robots: Mapping[str, Robot]) -> RobotSpec:
    spec = robots[entry.model].spec
    return spec if entry.battery is None else dataclasses.replace(spec, battery=entry.battery)


def silent_notes(world: ChangingWorld, margin: float) -> list[str]:
    """Return whose LiDAR would see too little of one that falls silent, a sentence each."""
    end = "it may hit one that falls silent and that it never heard"
    return [f"{sentence}: {end}" for sentence in world.overlooked(margin)]


def _unseen(
    settings: Settings, specs: Sequence[RobotSpec], models: Mapping[str, RobotModel]
) -> Iterator[str]:
    """Yield a sentence on each model whose LiDAR sees too little of the broken robots."""
    works = [robot.broken_at is None for robot in settings.robots]
    if all(works):
        return
    if not settings.with_lidar:
        yield "without LiDARs no robot sees the broken ones: it may hit them"
        return
    seers, broken = ([s for s, w in zip(specs, works, strict=True) if w == it] for it in (1, 0))
    for sentence in overlooked(seers, broken, models, settings.body_margin):
        yield f"{sentence}: it may hit one that is broken"


def _robots(settings: Settings) -> dict[str, Robot]:
    """Return each model once, by its name or path."""
    robots = {name: open_robot(name) for name in dict.fromkeys(r.model for r in settings.robots)}
    names: dict[str, str] = {}
    for path, robot in robots.items():
        other = names.setdefault(robot.spec.model, path)
        if other != path:
            raise RobotModelError(
                f"{other} and {path} are both models called '{robot.spec.model}'; "
                "write another name into one's robot.yaml, model: ..."
            )
    return robots


def _places(scene: Scene, specs: Sequence[RobotSpec], settings: Settings) -> list[Pose]:
    """Return where each robot starts: working ones on their spawn's places in order."""
    robots = settings.robots
    works = [robot.broken_at is None for robot in robots]
    starts = [
        r.start or settings.spawn for r, is_working in zip(robots, works, strict=True) if is_working
    ]
    own = [spec for spec, is_working in zip(specs, works, strict=True) if is_working]
    widest = max(specs, key=lambda spec: spec.circumscribed_radius)
    places = iter(deal_places(scene, own, starts, widest))
    poses = [robot.broken_at or next(places) for robot in robots]
    check_apart(poses, specs, scene.name)  # broken ones stand where their user says
    return poses


def _map(
    settings: Settings, scene: Scene, specs: Sequence[RobotSpec], starts: Sequence[Pose]
) -> Grid:
    """Return the map: the user's, the one that ships with the world, or one drawn from it.

    It shows all that a robot of the swarm can touch.
    """
    scan_height, reach = min(spec.lidar.z for spec in specs), reach_of(specs)
    path = Path(settings.map) if settings.map is not None else map_of_world(scene.file)
    if path is None:
        return draw_world(scene, scan_height, starts=starts, reach=reach)
    grid = load_map(path).upright().refined()
    try:
        check_map(scene, grid, scan_height, reach)
    except MapError as error:
        raise MapError(f"{error}{_picture(settings, scene, grid, scan_height, reach)}") from error
    return with_touchable(grid, scene, scan_height, reach)


def _check_starts(grid: Grid, poses: Sequence[Pose], settings: Settings) -> None:
    """Raise MapError for the first robot that would start beside the map."""
    for robot, pose in zip(settings.robots, poses, strict=True):
        if grid.contains(pose.x, pose.y):
            continue
        x, y = grid.origin_x, grid.origin_y
        height, width = (cells * grid.resolution for cells in grid.cells.shape)
        raise MapError(
            f"{robot.name} would start at ({pose.x:.2f}, {pose.y:.2f}), beside the map of world "
            f"'{settings.world}', which reaches from ({x:.2f}, {y:.2f}) to ({x + width:.2f}, "
            f"{y + height:.2f}); let it start elsewhere (spawn: in sites.yaml, start: in the "
            "fleet), or take a larger map"
        )


def _picture(settings: Settings, scene: Scene, grid: Grid, height: float, reach: Reach) -> str:
    """Draw where a map is wrong into the folder of the run; return a remark on it."""
    if settings.verdict_path is None:
        return ""
    path = Path(settings.verdict_path).with_name(PICTURE)
    compare(scene, grid, height, reach).save_picture(path)
    return f"; picture of where: {path}"
