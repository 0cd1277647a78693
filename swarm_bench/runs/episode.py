"""Everything that a run needs, made from a scenario: world, map, drivers and missions."""

from __future__ import annotations

import dataclasses
import functools
import itertools
import math
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from swarm_bench.runs.inputs import read_once
from swarm_bench.runs.methods import METHODS, OF_NAVIGATORS, load_method, load_team
from swarm_bench.runs.orders import BenchOrders, make_orders
from swarm_bench.runs.scenario import Scenario, Size
from swarm_central.link import Centre, delay_ticks
from swarm_central.movingai import check_program
from swarm_common.files.params_io import REALISTIC, default_parameters
from swarm_common.files.zones_io import load_lanes
from swarm_common.model.central import Coordination
from swarm_common.model.errors import ConfigError
from swarm_common.model.grid import Grid
from swarm_common.model.records import Pose, RobotSpec
from swarm_common.model.robot_names import RobotNames
from swarm_common.model.schema import Seed, check_fields
from swarm_describe.robots.fleet import limits_of
from swarm_describe.robots.loading import Robot, load_robot, open_robot
from swarm_describe.worlds.actors import Actors, WalkerSpec, load_actors
from swarm_describe.worlds.reader import load_world
from swarm_describe.worlds.scene import Scene
from swarm_mission.energy import check_energy
from swarm_mission.itinerary import Itinerary
from swarm_mission.leg import Stop
from swarm_mission.mission import Mission, load_mission
from swarm_mission.orders.courier import Courier
from swarm_mission.orders.demand import measured_demand
from swarm_mission.orders.dispatch import load_dispatcher
from swarm_mission.orders.radio import OrderRadio
from swarm_nav.core.config import NavConfig, config_from_parameters
from swarm_nav.core.plugins import BRAIN, check_plugins, own_plugins
from swarm_nav.traffic.conditions import Conditions, conditions
from swarm_run.lanes import lanes_for, lanes_remarks
from swarm_run.loop import Driver
from swarm_run.params import Overrides, WorldParams, load_overrides
from swarm_run.spec import NO_LANES
from swarm_sim.maps.draw_map import Reach, reach_of
from swarm_sim.maps.world_check import checked
from swarm_sim.sensing.radio import RadioConfig
from swarm_sim.world.setup import WorldSetup, check_model_names, map_file_of, map_of, starts_of
from swarm_sim.world.world import World, WorldConfig


@dataclass(frozen=True, slots=True, kw_only=True)
class RunOptions:
    """One run of a scenario."""

    scenario: Scenario
    robots: Size  # swarm size
    seed: Seed = 0  # of everything random
    method: str = "ours"  # what drives the robots
    engine: str = "planar"  # physics: planar or bullet
    # of the navigators, by dotted name, in place of the defaults
    parameters: Mapping[str, Any] = field(default_factory=dict)
    # the same per pattern of node names; `parameters` win
    sections: Mapping[str, Mapping[str, Any]] = field(default_factory=dict)
    realistic: bool = False  # sensors err as the models say, and navigators localise by AMCL
    central: Mapping[str, Any] = field(default_factory=dict)  # parameters of a centre, by name

    def __post_init__(self) -> None:
        check_fields(self)


@dataclass(slots=True)
class Episode:
    """A run that is ready to start; lists have one entry per robot."""

    setup: WorldSetup
    world: World
    drivers: list[Driver]  # what decides for each robot
    itineraries: Sequence[Itinerary | Courier]  # what each robot has to do
    stops: Sequence[Sequence[Stop]]  # the goals of each robot
    conditions: Conditions | None = None  # what the map has room for; None where nobody asks
    orders: BenchOrders | None = None  # that the goals come from; None for a route
    centre: Centre | None = None  # decides for all robots; None where each decides alone


def check(options: RunOptions) -> list[str]:
    """Check the inputs of a run without building a world.

    Args:
        options: What is to be run.

    Returns:
        What may end badly, a sentence each.

    Raises:
        SwarmError: If a file or a value is unusable.
    """
    setup, mission = prepare(options)
    specs, sites = setup.specs, setup.scene.sites
    plan = mission.orders if mission is not None else None
    lanes = options.scenario.lanes
    zones = _scene(options.scenario.world, lanes).sites.zones
    remarks = lanes_remarks(zones, setup.scene.file, mission, is_given=bool(lanes))
    if plan is None:
        routes = [_route(mission, setup, options, index) for index in range(len(specs))]
        named = zip(setup.names, specs, strict=True), zip(setup.names, routes, strict=True)
        check_energy(dict(named[0]), dict(named[1]), sites, setup.scene.name)
    else:
        load_dispatcher(plan.dispatch)
        remarks += measured_demand(plan, sites, setup.grid, specs, len(specs))[1]
    heights = [spec.lidar.z for spec in specs]
    checked(setup.scene, heights, reach_of(specs), with_physics=options.engine == "bullet")
    load_method(options.method)
    if options.central.get("solver"):
        check_program(Path(options.central["solver"]))
    for number, spec in enumerate(specs, 1):
        config = nav_config(options, spec, number)
        check_plugins(config)
        _check_use(options.method, config)
    return remarks


def _check_use(method: str, config: NavConfig) -> None:
    """Refuse plug-ins that a method makes no use of: the run would be named after them.

    Raises:
        ConfigError: For the first one.
    """
    takes_all = method not in METHODS and load_team(method) is None  # it gets the parameters
    for parameter, name in own_plugins(config):
        if method in OF_NAVIGATORS or (takes_all and parameter != BRAIN.parameter):
            continue
        raise ConfigError(
            f"{parameter} is '{name}', and --method {method} does not use it; leave one of them out"
        )


def build(
    options: RunOptions,
    *,
    world_class: type[World] = World,
    walkers: tuple[WalkerSpec, ...] = (),
    most_goals: int | None = None,
) -> Episode:
    """Return the episode of a run; starts, goals and parameters are those of `swarm-up`.

    Args:
        options: What to run.
        world_class: What simulates.
        walkers: People beside those of the scenario.
        most_goals: Per robot; None for all of the mission.

    Raises:
        SwarmError: If a file or a value is unusable.
    """
    scenario = options.scenario
    setup, mission = prepare(options)
    sites, homes = setup.scene.sites, setup.starts
    scene = dataclasses.replace(setup.scene, walkers=(*setup.scene.walkers, *walkers))
    setup = dataclasses.replace(setup, scene=scene)

    def _further(index: int) -> Callable[[], list[Stop]]:
        """Return what makes one lap more of a robot; in a run without duration none."""
        lap = itertools.count(scenario.laps)
        if not scenario.duration or index in setup.silent or mission is None:
            return list
        return lambda: mission.stops(
            sites, homes[index], seed=options.seed, robot_id=index + 1,
            first_lap=next(lap), homes_map=homes,
        )  # fmt: skip

    routes = [
        () if index in setup.silent else _route(mission, setup, options, index, most_goals)
        for index in range(options.robots)
    ]
    episode = episode_of(options, setup, routes, world_class=world_class)
    if mission is not None and mission.orders is not None:
        radio = OrderRadio(scenario.loss, scenario.delay, options.seed)
        episode.orders = make_orders(
            mission, mission.orders, setup, episode.drivers, radio, options.seed
        )
        episode.itineraries = episode.orders.couriers
    else:
        retries = mission.retries if mission else 0
        episode.itineraries = [
            Itinerary(route, retries, more=_further(index)) for index, route in enumerate(routes)
        ]
    return episode


def _route(
    mission: Mission | None,
    setup: WorldSetup,
    options: RunOptions,
    index: int,
    limit: int | None = None,
) -> tuple[Stop, ...]:
    """Return a robot's goals; with orders, all places that they may send it to."""
    if mission is None:
        return ()
    sites, homes = setup.scene.sites, setup.starts
    if mission.orders is not None:
        return tuple(mission.order_stops(sites, homes[index]))
    return tuple(
        mission.stops(
            sites, homes[index], seed=options.seed, robot_id=index + 1,
            laps=options.scenario.laps, limit=limit, homes_map=homes,
        )
    )  # fmt: skip


def episode_of(
    options: RunOptions,
    setup: WorldSetup,
    routes: Sequence[Sequence[Stop]],
    retries: int = 0,
    *,
    world_class: type[World] = World,
) -> Episode:
    """Return an episode in which each robot drives a route.

    Args:
        options: What to run.
        setup: World, robots and map.
        routes: Goals of each robot; robots without any stay where they start.
        retries: Number of times that a robot drives to a goal again.
        world_class: What simulates.
    """
    method = load_method(options.method)
    world = setup.start(world_class)
    drivers = [
        method(nav_config(options, spec, number), spec, setup.grid, setup.scene.sites, number, home)
        for number, (spec, home) in enumerate(zip(setup.specs, setup.starts, strict=True), 1)
    ]
    return Episode(
        setup, world, drivers, [Itinerary(route, retries) for route in routes], routes,
        _room_for(options, setup, routes), centre=_centre(options, setup),
    )  # fmt: skip


def _centre(options: RunOptions, setup: WorldSetup) -> Centre | None:
    """Return what decides for all robots of a run; None where each decides alone."""
    specs = setup.specs
    factory, config = load_team(options.method), nav_config(options, specs[0])
    if factory is None:
        if config.traffic.coordination != Coordination.DECENTRAL:
            raise ConfigError("traffic.coordination needs --method central-reservation")
        return None
    team = factory(config, specs, setup.grid, setup.scene.sites, options.central)
    scenario = options.scenario
    delay = delay_ticks(scenario.delay)
    return Centre(team, len(specs), scenario.loss, delay, seed=options.seed)


def _room_for(
    options: RunOptions, setup: WorldSetup, routes: Sequence[Sequence[Stop]]
) -> Conditions:
    """Return what the map of a run has room for, and whether robots see those that are dead."""
    starts = [(home.x, home.y) for home in setup.starts]
    goals = [
        [(stop.pose_map.x, stop.pose_map.y) for stop in route] or [start]
        for start, route in zip(starts, routes, strict=True)
    ]
    configs = [nav_config(options, spec, number) for number, spec in enumerate(setup.specs, 1)]
    found = conditions(list(zip(setup.specs, configs, strict=True)), setup.grid, starts, goals)
    costmap = configs[0].costmap
    unseen = setup.unseen(costmap.unknown_body_margin + costmap.footprint_padding, "dead")
    return dataclasses.replace(found, findings=(*unseen, *found.findings))


def prepare(options: RunOptions) -> tuple[WorldSetup, Mission | None]:
    """Return world, robots and map of a run, and what the robots are to do, if anything.

    Dead robots come last.

    Args:
        options: What is to be run.

    Raises:
        SwarmError: If a file or a value is unusable.
    """
    scenario, count = options.scenario, options.robots
    scene = _scene(scenario.world, scenario.lanes)
    mission = None
    if scenario.mission:
        mission = _mission(scenario.mission).with_groups(scene.sites)
        if scenario.dispatch:
            mission = mission.dispatched_by(scenario.dispatch)
        where = f"world {scene.name}, for mission {mission.name}"
        mission.check_stations(scene.sites, where, robots=count, highest=count)
    alive = count - len(scenario.dead)
    if alive < 1:
        raise ConfigError(
            f"scenario {scenario.name} has {len(scenario.dead)} dead robots; "
            f"a swarm of {count} leaves none alive"
        )
    specs = specs_of(options)
    dead = tuple(Pose(*pose) for pose in scenario.dead)
    starts = _starts(scenario.world, specs, mission.spawn if mission else "", dead)
    reach = reach_of(specs)
    height = min(spec.lidar.z for spec in specs)
    lanes = scenario.lanes
    if lanes_for(scene.sites.zones, mission, is_given=bool(lanes)) is not scene.sites.zones:
        lanes = NO_LANES
        scene = _scene(scenario.world, lanes)
    grid = _grid(scenario.world, lanes, height, reach, starts)
    if scenario.actors:
        actors = _actors(scenario.world, scenario.actors)
        scene = dataclasses.replace(scene, walkers=actors.walkers, vehicles=actors.vehicles)
    return setup_of(options, scene, starts, grid, range(alive, count)), mission


def setup_of(
    options: RunOptions,
    scene: Scene,
    starts: Sequence[Pose],
    grid: Grid,
    silent: Collection[int] = (),
) -> WorldSetup:
    """Return the robots of a run in a world that was read or drawn.

    Args:
        options: What is to be run.
        scene: The world.
        starts: Start poses in map, one per robot.
        grid: The map.
        silent: Indices of the robots that are dead.
    """
    scenario = options.scenario
    return WorldSetup(
        config=WorldConfig(
            engine=options.engine,
            with_lidar=scenario.with_lidar,
            actuation_noise=scenario.noise,
            realistic=options.realistic,
            radio=RadioConfig(loss=scenario.loss, delay=scenario.delay),
        ),
        seed=options.seed,
        scene=scene,
        names=RobotNames().first(options.robots),
        specs=specs_of(options),
        starts=starts,
        grid=grid,
        robots=bodies_of(options),
        silent=silent,
    )


def specs_of(options: RunOptions) -> tuple[RobotSpec, ...]:
    """Return the model of each robot of a run.

    Args:
        options: What is to be run.
    """
    models = options.scenario.models(options.robots)
    found = {model: robot_named(model) for model in dict.fromkeys(models)}
    check_model_names(found)
    return tuple(found[model] for model in models)


def bodies_of(options: RunOptions) -> dict[str, Robot]:
    """Return the robots' bodies by `RobotSpec.model`; none where nothing looks at them.

    Args:
        options: What is to be run.
    """
    if not options.scenario.with_lidar and options.engine == "planar":
        return {}
    robots = [_robots(name) for name in dict.fromkeys(options.scenario.models(options.robots))]
    return {robot.spec.model: robot for robot in robots}


def nav_config(options: RunOptions, spec: RobotSpec, number: int = 1) -> NavConfig:
    """Return the parameters of a navigator, as `swarm-up` would write them.

    Args:
        options: Its parameters count more than the defaults and what the model says.
        spec: Model of the robot.
        number: Number of the robot, from 1.

    Raises:
        ConfigError: If a parameter is unknown or wrong.
    """
    values = {
        **_defaults(),
        **limits_of(spec),
        **({} if options.scenario.with_lidar else {"costmap.scan_timeout": 0.0}),
        **(REALISTIC if options.realistic else {}),
        **Overrides(options.sections).for_robot(RobotNames().name_of(number)),
        **options.parameters,
    }
    return _config(tuple(values.items()))


@functools.lru_cache(maxsize=64)  # robots of one model share it
def _config(values: tuple[tuple[str, Any], ...]) -> NavConfig:
    return config_from_parameters(dict(values), where="--params or --set")


def parse_parameters(settings: list[str], where: str = "--set") -> dict[str, Any]:
    """Return the parameters in texts like traffic.safety_margin=0.06.

    Args:
        settings: Each NAME=VALUE, with names of the navigator's parameters.
        where: Option that they were given by.

    Returns:
        Values by dotted name: numbers and booleans where the text is one, else the text.

    Raises:
        ConfigError: If one is malformed, unknown, or of a wrong type.
    """
    values: dict[str, Any] = {}
    known = _defaults()
    for setting in settings:
        name, equals, text = setting.partition("=")
        if not equals:
            raise ConfigError(f"{where} is '{setting}'; expected NAME=VALUE")
        values[name] = _parsed(text, known.get(name))
    config_from_parameters(values, where=where)
    return values


def parameter_sections(path: Path, robots: int) -> Mapping[str, Mapping[str, Any]]:
    """Return the sections of a parameter file, of which every one is for some robot of a run.

    Args:
        path: Parameter file, as for `swarm-up --params`.
        robots: Size of the swarm.

    Raises:
        ConfigError: If it is unusable, or tells of the world, which a scenario does here.
    """
    names = [RobotNames().name_of(number) for number in range(1, robots + 1)]
    found = load_overrides(path, names, _defaults())
    if found.world != WorldParams():
        raise ConfigError(f"{path}: in the bench the world is that of the scenario; drop /world")
    for pattern, values in found.sections.items():
        config_from_parameters(values, where=f"{path}: {pattern}")
    return found.sections


def _parsed(text: str, default: Any) -> Any:
    if isinstance(default, bool):
        return {"true": True, "false": False}.get(text.lower(), text)
    for kind in (int, float):
        try:
            value = kind(text)
        except ValueError:
            continue
        if math.isfinite(value):
            return value
    return text


# Worlds and maps are read once per process.


@read_once
def _scene(world: str, lanes: str = "") -> Scene:
    scene = load_world(world)
    if not lanes:
        return scene
    zones = dataclasses.replace(
        scene.sites.zones, lanes=None if lanes == NO_LANES else load_lanes(Path(lanes))
    )
    return dataclasses.replace(scene, sites=dataclasses.replace(scene.sites, zones=zones))


_mission = read_once(load_mission)
_robots = read_once(open_robot)
robot_named = read_once(load_robot)


@read_once
def _grid(world: str, lanes: str, height: float, reach: Reach, starts: Sequence[Pose]) -> Grid:
    scene = _scene(world, lanes)
    return scene.sites.zones.mark(map_of(scene, height, reach, starts, map_file_of(scene)))


@read_once
def _starts(
    world: str, specs: Sequence[RobotSpec], spawn: str, dead: tuple[Pose, ...]
) -> tuple[Pose, ...]:
    free = [None] * (len(specs) - len(dead))
    return tuple(starts_of(_scene(world), specs, [spawn] * len(specs), [*free, *dead]))


@read_once
def _actors(world: str, actors: str) -> Actors:
    return load_actors(_scene(world).directory / actors)


@read_once
def _defaults() -> dict[str, Any]:
    return dict(default_parameters())
