"""Everything that a run needs, made from a scenario: world, map, drivers and missions."""

from __future__ import annotations

import dataclasses
import functools
import itertools
import math
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from swarm_bench.runs.inputs import read_once
from swarm_bench.runs.methods import METHODS, OF_NAVIGATORS, Driver, load_method, load_team
from swarm_bench.runs.orders import BenchOrders, demand_remarks, make_orders, measure_ways
from swarm_bench.runs.scenario import Scenario
from swarm_central.link import Centre, delay_ticks
from swarm_central.movingai import check_program
from swarm_common.files.map_io import load_map, map_of_world
from swarm_common.files.params_io import REALISTIC, default_parameters
from swarm_common.model.central import Coordination
from swarm_common.model.errors import ConfigError
from swarm_common.model.grid import Grid
from swarm_common.model.records import Pose, RobotSpec
from swarm_common.model.robot_names import RobotNames
from swarm_common.model.sites import Sites
from swarm_describe.robots.description import RobotModel
from swarm_describe.robots.fleet import limits_of
from swarm_describe.robots.loading import load_robot, open_robot
from swarm_describe.worlds.actors import Actors, WalkerSpec, load_actors
from swarm_describe.worlds.reader import load_world
from swarm_describe.worlds.scene import Scene
from swarm_mission.energy import check_energy
from swarm_mission.itinerary import Itinerary
from swarm_mission.leg import Stop
from swarm_mission.mission import Mission, load_mission
from swarm_mission.orders.courier import Courier
from swarm_mission.orders.dispatch import load_dispatcher
from swarm_mission.orders.radio import OrderRadio
from swarm_nav.core.config import NavConfig, config_from_parameters
from swarm_nav.core.plugins import BRAIN, check_plugins, own_plugins
from swarm_nav.traffic.conditions import Conditions, conditions
from swarm_run.params import Overrides, load_overrides
from swarm_run.world_params import WorldParams
from swarm_sim.maps.draw_map import Reach, draw_world, reach_of, with_touchable
from swarm_sim.maps.spawn import deal_places
from swarm_sim.maps.world_check import checked
from swarm_sim.sensing.radio import RadioConfig
from swarm_sim.sensing.visibility import overlooked
from swarm_sim.world.world import World, WorldConfig


@dataclass(frozen=True, slots=True, kw_only=True)
class RunOptions:
    """One run of a scenario.

    Attributes:
        scenario: Scenario that is run.
        robots: Swarm size.
        seed: Seed of everything random.
        method: What drives the robots.
        engine: Physics: planar or bullet.
        parameters: Parameters of the navigators, by dotted name, in place of the defaults.
        sections: Parameters per pattern of node names; `parameters` win.
        realistic: Whether sensors err as the robots' models say and navigators localise by AMCL.
        central: Parameters of a centre, by name, in place of its defaults.
    """

    scenario: Scenario
    robots: int
    seed: int = 0
    method: str = "ours"
    engine: str = "planar"
    parameters: Mapping[str, Any] = field(default_factory=dict)
    sections: Mapping[str, Mapping[str, Any]] = field(default_factory=dict)
    realistic: bool = False
    central: Mapping[str, Any] = field(default_factory=dict)


@dataclass(slots=True)
class Episode:
    """A run that is ready to start; lists have one entry per robot."""

    world: World
    drivers: list[Driver]  # what decides for each robot
    itineraries: Sequence[Itinerary | Courier]  # what each robot has to do
    homes_map: list[Pose]  # where each starts
    dead: frozenset[int]  # indices of the robots that never do anything
    grid: Grid  # the map
    sites: Sites = field(default_factory=Sites)  # of the world
    stops: list[tuple[Stop, ...]] = field(default_factory=list)  # the goals of each robot
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
    scene, mission, homes, specs = _cast(options)
    routes = {
        RobotNames().name_of(index + 1): _route(mission, scene.sites, options, index, homes)
        for index in range(len(homes))
    }
    plan = mission.orders if mission is not None else None
    if plan is None:
        check_energy(dict(zip(routes, specs, strict=True)), routes, scene.sites, scene.name)
    grid = _map_for(options.scenario.world, specs)
    remarks = []
    if plan is not None:
        load_dispatcher(plan.dispatch)
        ways = measure_ways(plan, scene.sites, grid, specs)
        remarks = demand_remarks(plan, ways, specs)
    heights = [spec.lidar.z for spec in specs]
    checked(scene, heights, reach_of(specs), with_physics=options.engine == "bullet")
    _actors(options.scenario.world, options.scenario.actors)
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


def dispatch_of(options: RunOptions) -> str:
    """Return who gives orders to robots; empty without orders.

    Args:
        options: What to run.
    """
    _, mission, _, _ = _cast(options)
    return mission.orders.dispatch if mission is not None and mission.orders is not None else ""


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
    scenario, count = options.scenario, options.robots
    scene, mission, homes, specs = _cast(options)
    grid = _map_for(scenario.world, specs)
    dead = frozenset(range(count - len(scenario.dead), count))
    actors = _actors(scenario.world, scenario.actors)
    if walkers:
        actors = Actors((*(actors.walkers if actors else ()), *walkers), scene.vehicles)

    def _further(index: int) -> Callable[[], list[Stop]]:
        """Return what makes one lap more of a robot; in a run without duration none."""
        lap = itertools.count(scenario.laps)
        if not scenario.duration or index in dead or mission is None:
            return list
        return lambda: mission.stops(
            scene.sites, homes[index], seed=options.seed, robot_id=index + 1,
            first_lap=next(lap), homes_map=homes,
        )  # fmt: skip

    routes = [
        () if index in dead else _route(mission, scene.sites, options, index, homes, most_goals)
        for index in range(count)
    ]
    world = make_world(options, scene, specs, homes, actors, world_class)
    drivers = make_drivers(options, scene.sites, specs, grid, homes)
    named = dict(zip(world.names, homes, strict=True))
    radio = OrderRadio(scenario.loss, scenario.delay, options.seed)
    orders = None
    if mission is not None:
        orders = make_orders(mission, scene.sites, grid, named, specs, drivers, radio, options.seed)
    itineraries: Sequence[Itinerary | Courier]
    if orders is not None:
        itineraries = orders.couriers
    else:
        itineraries = [
            Itinerary(route, mission.retries if mission else 0, more=_further(index))
            for index, route in enumerate(routes)
        ]
    found = room_for(options, specs, grid, homes, routes, dead)
    return Episode(
        world, drivers, itineraries, homes, dead, grid, scene.sites, routes, found, orders,
        make_centre(options, scene.sites, specs, grid),
    )  # fmt: skip


def _route(
    mission: Mission | None,
    sites: Sites,
    options: RunOptions,
    index: int,
    homes: Sequence[Pose],
    limit: int | None = None,
) -> tuple[Stop, ...]:
    """Return a robot's goals; with orders, all places that they may send it to."""
    if mission is None:
        return ()
    if mission.orders is not None:
        return tuple(mission.order_stops(sites, homes[index]))
    return tuple(
        mission.stops(
            sites, homes[index], seed=options.seed, robot_id=index + 1,
            laps=options.scenario.laps, limit=limit, homes_map=homes,
        )
    )  # fmt: skip


def make_world(
    options: RunOptions,
    scene: Scene,
    specs: Sequence[RobotSpec],
    homes: Sequence[Pose],
    actors: Actors | None,
    world_class: type[World] = World,
) -> World:
    """Return the world of a run.

    Args:
        options: What to run.
        scene: The world.
        specs: Models of the robots.
        homes: Start poses in map, one per robot.
        actors: People and vehicles; None for those of the scene.
        world_class: What simulates.
    """
    scenario = options.scenario
    config = WorldConfig(
        engine=options.engine,
        with_lidar=scenario.with_lidar,
        walkers=actors.walkers if actors is not None else None,
        vehicles=actors.vehicles if actors is not None else None,
        actuation_noise=scenario.noise,
        realistic=options.realistic,
        radio=RadioConfig(loss=scenario.loss, delay=scenario.delay),
    )
    models = robot_models(options)
    return world_class(scene, specs, homes, config, options.seed, models=models)


def make_drivers(
    options: RunOptions,
    sites: Sites,
    specs: Sequence[RobotSpec],
    grid: Grid,
    homes: Sequence[Pose],
) -> list[Driver]:
    """Return what decides for each robot of a run.

    Args:
        options: What to run.
        sites: Sites of the world.
        specs: Models of the robots.
        grid: The map.
        homes: Start poses in map, one per robot.
    """
    method = load_method(options.method)
    return [
        method(nav_config(options, spec, number), spec, grid, sites, number, home)
        for number, (spec, home) in enumerate(zip(specs, homes, strict=True), 1)
    ]


def make_centre(
    options: RunOptions, sites: Sites, specs: Sequence[RobotSpec], grid: Grid
) -> Centre | None:
    """Return what decides for all robots of a run; None where each decides alone.

    Args:
        options: What to run.
        sites: Sites of the world.
        specs: Models of the robots.
        grid: The map.
    """
    factory, config = load_team(options.method), nav_config(options, specs[0])
    if factory is None:
        if config.traffic.coordination != Coordination.DECENTRAL:
            raise ConfigError("traffic.coordination needs --method central-reservation")
        return None
    team = factory(config, specs, grid, sites, options.central)
    scenario = options.scenario
    delay = delay_ticks(scenario.delay)
    return Centre(team, len(specs), scenario.loss, delay, seed=options.seed)


def room_for(
    options: RunOptions,
    specs: Sequence[RobotSpec],
    grid: Grid,
    homes: Sequence[Pose],
    stops: Sequence[Sequence[Stop]],
    dead: Collection[int],
) -> Conditions:
    """Return what the map of a run has room for, and whether robots see those that are dead.

    Robots without goals stay where they start.

    Args:
        options: What to run.
        specs: Models of the robots.
        grid: The map.
        homes: Start poses in map, one per robot.
        stops: Goals of each robot.
        dead: Indices of the dead robots.
    """
    goals = [
        [(stop.pose_map.x, stop.pose_map.y) for stop in route] or [(home.x, home.y)]
        for home, route in zip(homes, stops, strict=True)
    ]
    starts = [(home.x, home.y) for home in homes]
    robots = [(spec, nav_config(options, spec, number)) for number, spec in enumerate(specs, 1)]
    found = conditions(robots, grid, starts, goals)
    unseen = tuple(_unseen(options, specs, dead))
    return dataclasses.replace(found, findings=(*unseen, *found.findings))


def _unseen(
    options: RunOptions, specs: Sequence[RobotSpec], dead: Collection[int]
) -> Iterator[str]:
    """Yield a sentence on each model whose LiDAR sees too little of robots that are dead."""
    if not dead:
        return
    models = robot_models(options)
    if not options.scenario.with_lidar or models is None:
        yield "without LiDARs no robot sees the dead ones: it may hit them"
        return
    living = [spec for index, spec in enumerate(specs) if index not in dead]
    costmap = nav_config(options, specs[0]).costmap
    margin = costmap.unknown_body_margin + costmap.footprint_padding
    for sentence in overlooked(living, [specs[index] for index in sorted(dead)], models, margin):
        yield f"{sentence}: it may hit one that is dead"


def ground_of(options: RunOptions) -> tuple[Grid, list[Pose]]:
    """Return the map of a run and where its robots start.

    Args:
        options: What is to be run.

    Returns:
        The map, and start poses in it, one per robot; dead robots come last.

    Raises:
        SwarmError: If a file or a value is unusable.
    """
    _, _, homes, specs = _cast(options)
    return _map_for(options.scenario.world, specs), homes


def _cast(options: RunOptions) -> tuple[Scene, Mission | None, list[Pose], list[RobotSpec]]:
    """Return world, mission if there is one, and where robots of which model start."""
    scenario = options.scenario
    scene, count = _scene(scenario.world), options.robots
    mission = None
    if scenario.mission:
        mission = _mission(scenario.mission).with_groups(scene.sites)
        if scenario.dispatch:
            mission = mission.dispatched_by(scenario.dispatch)
        where = f"world {scene.name}, for mission {mission.name}"
        mission.check_stations(scene.sites, where, robots=count, highest=count)
    specs = [robot_named(model) for model in scenario.models(options.robots)]
    return scene, mission, _homes(scenario, specs, mission.spawn if mission else ""), specs


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


def _homes(scenario: Scenario, specs: list[RobotSpec], spawn: str) -> list[Pose]:
    """Return the start poses; dead robots stand where the scenario says."""
    widest = max(specs, key=lambda spec: spec.circumscribed_radius)
    alive = len(specs) - len(scenario.dead)
    if alive < 1:
        raise ConfigError(
            f"scenario {scenario.name} has {len(scenario.dead)} dead robots; "
            f"a swarm of {len(specs)} leaves none alive"
        )
    return [*_spawn(scenario.world, widest, alive, spawn), *(Pose(*pose) for pose in scenario.dead)]


# Worlds and maps are read once per process.


_scene = read_once(load_world)
_mission = read_once(load_mission)
_robots = read_once(open_robot)
robot_named = read_once(load_robot)


def _map_for(world: str, specs: Sequence[RobotSpec]) -> Grid:
    return _grid(world, min(spec.lidar.z for spec in specs), reach_of(specs))


@read_once
def _grid(world: str, height: float, reach: Reach) -> Grid:
    scene = _scene(world)
    path = map_of_world(scene.file)
    if path is None:
        grid = draw_world(scene, height, reach=reach)
    else:
        grid = with_touchable(load_map(path).upright().refined(), scene, height, reach)
    return scene.sites.zones.mark(grid)


def robot_models(options: RunOptions) -> dict[str, RobotModel] | None:
    """Return the bodies of the robots by model, None if nobody looks at them.

    Args:
        options: What is to be run.
    """
    scenario = options.scenario
    if not scenario.with_lidar and options.engine == "planar":
        return None
    return {
        robot_named(name).model: _robots(name).model for name in scenario.models(options.robots)
    }


@read_once
def _spawn(world: str, widest: RobotSpec, count: int, spawn: str) -> tuple[Pose, ...]:
    return tuple(deal_places(_scene(world), [widest] * count, [spawn] * count, widest))


@read_once
def _actors(world: str, actors: str) -> Actors | None:
    return load_actors(_scene(world).directory / actors) if actors else None


@read_once
def _defaults() -> dict[str, Any]:
    return dict(default_parameters())
