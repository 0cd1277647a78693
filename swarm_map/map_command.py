"""Command `swarm-map`: draws maps of worlds, checks maps, makes worlds from floor plans."""

from __future__ import annotations

import dataclasses
import enum
import json
import shlex
from functools import partial
from pathlib import Path
from typing import Annotated

import numpy as np
import typer
from rich.console import Console

from swarm_common.files.map_io import load_map, save_map
from swarm_common.model.engines import BULLET, usual_engine
from swarm_common.model.errors import ConfigError, MapError
from swarm_common.model.grid import FREE, OCCUPIED, UNKNOWN
from swarm_common.model.records import RobotSpec
from swarm_describe.robots.loading import load_robot
from swarm_describe.worlds.other_worlds import YAML, YamlKind, check_plan_kind, yaml_kind
from swarm_describe.worlds.reader import load_world
from swarm_describe.worlds.scene import Scene
from swarm_describe.worlds.world_file import SITES_FILE, world_names
from swarm_map.floor_plan import FloorPlan, load_plan
from swarm_map.grid_map import load_grid_map
from swarm_map.layout import layout_of, load_layout
from swarm_map.plan_image import MAX_PIXELS, PlanScale, WallRaster, load_picture
from swarm_map.preview import write_preview
from swarm_map.remarks import close_stations, size_of, stations_in_words, with_known_stations
from swarm_map.start import USUAL_SIZE, open_area, start_area, startable
from swarm_map.world_writer import ROBOT, write_world
from swarm_sim.maps.draw_map import SCAN_HEIGHT, draw_world, reach_of
from swarm_sim.maps.map_difference import MAX_SHARE, compare
from swarm_sim.maps.world_check import differences, picture

FOREIGN = (".xml", ".geojson", ".svg", ".dxf", ".osm", ".pdf", ".csv")  # endings of what is none
LAYOUTS = (".lif", ".json")  # endings of files in LIF
NAME_RULE = "expected letters, digits, _ and -"


class PlanKind(enum.Enum):
    """Kind of plan from which a world is made."""

    YAML = "a floor plan in YAML"
    PICTURE = "a picture"
    NAV2_MAP = "a map of Nav2's"
    GRID = "a .map grid"
    LAYOUT = "a layout of a fleet control"


OPTIONS = {  # of `swarm-map new`: what they are for
    "resolution": (PlanKind.PICTURE, PlanKind.GRID, PlanKind.YAML, PlanKind.LAYOUT),
    "origin": (PlanKind.PICTURE,),
    "wall_height": (PlanKind.PICTURE, PlanKind.NAV2_MAP, PlanKind.GRID, PlanKind.LAYOUT),
    "drop": (PlanKind.PICTURE, PlanKind.NAV2_MAP),
    "cell": (PlanKind.GRID,),
    "scenario": (PlanKind.GRID,),
    "layout": (PlanKind.LAYOUT,),
}
DRAW_EXAMPLES = """Example:

swarm-map draw warehouse --output maps
"""
CHECK_EXAMPLES = """Examples:

swarm-map check warehouse

swarm-map check worlds/hall/world.sdf maps/hall.yaml
"""
EXPORT_EXAMPLES = """Example:

swarm-map export slim_blockage --vda5050-layout slim_blockage.lif
"""
NEW_EXAMPLES = """Examples:

swarm-map new hall.yaml

swarm-map new plan.png --resolution 0.05 --wall-height 3 --force
"""
leaving_out = partial(typer.Option, rich_help_panel="Worlds that are not complete")
of_kind = partial(typer.Option, rich_help_panel="For some kinds of plan")
map_app = typer.Typer(
    no_args_is_help=True,
    help="Maps and worlds.",
    epilog="Example: swarm-map new plan.png",
    rich_markup_mode="rich",
)
console = Console(highlight=False, soft_wrap=True, markup=False)

World = Annotated[str, typer.Argument(help="Name of a world, or path of a .sdf or .world file.")]
Height = Annotated[float, typer.Option(help="Height of the LiDAR's plane above the ground, in m.")]
Resolution = Annotated[float, typer.Option(help="Size of a cell, or of a picture's pixel, in m.")]
SkipMissing = Annotated[
    bool, leaving_out("--skip-missing", help="Leave out models and meshes that are not found.")
]
SkipBroken = Annotated[
    bool, leaving_out("--skip-broken", help="Leave out models that are unusable.")
]


@map_app.command(epilog=DRAW_EXAMPLES)
def draw(
    world: World,
    output: Annotated[Path, typer.Option("-o", "--output", help="Folder to write to.")] = Path("."),
    height: Annotated[
        float | None,
        typer.Option(
            help="Of a LiDAR's plane above the ground, in m: only what that cuts.",
            show_default="all that a TurtleBot3 waffle can touch",
        ),
    ] = None,
    resolution: Resolution = 0.05,
    skip_missing: SkipMissing = False,
    skip_broken: SkipBroken = False,
) -> None:
    """Draw the map of a world: NAME.yaml and NAME.pgm for Nav2."""
    _check(0.001 <= resolution <= 1.0, f"--resolution is {resolution}; expected 0.001 to 1 m")
    _check(
        height is None or 0.0 < height < 100.0,
        f"--height is {height}; expected more than 0, less than 100 m",
    )
    scene = _load(world, skip_missing, skip_broken)
    if height is None:
        grid = draw_world(scene, SCAN_HEIGHT, resolution, reach=reach_of([load_robot(ROBOT)]))
    else:
        grid = draw_world(scene, height, resolution)
    path = output / f"{scene.name}.yaml"
    try:
        output.mkdir(parents=True, exist_ok=True)
        save_map(grid, path)
    except OSError as cause:
        raise MapError(f"cannot write {path}: {cause}") from cause
    console.print(f"{path}: {grid.width} x {grid.height} cells of {resolution:g} m")


@map_app.command(epilog=CHECK_EXAMPLES)
def check(
    world: World,
    map_: Annotated[
        Path | None, typer.Argument(metavar="MAP", help="Map yaml.", show_default="none; see below")
    ] = None,
    output: Annotated[
        Path, typer.Option("-o", "--output", help="Picture of the differences.")
    ] = Path("map_difference.png"),
    height: Height = SCAN_HEIGHT,
    max_share: Annotated[
        float, typer.Option(help="Share of the occupied cells that may disagree.")
    ] = MAX_SHARE,
    skip_missing: SkipMissing = False,
    skip_broken: SkipBroken = False,
) -> None:
    """Compare a map with a world, and draw where they differ.

    Without a map: compare the world as map, LiDARs and physics engine represent it with the
    triangles in its files. This also happens when a world is first started.

    Exit code: 0 they agree; 1 more than --max-share of the occupied cells disagree; 2 bad input.
    """
    _check(0.0 <= max_share <= 1.0, f"--max-share is {max_share}; expected 0 to 1")
    scene = _load(world, skip_missing, skip_broken)
    robot = load_robot(ROBOT)
    if map_ is None:
        _check_triangles(scene, robot, height, output)
        return
    difference = compare(scene, load_map(map_), height, reach_of([robot]))
    difference.save_picture(output)
    agrees = difference.agrees(max_share)
    verdict = "agrees with" if agrees else "does not show"
    console.print(f"{map_} {verdict} world {scene.name}: {difference.describe()}")
    console.print(f"picture: {output}")
    if not agrees:
        raise typer.Exit(1)


@map_app.command(epilog=EXPORT_EXAMPLES)
def export(
    world: World,
    vda5050_layout: Annotated[
        Path, typer.Option(help="File to write: stations, places and circuits as LIF (JSON).")
    ],
    robot: Annotated[str, typer.Option(help="Robot model that is to fit along the edges.")] = ROBOT,
    skip_missing: SkipMissing = False,
    skip_broken: SkipBroken = False,
) -> None:
    """Write what other programs need of a world: nodes and edges for a fleet control."""
    scene = _load(world, skip_missing, skip_broken)
    spec = load_robot(robot)
    grid = draw_world(scene, SCAN_HEIGHT, 0.05, reach=reach_of([spec]))
    layout = layout_of(scene.name, scene.sites, grid, spec.circumscribed_radius, spec.model)
    try:
        vda5050_layout.write_text(json.dumps(layout, indent=1), encoding="utf-8")
    except OSError as cause:
        raise ConfigError(f"cannot write {vda5050_layout}: {cause}") from cause
    parts = layout["layouts"][0]
    counts = ", ".join(f"{len(parts[part])} {part}" for part in ("nodes", "edges", "stations"))
    console.print(f"{vda5050_layout}: {counts}")


@map_app.command(epilog=NEW_EXAMPLES)
def new(
    context: typer.Context,
    plan: Annotated[
        Path,
        typer.Argument(
            help="Floor plan: a YAML file, a picture (.png), a map of Nav2's, a .map grid, or a "
            "layout of a fleet control (.lif, .json)."
        ),
    ],
    output: Annotated[
        Path, typer.Option("-o", "--output", help="Folder in which the world's folder is created.")
    ] = Path("."),
    name: Annotated[
        str | None, typer.Option(help="Name of the world.", show_default="the plan's")
    ] = None,
    resolution: Resolution = 0.05,
    origin: Annotated[
        tuple[float, float] | None,
        of_kind(help="x y of a picture's lower left corner, in m.", show_default="centred"),
    ] = None,
    wall_height: Annotated[float, of_kind(help="Height of the walls in a picture, in m.")] = 2.5,
    drop: Annotated[
        float,
        of_kind(
            help="Leave out dark spots of a picture that are no longer and no wider, in m: "
            "text and noise of a scan."
        ),
    ] = 0.0,
    cell: Annotated[float, of_kind(help="Size of a cell of a .map grid, in m.")] = 1.0,
    scenario: Annotated[
        Path | None,
        of_kind("--scen", help="MovingAI .scen file with the starts and goals of a .map."),
    ] = None,
    layout: Annotated[
        str | None, of_kind(metavar="ID", help="layoutId in a file with several layouts.")
    ] = None,
    force: Annotated[bool, typer.Option("--force", help="Overwrite existing files.")] = False,
) -> None:
    """Make a world from a floor plan: world.sdf, sites.yaml, and its map.

    A map of Nav2's (its .yaml) becomes walls wherever it is occupied, at the same places.
    In a picture dark pixels are walls, each green spot is a station, and a blue area is where the
    robots start; with --force, stations keep the names that sites.yaml gives them. A
    stations.csv beside the picture names stations by the colour of their spots.
    docs/creating.md describes the YAML. A .map is a grid of the Moving AI Lab's
    benchmarks; the mission own_place drives its .scen. A layout (LIF) becomes an empty
    hall with its stations; its other nodes are places, and it is kept in layout.json.
    """
    scale = PlanScale(resolution=resolution, origin=origin, wall_height=wall_height, drop=drop)
    _check(plan.is_file(), f"there is no floor plan {plan}")
    kind = _kind_of(plan)
    for option, kinds in OPTIONS.items():
        origin_of_value = context.get_parameter_source(option)
        given = origin_of_value is not None and origin_of_value.name == "COMMANDLINE"
        flag = "scen" if option == "scenario" else option.replace("_", "-")
        fits = " or ".join(usable.value for usable in kinds)
        _check(not given or kind in kinds, f"--{flag} is for {fits}; {plan} is {kind.value}")
    if kind is PlanKind.GRID:
        floor = load_grid_map(plan, cell, scenario, wall_height)
    elif kind is PlanKind.LAYOUT:
        floor = load_layout(plan, wall_height, layout)
    elif kind is PlanKind.NAV2_MAP:
        floor, resolution = load_nav2_map(plan, wall_height, drop)
    else:
        floor = load_plan(plan) if kind is PlanKind.YAML else load_picture(plan, scale)
    if name is not None:
        _check(name.replace("_", "").replace("-", "").isalnum(), f"--name is '{name}'; {NAME_RULE}")
        floor = dataclasses.replace(floor, name=name)
    folder = output / floor.name
    if folder.exists() and any(folder.iterdir()) and not force:
        raise ConfigError(f"{folder} is not empty; give another --name, or --force to overwrite")
    if kind is PlanKind.PICTURE and (folder / SITES_FILE).is_file():
        floor = with_known_stations(floor, folder / SITES_FILE)
    try:
        scene = write_world(floor, folder, resolution)
        count, reason = startable(scene)
        area = None if count or "spawn" in floor.sites else start_area(scene)
        if area is not None:
            floor = dataclasses.replace(floor, sites={**floor.sites, "spawn": area})
            scene = write_world(floor, folder, resolution)
            count, reason = startable(scene)
    except ConfigError as error:  # a note may say why
        raise ConfigError("; ".join((str(error), *filter(None, floor.notes)))) from error
    width, depth = size_of(scene)
    sites = scene.sites
    console.print(
        f"{folder}: {width:.1f} x {depth:.1f} m, {len(scene.bodies)} bodies, "
        f"{'a' if sites.spawn else 'no'} spawn area, "
        f"{len(sites.stations)} station{'s' * (len(sites.stations) != 1)}"
    )
    for line in (stations_in_words(scene), *floor.notes, *close_stations(scene)):
        if line:
            console.print(f"  {line}")
    console.print(f"  picture: {write_preview(scene)}")
    if count < USUAL_SIZE:
        console.print(f"  room for {count} robots: {reason}")
    if count:
        world = shlex.quote(_as_world(folder))
        console.print(f"start robots with\n  swarm-up --world {world} --swarm-size {count}")


def _kind_of(plan: Path) -> PlanKind:
    suffix = plan.suffix.lower()
    if suffix == ".map":
        return PlanKind.GRID
    if suffix in LAYOUTS:
        return PlanKind.LAYOUT
    if suffix in FOREIGN:
        raise ConfigError(
            f"{plan} is no plan; expected a picture, YAML, LIF (.json) or .map (MAPF)"
        )
    if suffix not in YAML:
        return PlanKind.PICTURE
    if yaml_kind(plan) is YamlKind.NAV2_MAP:
        return PlanKind.NAV2_MAP
    check_plan_kind(plan)
    return PlanKind.YAML


def _as_world(folder: Path) -> str:
    """Return what `--world` takes for a folder, also where a world that ships has its name."""
    is_shipped = len(folder.parts) == 1 and folder.name in world_names()
    return f"./{folder}" if is_shipped or str(folder).startswith("-") else str(folder)


def _check_triangles(scene: Scene, robot: RobotSpec, height: float, output: Path) -> None:
    reach = reach_of([robot])
    with_physics = usual_engine() == BULLET
    found = list(differences(scene, [height], reach, with_physics=with_physics))
    picture(scene, reach).save_picture(output)
    for difference in found:
        console.print(f"  {difference}, {difference.count} points")
    verdict = "differ from" if found else "are those of"
    compared = "map, LiDAR and physics" if with_physics else "map and LiDAR"
    console.print(
        f"{compared} {verdict} the triangles of world {scene.name}: "
        f"{len(scene.fixed)} bodies, {reach[0]:g} to {reach[1]:g} m above ground"
    )
    console.print(f"picture: {output}")
    if found:
        raise typer.Exit(1)


def _load(world: str, skip_missing: bool, skip_broken: bool) -> Scene:
    scene = load_world(world, skip_missing=skip_missing, skip_broken=skip_broken)
    for note in scene.notes:
        console.print(note, style="dim")
    return scene


def _check(is_fine: bool, message: str) -> None:
    if not is_fine:
        raise ConfigError(message)


def load_nav2_map(path: Path, wall_height: float, drop: float = 0.0) -> tuple[FloorPlan, float]:
    """Return the plan that a map is, in the frame of the map, and the map's resolution [m].

    Args:
        drop: [m]; occupied spots that are no longer and no wider are left out.
    """
    turned = load_map(path)
    if turned.cells.size > MAX_PIXELS:
        raise ConfigError(f"{path}: {turned.cells.size} cells; expected at most {MAX_PIXELS:.0e}")
    grid = turned.upright()
    raster = WallRaster(path, grid.cells == OCCUPIED, grid.resolution, grid.origin_x, grid.origin_y)
    if not raster.walls.any():
        raise ConfigError(f"{path}: no cell is occupied, by its image, thresholds and negate")
    notes = raster.drop_specks(drop)
    others = np.count_nonzero(turned.cells == UNKNOWN)
    if others:
        notes.append(f"unknown cells of {path} are floor: {others} of {turned.cells.size}")
    if np.any((turned.cells > FREE) & (turned.cells < OCCUPIED)):
        notes.append(f"cells of {path} between free and occupied are floor")
    if turned.origin_yaw:
        notes.append(f"{path} is turned by {turned.origin_yaw:g} rad; its walls are stairs here")
    sites = {"spawn": spawn} if (spawn := open_area(grid)) else {}
    return FloorPlan(path.stem, raster.things(wall_height), sites, tuple(notes)), grid.resolution
