"""Everything that is checked and loaded before a run starts a single process."""

from __future__ import annotations

import functools
import math
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field, replace
from pathlib import Path
from typing import Any

import msgspec
import yaml

from swarm_common.files.layout_io import LAYOUT_FILE, read_layout
from swarm_common.files.map_io import load_map, map_of_world
from swarm_common.files.params_io import REALISTIC, default_parameters
from swarm_common.files.sites_io import load_sites
from swarm_common.files.yaml_io import read_yaml
from swarm_common.files.zones_io import copy_masks
from swarm_common.middleware import ros_env
from swarm_common.model.central import Coordination
from swarm_common.model.errors import ConfigError
from swarm_common.model.records import Pose, RobotSpec
from swarm_common.model.robot_names import RobotNames
from swarm_common.model.robot_parameters import frames_parameter
from swarm_common.model.sites import Sites
from swarm_describe.robots.fleet import Fleet, Member, uniform_fleet
from swarm_describe.robots.loading import fixed_frames, load_robot
from swarm_describe.worlds.world_file import find_world
from swarm_mission.energy import check_energy
from swarm_mission.leg import Stop
from swarm_mission.mission import Mission, load_mission, mission_path
from swarm_mission.orders.demand import measured_demand
from swarm_mission.orders.dispatch import CLAIM, DISPATCHER, load_dispatcher
from swarm_mission.orders.order import OrderPlan
from swarm_mission.orders.order_file import times_files
from swarm_run.lanes import lanes_for, lanes_remarks
from swarm_run.params import (
    Overrides,
    default_world_parameters,
    load_overrides,
    robot_parameter_file,
)
from swarm_run.spec import DRIVES, NO_LANES, RunSpec

WORLD_FILE = "world.sdf"
SITES_FILE = "sites.yaml"
# Of robots that neither make way nor wait for a turn: all but make_way, leave and wait.
FLEET_RULES = "keep_apart stop_before_obstacle plan_anew behave arrive drive check_progress"
COURIERS = 30  # processes at most; then several robots share one, as DDS has few ids


@dataclass(frozen=True, slots=True)
class RunPlan:
    """The checked input of a run."""

    spec: RunSpec
    world: Path  # file
    map: Path | None  # of the user or of a world that comes with us; None to draw it
    sites_path: Path | None  # None if there is none beside the world
    sites: Sites  # its contents
    fleet: Fleet  # model of each robot
    mission: Mission | None  # what the robots are to do, if anything
    stations: tuple[str, ...] | None  # that robots are sent to; None where missions do not say
    defaults: dict[str, Any]  # parameters of the navigators by dotted name
    overrides: Overrides  # parameters that the user gave
    # copies of files that restarted processes read again, by the file's name as the user gave it
    copies: Mapping[str, str] = field(default_factory=dict)
    remarks: tuple[str, ...] = ()  # what may end badly, a sentence each

    def with_copies(self, folder: Path) -> RunPlan:
        """Return this plan with copies of sites and missions, which nobody edits during the run."""
        missions = {member.mission or self.spec.mission for member in self.fleet.members}
        files = {name: mission_path(name) for name in sorted(filter(None, missions))}
        if self.sites_path is not None:
            files[str(self.sites_path)] = self.sites_path
        copies = self._copied_masks(folder / "zones")
        for number, (name, path) in enumerate(files.items(), 1):
            if name in copies:
                continue
            copy = folder / str(number) / path.name  # a mission has the name of its file
            copy.parent.mkdir(parents=True)
            copy.write_bytes(path.read_bytes())
            copies[name] = str(copy)
            for times in times_files(read_yaml(path, may_be_empty=True)):
                beside = copy.parent / times
                beside.parent.mkdir(parents=True, exist_ok=True)
                beside.write_bytes((path.parent / times).read_bytes())
        return replace(self, copies=copies)

    def _copied_masks(self, folder: Path) -> dict[str, str]:
        """Copy the sites with their filter masks; return the copy by name, if there are masks."""
        path = self.sites_path or self.world.with_name(SITES_FILE)
        content = copy_masks(path, self.spec.masks, folder)
        if content is None:
            return {}
        copy = folder / SITES_FILE
        folder.mkdir(parents=True, exist_ok=True)
        copy.write_text(yaml.safe_dump(content, sort_keys=False), encoding="utf-8")
        return {self._sites_name: str(copy)}

    @property
    def _sites_name(self) -> str:
        return str(self.sites_path or "")

    @property
    def sites_file(self) -> str:
        """Path of what processes read of the sites: the copy if there is one; empty without any."""
        return self.copy_of(self._sites_name)

    def copy_of(self, name: str) -> str:
        """Return the path of the copy of a file, or the name if there is none."""
        return self.copies.get(name, name)

    @property
    def alive(self) -> list[str]:
        """Names of the robots that have a navigator of ours."""
        absent = {*self.overrides.world.broken_map, *self.spec.driven_by_users}
        return [name for name in self.spec.robot_names if name not in absent]

    @property
    def names_engine(self) -> bool:
        """Whether the user chose the physics engine."""
        return bool(self.spec.drive or self.overrides.world.values.get("engine"))

    def world_config(self, verdict: Path) -> dict[str, Any]:
        """Return the configuration of the world process.

        Args:
            verdict: File that the world is to write at its end.

        Returns:
            Configuration as `swarm_sim.ros.settings` reads it.
        """
        spec, params = self.spec, self.overrides.world
        broken = params.broken_map
        return {
            **params.settings(),
            **({"engine": DRIVES[spec.drive]} if spec.drive else {}),
            "world": str(self.world),
            "map": str(self.map) if self.map else None,
            "sites": self.sites_file or None,
            "robots": [
                {
                    "name": name,
                    "model": member.model,
                    "broken_at": _triple(broken.get(name)),
                    "start": member.start or "",
                    **({"external": True} if name in spec.driven_by_users else {}),
                    **_battery_of(member),
                }
                for name, member in zip(spec.robot_names, self.fleet.members, strict=True)
            ],
            "pattern": spec.naming.pattern,
            "processes": spec.processes,
            "spawn": self.mission.spawn if self.mission is not None else "",
            "stations": self.stations,
            "skip_missing": spec.skip_missing,
            "skip_broken": spec.skip_broken,
            "seed": spec.seed,
            "realistic": spec.realistic,
            "speed": "max" if spec.pace is None else spec.pace,
            **({"paused": True} if spec.paused else {}),
            "free_run": spec.free_run,
            "duration": spec.duration,
            "verdict_path": str(verdict),
            "body_margin": self._body_margin(),
        }

    def _body_margin(self) -> float:
        """Return [m] that each robot allows for what its LiDAR does not see of a body."""
        parts = ("costmap.unknown_body_margin", "costmap.footprint_padding")
        robots = [self.defaults | self.overrides.for_robot(name) for name in self.alive]
        return min(float(sum(robot[part] for part in parts)) for robot in robots)

    def parameter_file(
        self, number: int, initial_pose_map: Pose, map_sha256: str = ""
    ) -> dict[str, Any]:
        """Return the parameter file of robot `number`, from 1.

        Args:
            number: From 1, the id in its beacons.
            initial_pose_map: Where it stands at the start.
            map_sha256: Digest of the only map that it is to take from /map; empty for any.
        """
        name, member = self.spec.robot_names[number - 1], self.fleet.members[number - 1]
        is_led = self.mission is not None and not self.spec.free_run
        waits = {"wait_for_courier" if self.has_orders else "wait_for_mission": is_led}
        if self._has_pilots:
            waits = {"wait_for_courier": True}
        return self._parameters(name, number, member, initial_pose_map, waits, map_sha256)

    @property
    def _has_pilots(self) -> bool:
        """Whether vehicles of VDA 5050 release the ticks of their robots."""
        return self.spec.fleet_control is not None and not self.spec.free_run

    def parameter_file_of_newcomer(
        self, name: str, number: int, model: str, initial_pose_map: Pose, map_sha256: str = ""
    ) -> dict[str, Any]:
        """Return the parameter file of a robot that was spawned while the run goes on.

        Raises:
            SwarmError: If there is no such model.
        """
        known = dict(zip(self.spec.robot_names, self.fleet.members, strict=True)).get(name)
        spec = load_robot(model)
        if known is not None and known.spec.is_same_model(spec):
            spec = known.spec  # it is back, with its battery
        member = Member(model, spec)
        return self._parameters(
            name,
            number,
            member,
            initial_pose_map,
            {"wait_for_mission": False, "wait_for_courier": self._has_pilots},
            map_sha256,
        )

    def _parameters(
        self,
        name: str,
        number: int,
        member: Member,
        initial_pose_map: Pose,
        waits: Mapping[str, bool],
        map_sha256: str,
    ) -> dict[str, Any]:
        names = self.spec.naming
        values = {
            "autostart": self.spec.autostart,
            **waits,
            "on_demand": self.spec.size > ros_env.FEW_ROBOTS,
            "frames": _frames_of(member.model, member.spec),
            **({"robot_names": str(names)} if names != RobotNames() else {}),
            "sites": self.sites_file,
            **self.defaults,
            **(REALISTIC if self.spec.realistic else {}),
            **self._without_lidar(),
            **self._coordination(name),
            **member.limits_in_force,
            **self._rules(),
            **self.overrides.for_robot(name),
            **({"map_sha256": map_sha256} if map_sha256 else {}),
        }
        return robot_parameter_file(name, number, member.spec, initial_pose_map, values)

    def _rules(self) -> dict[str, Any]:
        is_led = self.spec.coordination is Coordination.FLEET
        return {"traffic.rules": FLEET_RULES} if is_led else {}

    def _without_lidar(self) -> dict[str, Any]:
        """Return the parameters that navigators need in a world without LiDARs."""
        is_off = self.overrides.world.values.get("with_lidar") is False
        return {"with_lidar": False, "costmap.scan_timeout": 0.0} if is_off else {}

    def _coordination(self, name: str) -> dict[str, Any]:
        """Return who decides for a robot; newcomers are not known to the centre: they decide."""
        is_led = self.spec.coordination.has_centre and name in self.alive
        return {"traffic.coordination": self.spec.coordination.value} if is_led else {}

    def central_config(self, map_file: Path, params: Path) -> dict[str, Any]:
        """Return the configuration of the centre.

        Args:
            map_file: File of the map that the robots have.
            params: Parameter file of the first robot that has a navigator.

        Returns:
            Configuration as `swarm_central.process` reads it.
        """
        numbers = {name: number for number, name in enumerate(self.spec.robot_names, 1)}
        return {
            "name": self.alive[0],
            "params": str(params),
            "map": str(map_file),
            "robots": {name: numbers[name] for name in self.alive},
            "models": [member.model for member in self.fleet.members],
            "central": dict(self.overrides.central),
            "radio": self._radio(),
            "seed": self.spec.seed,
        }

    @property
    def has_orders(self) -> bool:
        """Whether the goals come from orders, not from a route."""
        return self.mission is not None and self.mission.orders is not None

    def _radio(self) -> dict[str, float]:
        values = default_world_parameters() | dict(self.overrides.world.values)
        return {name: float(values[f"radio.{name}"]) for name in ("loss", "delay")}

    def station_configs(self) -> list[dict[str, Any]]:
        """Return the configurations of the stations' processes, and of a dispatcher's."""
        if self.mission is None or (orders := self.mission.orders) is None:
            return []
        return [
            {
                "station": name,
                "number": number,
                "party": f"station_{number}",
                **self._orders_config(),
            }
            for number, name in enumerate(_station_parties(orders), 1)
        ]

    def _orders_config(self) -> dict[str, Any]:
        """Return what all processes that take part in orders need."""
        assert self.mission is not None
        assert self.mission.orders is not None
        stations = enumerate(_station_parties(self.mission.orders), 1)
        shares = enumerate(self._courier_shares(), 1)
        parties = {f"station_{number}": [name] for number, name in stations}
        ends_with = list(parties) if self.spec.until_done else []
        values = default_world_parameters() | dict(self.overrides.world.values)
        return {
            "mission": self.copy_of(self.spec.mission or ""),
            "sites": self.sites_file,
            "seed": self.spec.seed,
            "parties": {**parties, **{f"courier_{number}": share for number, share in shares}},
            "ends_with": ends_with,  # when all of them are done
            **{name: float(values[f"radio.{name}"]) for name in ("loss", "delay")},
        }

    def _courier_shares(self) -> list[list[str]]:
        size = max(self.spec.pack_size, -(-len(self.alive) // COURIERS))
        return [self.alive[first : first + size] for first in range(0, len(self.alive), size)]

    def courier_configs(self, homes_map: Sequence[Pose], map_file: Path) -> list[dict[str, Any]]:
        """Return the configurations of the robots' couriers: a process each, up to `COURIERS`.

        Args:
            homes_map: Where each robot starts, broken ones included.
            map_file: Map file that the navigators use; ways to stations are measured on it.
        """
        if not self.has_orders:
            return []
        members, names = self.fleet.members, self.spec.robot_names
        robots = {
            name: {"home": _triple(home), "speed": member.spec.max_vel_x}
            for name, home, member in zip(names, homes_map, members, strict=True)
            if name in self.alive
        }
        common = {
            "map": str(map_file),
            "radius": min(member.spec.inscribed_radius for member in members),
            "is_in_step": not self.spec.free_run,
            **self._orders_config(),
        }
        return [
            {
                "number": number,
                "party": f"courier_{number}",
                "robots": {name: robots[name] for name in share},
                **common,
            }
            for number, share in enumerate(self._courier_shares(), 1)
        ]

    def runner_config(self, homes_map: list[Pose]) -> dict[str, Any]:
        """Return the configuration of the mission process.

        Returns:
            Configuration as `mission.runner` reads it.
        """
        spec = self.spec
        return {
            "robots": [
                {
                    "name": name,
                    "number": number,
                    "mission": self.copy_of(
                        self.fleet.members[number - 1].mission or spec.mission or ""
                    ),
                }
                for number, name in enumerate(spec.robot_names, 1)
                if name in self.alive
            ],
            "processes": spec.processes,
            "names": str(spec.naming),
            "homes": [_triple(home) for home in homes_map],
            "mission": spec.mission,
            "sites": self.sites_file or None,
            "seed": spec.seed,
            "laps": spec.laps,
            "goals_per_robot": spec.goals_per_robot,
            "stand_still_at_end": spec.until_done,
            "has_orders": self.has_orders,
        }

    def vda5050_config(self, map_file: Path) -> dict[str, Any]:
        """Return the configuration of the process that makes vehicles of VDA 5050 of the robots.

        Returns:
            Configuration as `swarm_vda5050.process` reads it.
        """
        assert self.spec.fleet_control is not None
        members = zip(self.spec.robot_names, self.fleet.members, strict=True)
        layout = self.world.parent / LAYOUT_FILE
        has_layout = layout.is_file()
        map_id = read_layout(layout)[0].map_id if has_layout else ""
        return self.spec.fleet_control.config() | {
            "robots": [
                {"name": name, "model": member.model, **_battery_of(member)}
                for name, member in members
                if name in self.alive
            ],
            "newcomer": self.fleet.members[0].model,
            "map": str(map_file),
            "map_id": map_id or self.world.parent.name,
            "layout": str(layout) if has_layout else None,
            "sites": self.sites_file or None,
            "realistic": self.spec.realistic,
            "is_in_step": self._has_pilots,
            "follows_edges": self.spec.coordination is Coordination.FLEET,
        }


def _station_parties(orders: OrderPlan) -> list[str]:
    """Return who speaks of orders beside the robots."""
    return [*orders.stations, *([] if orders.dispatch == CLAIM else [DISPATCHER])]


@functools.cache  # by the spec, too: a file may be another one when a robot is spawned later
def _frames_of(model: str, _: RobotSpec) -> str:
    return frames_parameter(fixed_frames(model))


def _triple(pose: Pose | None) -> list[float] | None:
    return None if pose is None else [pose.x, pose.y, pose.yaw]


def _battery_of(member: Member) -> dict[str, Any]:
    battery = member.spec.battery
    return {} if battery is None else {"battery": asdict(battery)}


def check_plan(spec: RunSpec) -> RunPlan:
    """Return the plan of a run.

    Raises:
        SwarmError: For the first thing that is wrong with the input.
    """
    spec.check()
    world = find_world(spec.world).absolute()
    sites_path = world.parent / SITES_FILE
    has_sites = sites_path.is_file()
    sites = load_sites(sites_path, spec.masks) if has_sites or spec.masks else Sites()
    if spec.bind and (sites.zones.keepout_mask or sites.zones.speed_mask):
        raise ConfigError(
            "filter masks are files of this host, which the robots' hosts do not have; with --role"
            f" world, write the zones into {sites_path} as polygons"
        )
    fleet = spec.loaded_fleet or uniform_fleet(spec.model, spec.size)
    map_file = Path(spec.map).absolute() if spec.map is not None else map_of_world(world)
    if map_file is not None:
        load_map(map_file)
    defaults = default_parameters()
    overrides = Overrides()
    if spec.params is not None:
        overrides = load_overrides(Path(spec.params), spec.robot_names, defaults)
        without = {*overrides.world.broken_map, *spec.driven_by_users}
        if len(without) == spec.size:
            raise ConfigError(f"{spec.params}: /world: broken leaves no robot that works")
        if both := set(spec.driven_by_users) & overrides.world.broken_map.keys():
            names = ", ".join(sorted(both))
            raise ConfigError(f"{spec.params}: {names} is broken and external; choose one")
    if spec.parameters:
        overrides = overrides.followed_by(spec.parameters, defaults)
    if overrides.central and not spec.coordination.has_centre:
        raise ConfigError(f"{spec.params}: /central needs --coordination central")
    for pattern, values in overrides.sections.items():
        if "traffic.coordination" in values:
            raise ConfigError(
                f"{spec.params}: {pattern}: traffic.coordination is that of --coordination"
            )
    mission = load_mission(spec.mission).with_groups(sites) if spec.mission else None
    # the number of the last robot of each mission; None is the one of all others
    stations: set[str] = set()
    last = {member.mission or None: number for number, member in enumerate(fleet.members, 1)}
    for name, number in ({None: 1} | last).items():
        each = mission if name is None else load_mission(name)
        if each is not None:
            if name is not None and each.orders is not None:
                raise ConfigError(
                    f"mission {each.name} of a robot of the fleet has orders, which are for a whole"
                    " swarm: give it by --mission"
                )
            if not has_sites and each.stations:
                raise ConfigError(
                    f"mission {each.name} needs stations, but {sites_path} is missing"
                )
            where = f"{sites_path}, for mission {each.name}"
            each.check_stations(sites, where, robots=len(fleet.members), highest=number)
            stations |= set(each.stations)
    is_told = mission is not None or all(member.mission for member in fleet.members)
    for start in dict.fromkeys(m.start for m in fleet.members if isinstance(m.start, str)):
        sites.spawn_named(start)
    is_given = bool(spec.lanes)
    found = lanes_remarks(sites.zones, world, mission, is_given=is_given)
    zones = lanes_for(sites.zones, mission, is_given=is_given)
    if zones is not sites.zones:
        spec = msgspec.structs.replace(spec, lanes=NO_LANES)
        sites = replace(sites, zones=zones)
    plan = RunPlan(
        spec=spec,
        world=world,
        map=map_file,
        sites_path=sites_path if has_sites else None,
        sites=sites,
        fleet=fleet,
        mission=mission,
        stations=tuple(sorted(stations | set(sites.charging))) if is_told else None,
        defaults=defaults,
        overrides=overrides,
    )
    return replace(plan, remarks=(*_check_energy(plan), *_check_orders(plan), *found))


def _check_orders(plan: RunPlan) -> list[str]:
    """Return what may end badly with the mission's orders; refuse what no swarm can serve."""
    if plan.mission is None or (orders := plan.mission.orders) is None:
        return []
    spec, specs = plan.spec, [member.spec for member in plan.fleet.members]
    if any(member.mission for member in plan.fleet.members):
        raise ConfigError(
            "robots of the fleet have missions of their own, and --mission has orders"
        )
    is_finite = all(stream.arrivals.is_finite for stream in orders.streams)
    if spec.until_done and spec.duration is None and not is_finite:
        raise ConfigError(
            f"--until-done: the orders of {plan.mission.name} never end; give --duration SECONDS"
        )
    load_dispatcher(orders.dispatch)
    grid = None if plan.map is None else plan.sites.zones.mark(load_map(plan.map).upright())
    return measured_demand(orders, plan.sites, grid, specs, len(plan.alive))[1]


def _check_energy(plan: RunPlan) -> list[str]:
    """Return what may end badly for want of energy; refuse what is certain to."""
    spec = plan.spec
    members = dict(zip(spec.robot_names, plan.fleet.members, strict=True))
    if all(member.spec.battery is None for member in members.values()):
        return []
    stops: dict[str, list[Stop]] = {}
    for number, (name, member) in enumerate(members.items(), 1):
        chosen = member.mission or spec.mission
        mission = load_mission(chosen) if chosen else None
        if mission is not None and mission.orders is None and not mission.needs_all_homes:
            home = Pose(math.nan, math.nan, math.nan)  # the world chooses it later
            stops[name] = mission.stops(
                plan.sites, home, seed=spec.seed, robot_id=number, laps=spec.laps,
                limit=spec.goals_per_robot,
            )  # fmt: skip
    where = str(plan.sites_path or plan.world.parent / SITES_FILE)
    return check_energy({n: m.spec for n, m in members.items()}, stops, plan.sites, where)
