"""Construction of a world from the settings: everything that can be rejected is rejected here."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from swarm_common.model.errors import ConfigError, MapError
from swarm_common.model.grid import Grid
from swarm_common.model.records import Pose, RobotSpec
from swarm_describe.robots.loading import open_robot
from swarm_describe.worlds.actors import load_actors
from swarm_describe.worlds.reader import load_world
from swarm_describe.worlds.scene import Scene
from swarm_sim.maps.check import check_map, check_sites, check_vehicles, check_walkers
from swarm_sim.maps.draw_map import Reach, reach_of
from swarm_sim.maps.map_difference import compare
from swarm_sim.maps.passages import check_ways
from swarm_sim.maps.world_check import checked
from swarm_sim.ros.settings import RobotEntry, Settings
from swarm_sim.world.changing_world import ChangingWorld
from swarm_sim.world.setup import WorldSetup, check_model_names, map_file_of, map_of, starts_of

PICTURE = "map_difference.png"
BROKEN = "broken"  # word for a robot that never does or says anything


def build(settings: Settings) -> tuple[WorldSetup, ChangingWorld]:
    """Return the world that the settings ask for, and what it was made from."""
    scene = load_world(
        settings.world,
        skip_missing=settings.skip_missing,
        skip_broken=settings.skip_broken,
        sites=settings.sites,
    )
    if settings.actors is not None:
        actors = load_actors(settings.actors)
        scene = replace(scene, walkers=actors.walkers, vehicles=actors.vehicles)
    entries = settings.robots
    robots = {name: open_robot(name) for name in dict.fromkeys(entry.model for entry in entries)}
    check_model_names({name: robot.spec for name, robot in robots.items()})
    specs = [_spec_of(entry, robots[entry.model].spec) for entry in entries]
    widest = max(specs, key=lambda spec: spec.circumscribed_radius)
    site_notes = check_sites(scene, widest, settings.stations)
    check_walkers(scene, scene.walkers)
    check_vehicles(scene, scene.vehicles)
    broken = [entry.broken_at for entry in entries]
    starts = starts_of(scene, specs, [entry.start or settings.spawn for entry in entries], broken)
    check_ways(scene, specs, starts)
    heights, reach = [spec.lidar.z for spec in specs], reach_of(specs)
    scene = checked(
        scene,
        heights,
        reach,
        with_physics=settings.engine == "bullet",
        skip_broken=settings.skip_broken,
    )
    setup = WorldSetup(
        config=settings,
        seed=settings.seed,
        scene=scene,
        names=settings.names.listed,
        specs=specs,
        starts=starts,
        grid=_map(settings, scene, min(heights), reach, starts),
        robots={robot.spec.model: robot for robot in robots.values()},
        silent=[index for index, pose in enumerate(broken) if pose is not None],
    )
    scene.sites.zones.mark(setup.grid)  # raises for a zone that lies beside it
    _check_starts(setup, settings)
    _check_names(scene, settings)
    world = setup.start(ChangingWorld)
    notes = [f"{r.spec.model}: {note}" for r in robots.values() for note in r.model.notes]
    notes += [*setup.unseen(settings.body_margin, BROKEN), *site_notes]
    if not setup.silent:
        notes += silent_notes(world, settings.body_margin)
    return replace(setup, scene=replace(scene, notes=(*scene.notes, *notes))), world


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


def _spec_of(entry: RobotEntry, spec: RobotSpec) -> RobotSpec:
    return spec if entry.battery is None else replace(spec, battery=entry.battery)


def silent_notes(world: ChangingWorld, margin: float) -> list[str]:
    """Return whose LiDAR would see too little of one that falls silent, a sentence each."""
    end = "it may hit one that falls silent and that it never heard"
    return [f"{sentence}: {end}" for sentence in world.overlooked(margin)]


def _map(
    settings: Settings, scene: Scene, height: float, reach: Reach, starts: Sequence[Pose]
) -> Grid:
    """Return the map: the user's, the one that ships with the world, or one drawn from it."""
    grid = map_file_of(scene, settings.map)
    if grid is not None:
        try:
            check_map(scene, grid, height, reach)
        except MapError as error:
            picture = _picture(settings, scene, grid, height, reach)
            raise MapError(f"{error}{picture}") from error
    return map_of(scene, height, reach, starts, grid)


def _check_starts(setup: WorldSetup, settings: Settings) -> None:
    """Raise MapError for the first robot that would start beside the map."""
    grid = setup.grid
    for robot, pose in zip(settings.robots, setup.starts, strict=True):
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
