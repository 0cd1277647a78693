"""The one description of a run: the YAML file, the command line and the call in Python are this.

An option of `swarm-up` is a field of `RunSpec`: its type with its range, its flag with its help,
and its default. Command line, launch arguments, docs/reference and the file of --spec follow.
"""

from __future__ import annotations

import math
import os
from collections.abc import Mapping, Sequence
from functools import cache, cached_property, partial
from pathlib import Path
from typing import Annotated, Any, get_type_hints

import typer
from msgspec import field
from typer.models import OptionInfo

from swarm_common.files.zones_io import KEEPOUT_MASK, LANES, SPEED_MASK
from swarm_common.middleware.addresses import check_address, check_port, own_address
from swarm_common.middleware.ros_env import (
    FEW_ROBOTS,
)
from swarm_common.model.central import Coordination
from swarm_common.model.engines import check_engine
from swarm_common.model.errors import ConfigError, UnknownNameError
from swarm_common.model.robot_names import DEFAULT, RobotNames
from swarm_common.model.schema import Count, Positive, Schema, Seed, check_fields
from swarm_common.process.start import has_display
from swarm_describe.files.packages import add_package_paths
from swarm_describe.robots.fleet import Fleet, fleet_names, load_fleet
from swarm_describe.robots.source import robot_names as robot_models
from swarm_mission.mission import mission_names
from swarm_recording.selection import select
from swarm_run.domain import DomainLock, domain_id
from swarm_run.fleet_link import FleetLink, fleet_link
from swarm_run.host_options import Role, check_combination
from swarm_run.listing import world_names
from swarm_run.packing import most_processes, parse_pack

SIZE_LIMIT = 100  # robots, without --over-limit
DEFAULT_SIZE = 5
NO_LANES = "none"  # in place of the world's
LOOPBACK = "127.0.0.1"
DRIVES = {"wheels": "bullet", "planar": "planar"}  # by the world's engines
VIEWER_PORT = 8080
DEFAULT_ROBOT = "turtlebot3_waffle"
SWARM, MERGED, ALL = "swarm", "merged", "all"  # windows of RViz beside those of robots
FILE = "file"
File = Annotated[str, FILE]  # a path, which shells complete

# Flags by their panel of the help text.
SWARM_PANEL, OUTPUT_PANEL = "Robots and world", "Recording and report"
_swarm = partial(typer.Option, rich_help_panel=SWARM_PANEL)
_mission = partial(typer.Option, rich_help_panel="Mission and end")
_simulation = partial(typer.Option, rich_help_panel="Simulation")
_windows = partial(typer.Option, rich_help_panel="Windows")
_output = partial(typer.Option, rich_help_panel=OUTPUT_PANEL)
_hosts = partial(typer.Option, rich_help_panel="Several hosts")
_vda5050 = partial(typer.Option, rich_help_panel="Fleet control (VDA 5050)", show_default=False)


class RunSpec(Schema, frozen=True, kw_only=True, dict=True, omit_defaults=True):
    """A run as its user describes it; names as on the command line.

    Properties are what follows from the fields; `check` refuses what makes no sense.
    """

    swarm_size: Annotated[Count | None, _swarm(show_default="5", help="Number of robots.")] = None
    world: Annotated[str, _swarm(autocompletion=world_names, help="Name or path of a world.")] = (
        "slim_blockage"
    )
    robot: Annotated[
        str | None,
        _swarm(autocompletion=robot_models, show_default=DEFAULT_ROBOT, help="Robot model."),
    ] = None
    fleet: Annotated[
        str | None,
        _swarm(autocompletion=fleet_names, help="Name or file of a fleet of several robot models."),
    ] = None
    names: Annotated[
        str | None,
        _swarm(
            show_default=DEFAULT,
            help="Names of the robots: agv{} or agv_{:02} with their numbers, or a list: ann,bob.",
        ),
    ] = None
    package_path: Annotated[
        tuple[File, ...],
        _swarm("--package-path", help="Folder in which a robot's ROS packages are."),
    ] = ()
    map: Annotated[
        File | None, _swarm("--map", help="Nav2 map (.yaml) to use instead of the world's.")
    ] = None
    keepout_mask: Annotated[
        File | None,
        _swarm("--keepout-mask", help="Filter mask (.yaml) of keepout zones, as Nav2 has them."),
    ] = None
    speed_mask: Annotated[
        File | None,
        _swarm("--speed-mask", help="Filter mask (.yaml) of speed limits, as Nav2 has them."),
    ] = None
    lanes: Annotated[
        File | None,
        _swarm(
            "--lanes",
            help="Filter mask (.yaml) of preferred lanes, see swarm-bench lanes; none: without.",
        ),
    ] = None
    skip_missing: Annotated[
        bool,
        _swarm(
            "--skip-missing", help="Leave out models and meshes of the world that are not found."
        ),
    ] = False
    skip_broken: Annotated[
        bool, _swarm("--skip-broken", help="Leave out models of the world that are unusable.")
    ] = False
    params: Annotated[
        File | None, _swarm(help="ROS 2 parameter file for navigators and world.")
    ] = None
    mission: Annotated[
        str | None, _mission(autocompletion=mission_names, help="Name or file of a mission.")
    ] = None
    laps: Annotated[Count, _mission(help="Number of times that each robot drives the mission.")] = 1
    goals_per_robot: Annotated[
        Count | None, _mission(help="End each robot's mission after this many goals.")
    ] = None
    seed: Annotated[
        Seed, _simulation(help="Seed of all random numbers; the same seed repeats the run.")
    ] = 0
    realistic: Annotated[
        bool, _simulation("--realistic/--ideal", help="Noisy sensors and localisation by AMCL.")
    ] = False
    drive: Annotated[
        str | None,
        _simulation(
            show_default="wheels", help="wheels: rigid bodies; planar: kinematic, for large swarms."
        ),
    ] = None
    speed: Annotated[
        str | float | None,
        _simulation(
            show_default="1.0 with viewer or without mission", help="Multiple of real time, or max."
        ),
    ] = None
    free_run: Annotated[
        bool, _simulation("--free-run", help="No lockstep; runs no longer repeat.")
    ] = False
    coordination: Annotated[
        Coordination,
        _simulation(
            help="Who decides: decentral, central, central-with-fallback, or a fleet control alone."
        ),
    ] = Coordination.DECENTRAL
    pack: Annotated[
        str | int | None,
        _simulation(show_default="1", help="Navigators per process, or auto: by the processors."),
    ] = None
    until_done: Annotated[bool, _mission("--until-done", help="Stop when the mission is done.")] = (
        False
    )
    duration: Annotated[
        Positive | None, _mission(help="Stop after this many simulated seconds.")
    ] = None
    headless: Annotated[bool, _windows("--headless", help="Open no window.")] = False
    viewer: Annotated[bool, _windows(help="3D view in the browser.")] = False
    open: Annotated[
        bool | None,
        _windows(
            "--open/--no-open",
            show_default="where there is a display",
            help="Open the viewer in a browser; --open implies --viewer.",
        ),
    ] = None
    port: Annotated[int, _windows(help="TCP port of the viewer.")] = VIEWER_PORT
    viewer_host: Annotated[str, _windows(help="Address that the viewer listens on.")] = LOOPBACK
    rviz: Annotated[
        str | None,
        _windows(
            help="Open RViz: for the swarm, or for Srobot3,Srobot4, or for all robots; merged:"
            " the swarm with its models.",
            metavar="[NAMES]",
        ),
    ] = None
    autostart: Annotated[bool, _simulation(help="Activate the navigators at the start.")] = True
    record: Annotated[bool, _output("--record", help="Record the topics to recording/ (MCAP).")] = (
        False
    )
    record_topics: Annotated[
        str,
        _output(
            help="Topics to record, like scan,*costmap,/Srobot1/*; or all.", show_default=False
        ),
    ] = ""
    record_rate: Annotated[
        Positive | None,
        _output(show_default="all", help="Most messages of a topic per simulated second."),
    ] = None
    report: Annotated[
        bool, _output("--report/--no-report", help="Draw report.html at the end.")
    ] = True
    run_dir: Annotated[
        File | None, _output(show_default="a new one in runs/", help="Folder of this run.")
    ] = None
    restart: Annotated[
        bool, _simulation("--restart/--no-restart", help="Restart processes that died or hang.")
    ] = True
    over_limit: Annotated[bool, _swarm("--over-limit", help="Allow more than 100 robots.")] = False
    role: Annotated[
        Role | None,
        _hosts(show_default="the whole swarm", help="On several hosts: the part of this host."),
    ] = None
    robots: Annotated[
        str | None,
        _hosts(help="With --role robots: numbers of the robots, like 1-50.", show_default=False),
    ] = None
    connect: Annotated[
        str | None,
        _hosts(help="With --role robots: address of the world's host.", show_default=False),
    ] = None
    bind: Annotated[
        str | None,
        _hosts(show_default="the route to --connect", help="Address or interface to use."),
    ] = None
    vda5050: Annotated[
        str | None,
        _vda5050(
            metavar="URL",
            help="MQTT broker: mqtt://HOST:PORT, mqtts://HOST:PORT, or embedded to start one.",
        ),
    ] = None
    manufacturer: Annotated[
        str | None, _vda5050(help="Manufacturer in topics and headers.  [default: swarm]")
    ] = None
    vda5050_version: Annotated[
        str | None, _vda5050(help="2.0, 2.1 or 3.0.  [default: 2.1]", metavar="VERSION")
    ] = None
    vda5050_interface: Annotated[
        str | None,
        _vda5050(help="First level of topics.  [default: uagv, in 3.0 vda5050]", metavar="NAME"),
    ] = None
    vda5050_check: Annotated[
        str | None,
        _vda5050(
            help="Judge the fleet control: strict (exit code 1 if it broke a rule) or lenient"
            " (take what can be understood). The verdict is in vda5050.json.",
            metavar="HOW",
        ),
    ] = None
    vda5050_user: Annotated[
        str | None, _vda5050(help="User of the broker; the password is in SWARM_VDA5050_PASSWORD.")
    ] = None
    vda5050_ca: Annotated[
        File | None, _vda5050(help="Certificates to trust with mqtts.  [default: the system's]")
    ] = None

    # Without a flag: for files and programs.
    parameters: Mapping[str, Any] = field(default_factory=dict)  # of all navigators, by dotted name
    vda5050_faults: tuple[Mapping[str, Any], ...] = ()  # of robots: at [s], robot, fault, more
    external: tuple[str, ...] = ()  # robots that nodes of the user drive
    paused: bool = False  # whether time passes by steps only

    def __post_init__(self) -> None:
        check_fields(self, names=_flags())

    @cached_property
    def loaded_fleet(self) -> Fleet | None:
        """Models of the robots; None where all are the same."""
        return None if self.fleet is None else load_fleet(self.fleet)

    @cached_property
    def size(self) -> int:
        """Number of robots: as given, that of the fleet, or the default."""
        if (fleet := self.loaded_fleet) is None:
            return DEFAULT_SIZE if self.swarm_size is None else self.swarm_size
        if self.swarm_size not in (None, len(fleet.members)):
            raise ConfigError(
                f"--swarm-size is {self.swarm_size}, but the --fleet has {len(fleet.members)}"
                " robots; leave one of them out"
            )
        return len(fleet.members)

    @cached_property
    def naming(self) -> RobotNames:
        """Names of all robots: as given, those of the fleet, or the default."""
        own = RobotNames() if self.loaded_fleet is None else self.loaded_fleet.names
        if self.names is None:
            return own
        if own != RobotNames():
            raise ConfigError(
                "--names is given, but the --fleet has names, too; leave out one of them"
            )
        return RobotNames.of([word.strip() for word in self.names.split(",")], self.size, "--names")

    @property
    def robot_names(self) -> list[str]:
        """Namespaces of the robots in order."""
        return self.naming.first(self.size)

    @property
    def model(self) -> str:
        """Robot model: as given, what the fleet consists of, or the default."""
        if self.loaded_fleet is None:
            return DEFAULT_ROBOT if self.robot is None else self.robot
        if self.robot is not None:
            raise ConfigError("--robot and --fleet exclude each other: the fleet names its models")
        return self.loaded_fleet.label

    @property
    def has_viewer(self) -> bool:
        """Whether the viewer runs."""
        return self.viewer or bool(self.open)

    @property
    def opens_viewer(self) -> bool:
        """Whether the viewer opens in a browser."""
        return self.has_viewer and (has_display() if self.open is None else self.open)

    @property
    def pace(self) -> float | None:
        """Simulated time, at most, in multiples of real time; None for as fast as possible."""
        return parse_speed(self.speed, in_real_time=self.has_viewer or self.mission is None)

    @property
    def pack_size(self) -> int:
        """Navigators per process."""
        return parse_pack(self.pack, self.size, most_processes(self.size))

    @property
    def rviz_windows(self) -> Sequence[str]:
        """Windows of RViz: names of robots, `swarm` or `merged`."""
        if self.rviz is None:
            return ()
        known = self.robot_names
        names = [word.strip() for word in self.rviz.split(",") if word.strip()] or [SWARM]
        if names == [ALL]:
            return known
        for name in names:
            if name not in (SWARM, MERGED, *known):
                raise UnknownNameError("robot", name, [*known, ALL, SWARM, MERGED], "--rviz")
        return names

    @cached_property
    def address(self) -> str:
        """Own address towards other hosts; empty where all is on this one."""
        if self.bind is None:
            return ""
        from swarm_common.middleware.dds_profile import check_environment

        check_environment(os.environ)
        return own_address(self.bind)

    @cached_property
    def fleet_control(self) -> FleetLink | None:
        """Link to a fleet control of another maker; None without one."""
        return fleet_link(
            self.vda5050,
            self.manufacturer,
            version=self.vda5050_version,
            interface=self.vda5050_interface,
            check=self.vda5050_check,
            faults=self.vda5050_faults or None,
            user=self.vda5050_user,
            ca=None if self.vda5050_ca is None else Path(self.vda5050_ca),
        )

    @property
    def processes(self) -> int:
        """Navigator processes."""
        return -(-self.size // self.pack_size)

    @property
    def masks(self) -> dict[str, Path | None]:
        """Filter masks that were given, by their key in `zones:` of sites.yaml; None for none."""
        given = {KEEPOUT_MASK: self.keepout_mask, SPEED_MASK: self.speed_mask, LANES: self.lanes}
        found: dict[str, Path | None] = {k: Path(path) for k, path in given.items() if path}
        return found | ({LANES: None} if self.lanes == NO_LANES else {})

    @property
    def driven_by_users(self) -> tuple[str, ...]:
        """Names of the robots that have no navigator of ours."""
        in_fleet = () if self.loaded_fleet is None else self.loaded_fleet.external
        return tuple(dict.fromkeys((*in_fleet, *self.external)))

    def check_host(self) -> None:
        """Refuse what this machine is not free for: the viewer's port, an address.

        Raises:
            ConfigError: For the first mistake.
        """
        if self.has_viewer and not self.headless:
            DomainLock(domain_id()).release()  # a swarm that runs has the port, too
            check_address(self.viewer_host, self.port)
        _ = self.address

    def check(self) -> RunSpec:
        """Refuse what makes no sense; return itself.

        Raises:
            SwarmError: For the first mistake.
        """
        check_combination(self.role, self.robots, self.connect, self.bind)
        check_port(self.port)
        add_package_paths([Path(folder) for folder in self.package_path])
        if self.size > SIZE_LIMIT and not self.over_limit:
            raise ConfigError(
                f"--swarm-size is {self.size}; more than {SIZE_LIMIT} robots need --over-limit"
            )
        if self.headless and (self.has_viewer or self.rviz is not None):
            flag = "--viewer" if self.has_viewer else "--rviz"
            raise ConfigError(f"{flag} and --headless exclude each other")
        _ = self.naming, self.model, self.pace, self.rviz_windows  # each may refuse
        self._check_processes()
        if self.drive is not None and self.drive not in DRIVES:
            raise UnknownNameError("drive", self.drive, list(DRIVES))
        if self.bind and self.coordination.has_centre:
            raise ConfigError("--coordination is for robots of one host: leave out --role")
        check_engine(DRIVES.get(self.drive or ""), f"--drive {self.drive}")
        self._check_mission()
        self._check_recording()
        self._check_external()
        self._check_vda5050()
        if self.bind and self.pack is not None:
            raise ConfigError("--pack belongs to the robots' hosts: give it with --role robots")
        return self

    def _check_processes(self) -> None:
        """Refuse more processes than DDS has ids for on a host; they would wait for ever."""
        most = most_processes(self.size)
        if not self.bind and self.size > self.pack_size * most:
            least = -(-self.size // most) if most > 0 else 0
            hint = f"put several in each with --pack {max(least, 10)}, or " if least else ""
            raise ConfigError(
                f"--swarm-size {self.size} with --pack {self.pack_size} makes"
                f" {self.processes} navigator processes; DDS has ids for"
                f" {max(most, 0)} of them on one host: {hint}use several hosts (--role)"
            )

    def _check_mission(self) -> None:
        if self.mission is None:
            has_own = (
                any(m.mission for m in self.loaded_fleet.members) if self.loaded_fleet else False
            )
            for flag, used in (
                ("a mission in the --fleet", has_own),
                ("--until-done", self.until_done),
                ("--laps", self.laps != 1),
                ("--goals-per-robot", self.goals_per_robot is not None),
            ):
                if used:
                    raise ConfigError(f"{flag} needs a --mission, for example loading_route")
        elif not self.autostart:
            raise ConfigError("--mission needs active navigators: leave out --no-autostart")
        elif self.free_run and self.until_done and self.duration is None:
            # Without lockstep nothing bounds the simulated time of a robot that hangs.
            raise ConfigError("--free-run with --until-done needs a --duration as a limit")

    def _check_external(self) -> None:
        known, external = self.robot_names, self.driven_by_users
        for name in external:
            if name not in known:
                raise UnknownNameError("robot", name, known, "external")
        if len(external) == len(known):
            raise ConfigError("external leaves no robot with a navigator of ours")
        if external and (self.free_run or self.bind):
            raise ConfigError("external robots need lockstep and one host: leave out the other")

    def _check_vda5050(self) -> None:
        if self.fleet_control is None:
            if self.coordination is Coordination.FLEET:
                raise ConfigError(
                    "--coordination fleet leaves traffic to a fleet control: add --vda5050 URL"
                )
            return
        if self.mission is not None:
            raise ConfigError("--vda5050 and --mission exclude each other: both drive the robots")
        if self.bind:
            raise ConfigError("--vda5050 drives robots of one host: leave out --role")
        if self.size > FEW_ROBOTS:
            raise ConfigError(
                f"--vda5050 is for up to {FEW_ROBOTS} robots; --swarm-size is {self.size}"
            )

    def _check_recording(self) -> None:
        if (self.record_rate is not None or self.record_topics) and not self.record:
            raise ConfigError("--record-topics and --record-rate need --record")
        if self.record:
            select(self.record_topics, self.robot_names)


@cache
def _flags() -> Mapping[str, str]:
    """Return the flag of each field that has one."""
    hints = get_type_hints(RunSpec, include_extras=True)
    return {
        name: f"--{name.replace('_', '-')}"
        for name, hint in hints.items()
        if any(isinstance(each, OptionInfo) for each in getattr(hint, "__metadata__", ()))
    }


def parse_speed(text: str | float | None, in_real_time: bool) -> float | None:
    """Return --speed as a factor of real time, None for as fast as possible.

    Args:
        text: Text that was typed, None for the default.
        in_real_time: Whether the default is real time; otherwise there is no limit.

    Raises:
        ConfigError: If it is neither `max` nor a positive number.
    """
    if text is None:
        return 1.0 if in_real_time else None
    if text == "max":
        return None
    try:
        speed = float(text)
    except ValueError:
        speed = math.nan
    if not (speed > 0 and math.isfinite(speed)):
        raise ConfigError(f"--speed is '{text}'; expected 'max' or a positive number like 2.5")
    return speed
