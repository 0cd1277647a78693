"""Options of `swarm-up`, checked once."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path

from swarm_common.files.zones_io import KEEPOUT_MASK, SPEED_MASK
from swarm_common.middleware.ros_env import (
    FEW_ROBOTS,
    MOST_PARTICIPANTS,
    TERMINALS,
    participants_of,
)
from swarm_common.model.coordination import Coordination
from swarm_common.model.engines import check_engine
from swarm_common.model.errors import ConfigError, UnknownNameError
from swarm_common.model.robot_names import RobotNames
from swarm_describe.robots.fleet import Fleet
from swarm_recording.selection import select
from swarm_run.fleet_link import FleetLink

SIZE_LIMIT = 100  # robots, without --over-limit
DEFAULT_SIZE = 5
LOOPBACK = "127.0.0.1"
DRIVES = {"wheels": "bullet", "planar": "planar"}  # by the world's engines
VIEWER_PORT = 8080
DEFAULT_ROBOT = "turtlebot3_waffle"
SWARM, MERGED, ALL = "swarm", "merged", "all"  # windows of RViz beside those of robots


@dataclass(frozen=True, slots=True, kw_only=True)
class UpOptions:
    """Options of the user; names as on the command line."""

    swarm_size: int = DEFAULT_SIZE
    world: str = "slim_blockage"
    robot: str = DEFAULT_ROBOT  # with a fleet: its models
    fleet: Fleet | None = None
    names: RobotNames = field(default_factory=RobotNames)
    external: tuple[str, ...] = ()  # robots that nodes of the user drive; from programs
    map: Path | None = None
    keepout_mask: Path | None = None  # in place of that of sites.yaml
    speed_mask: Path | None = None
    params: Path | None = None
    mission: str | None = None
    laps: int = 1
    goals_per_robot: int | None = None
    seed: int = 0
    realistic: bool = False  # sensors that err, and AMCL
    drive: str | None = None  # one of DRIVES; None: the engine in the world's parameters
    speed: float | None = None  # times real time; None for as fast as possible
    paused: bool = False  # whether time passes by steps only; from programs
    free_run: bool = False
    pack: int = 1
    until_done: bool = False
    duration: float | None = None  # [s] of simulated time
    autostart: bool = True
    page: bool = True  # report.html, at the end
    rviz: tuple[str, ...] = ()  # windows to open: names of robots, or swarm
    record: bool = False
    record_topics: str = ""  # names or patterns, empty for the usual ones
    record_rate: float | None = None  # messages per simulated second of each topic
    viewer: bool = False
    viewer_host: str = LOOPBACK
    port: int = VIEWER_PORT  # of the viewer
    run_dir: Path | None = None
    over_limit: bool = False
    restart: bool = True
    open_page: bool = False  # the viewer in a browser
    skip_missing: bool = False  # leave out models and meshes that are not found
    skip_broken: bool = False  # leave out models of a world that are unusable
    bind: str = ""  # address of this host with --role world; empty: all is on one host
    vda5050: FleetLink | None = None  # None: no fleet control of another maker drives the robots
    coordination: Coordination = Coordination.DECENTRAL

    def __post_init__(self) -> None:
        _at_least(1, "--swarm-size", self.swarm_size)
        if self.swarm_size > SIZE_LIMIT and not self.over_limit:
            raise ConfigError(
                f"--swarm-size is {self.swarm_size}; more than {SIZE_LIMIT} robots need"
                " --over-limit"
            )
        _at_least(1, "--pack", self.pack)
        self._check_processes()
        if self.drive is not None and self.drive not in DRIVES:
            raise UnknownNameError("drive", self.drive, list(DRIVES))
        if self.bind and self.coordination.has_centre:
            raise ConfigError("--coordination is for robots of one host: leave out --role")
        check_engine(DRIVES.get(self.drive or ""), f"--drive {self.drive}")
        _at_least(1, "--laps", self.laps)
        _at_least(0, "--seed", self.seed)
        if self.goals_per_robot is not None:
            _at_least(1, "--goals-per-robot", self.goals_per_robot)
        if self.duration is not None and not (self.duration > 0 and math.isfinite(self.duration)):
            raise ConfigError(f"--duration is {self.duration}; it must be a positive time in s")
        self._check_mission()
        self._check_recording()
        self._check_external()
        self._check_vda5050()
        if self.bind and self.pack != 1:
            raise ConfigError("--pack belongs to the robots' hosts: give it with --role robots")

    @property
    def processes(self) -> int:
        """Navigator processes."""
        return -(-self.swarm_size // self.pack)

    @property
    def masks(self) -> dict[str, Path]:
        """Filter masks that were given, by their key in `zones:` of sites.yaml."""
        given = {KEEPOUT_MASK: self.keepout_mask, SPEED_MASK: self.speed_mask}
        return {key: path for key, path in given.items() if path is not None}

    def _check_processes(self) -> None:
        """Refuse more processes than DDS has ids for on a host; they would wait for ever."""
        most = MOST_PARTICIPANTS - TERMINALS - participants_of(self.swarm_size, 0)
        if not self.bind and self.swarm_size > self.pack * most:
            least = -(-self.swarm_size // most) if most > 0 else 0
            hint = f"put several in each with --pack {max(least, 10)}, or " if least else ""
            raise ConfigError(
                f"--swarm-size {self.swarm_size} with --pack {self.pack} makes"
                f" {self.processes} navigator processes; DDS has ids for"
                f" {max(most, 0)} of them on one host: {hint}use several hosts (--role)"
            )

    def _check_mission(self) -> None:
        if self.mission is None:
            has_own = any(member.mission for member in self.fleet.members) if self.fleet else False
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

    @property
    def driven_by_users(self) -> tuple[str, ...]:
        """Names of the robots that have no navigator of ours."""
        in_fleet = self.fleet.external if self.fleet is not None else ()
        return tuple(dict.fromkeys((*in_fleet, *self.external)))

    def _check_vda5050(self) -> None:
        if self.vda5050 is None:
            if self.coordination is Coordination.FLEET:
                raise ConfigError(
                    "--coordination fleet leaves traffic to a fleet control: add --vda5050 URL"
                )
            return
        if self.mission is not None:
            raise ConfigError("--vda5050 and --mission exclude each other: both drive the robots")
        if self.bind:
            raise ConfigError("--vda5050 drives robots of one host: leave out --role")
        if self.swarm_size > FEW_ROBOTS:
            raise ConfigError(
                f"--vda5050 is for up to {FEW_ROBOTS} robots; --swarm-size is {self.swarm_size}"
            )

    def _check_recording(self) -> None:
        rate = self.record_rate
        if rate is not None and not (rate > 0 and math.isfinite(rate)):
            raise ConfigError(f"--record-rate is {rate}; it must be a positive number per second")
        if (rate is not None or self.record_topics) and not self.record:
            raise ConfigError("--record-topics and --record-rate need --record")
        if self.record:
            select(self.record_topics, self.robot_names)

    @property
    def robot_names(self) -> list[str]:
        """Namespaces of the robots in order."""
        return self.names.first(self.swarm_size)


def parse_speed(text: str | None, in_real_time: bool) -> float | None:
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


def swarm_size_of(given: int | None, fleet: Fleet | None) -> int:
    """Return the swarm size: as typed, that of the fleet, or the default.

    Args:
        given: Number that was typed; None if it was not.
        fleet: None without --fleet.

    Raises:
        ConfigError: If the fleet has another number of robots.
    """
    if fleet is None:
        return DEFAULT_SIZE if given is None else given
    if given is not None and given != len(fleet.members):
        raise ConfigError(
            f"--swarm-size is {given}, but the --fleet has {len(fleet.members)} robots;"
            " leave one of them out"
        )
    return len(fleet.members)


def names_of(given: str | None, fleet: Fleet | None, swarm_size: int) -> RobotNames:
    """Return the names of the robots: as typed, those of the fleet, or the default.

    Args:
        given: Text that was typed, a pattern or names with commas between them; None if it was not.
        fleet: None without --fleet.

    Raises:
        ConfigError: If they do not fit, or both are given.
    """
    own = fleet.names if fleet is not None else RobotNames()
    if given is None:
        return own
    if own != RobotNames():
        raise ConfigError("--names is given, but the --fleet has names, too; leave out one of them")
    return RobotNames.of([word.strip() for word in given.split(",")], swarm_size, "--names")


def robot_of(given: str | None, fleet: Fleet | None) -> str:
    """Return the robot model: as typed, what the fleet consists of, or the default.

    Args:
        given: Text that was typed; None if it was not.
        fleet: None without --fleet.

    Raises:
        ConfigError: If both a model and a fleet are given.
    """
    if fleet is None:
        return DEFAULT_ROBOT if given is None else given
    if given is not None:
        raise ConfigError("--robot and --fleet exclude each other: the fleet names its models")
    return fleet.label


def windows(text: str, robots: Sequence[str]) -> list[str]:
    """Return which windows --rviz asks for: names of robots, `swarm` or `merged`.

    Args:
        text: Names separated by commas; `all` for one window per robot, empty for the swarm.

    Raises:
        ConfigError: If a name is unknown.
    """
    names = [word.strip() for word in text.split(",") if word.strip()] or [SWARM]
    if names == [ALL]:
        return list(robots)
    for name in names:
        if name not in (SWARM, MERGED, *robots):
            raise UnknownNameError("robot", name, [*robots, ALL, SWARM, MERGED], "--rviz")
    return names


def _at_least(lowest: int, flag: str, value: int) -> None:
    if value < lowest:
        raise ConfigError(f"{flag} is {value}; it must be {lowest} or more")
