"""The options of `swarm-up`, as typed; a run is described by what they come to."""

from __future__ import annotations

import functools
import inspect
import os
from dataclasses import dataclass, fields
from functools import partial
from pathlib import Path
from typing import Annotated, Any, get_type_hints

import typer

from swarm_common.middleware.addresses import check_address, check_port, own_address
from swarm_common.model.coordination import Coordination
from swarm_common.model.errors import ConfigError
from swarm_common.model.robot_names import DEFAULT, RobotNames
from swarm_common.process.browser import has_display
from swarm_describe.files.packages import add_package_paths
from swarm_describe.robots.fleet import fleet_names, load_fleet
from swarm_describe.robots.source import robot_names as robot_models
from swarm_mission.mission import mission_names
from swarm_run.domain import DomainLock, domain_id
from swarm_run.fleet_link import fleet_link
from swarm_run.host_options import Role
from swarm_run.listing import listing, world_names
from swarm_run.options import (
    DEFAULT_ROBOT,
    LOOPBACK,
    VIEWER_PORT,
    UpOptions,
    names_of,
    parse_speed,
    robot_of,
    swarm_size_of,
    windows,
)

# Options by their panel of the help text.
_swarm = partial(typer.Option, rich_help_panel="Robots and world")
_mission = partial(typer.Option, rich_help_panel="Mission and end")
_simulation = partial(typer.Option, rich_help_panel="Simulation")
_windows = partial(typer.Option, rich_help_panel="Windows")
_output = partial(typer.Option, rich_help_panel="Recording and report")
_hosts = partial(typer.Option, rich_help_panel="Several hosts")
_vda5050 = partial(typer.Option, rich_help_panel="Fleet control (VDA 5050)", show_default=False)


def _list(wanted: bool) -> None:
    if wanted:
        typer.echo(listing())
        raise typer.Exit()


@dataclass(frozen=True, slots=True, kw_only=True)
class UpArguments:
    """The command line of `swarm-up`, one field per option; most names are those of `UpOptions`."""

    list_: Annotated[
        bool,
        typer.Option(
            "--list",
            help="List the worlds, missions, robots and fleets to choose from, and exit.",
            is_eager=True,
            callback=_list,
        ),
    ] = False
    swarm_size: Annotated[int | None, _swarm(show_default="5", help="Number of robots.")] = None
    world: Annotated[str, _swarm(autocompletion=world_names, help="Name or path of a world.")] = (
        "slim_blockage"
    )
    robot: Annotated[
        str | None,
        _swarm(autocompletion=robot_models, show_default=DEFAULT_ROBOT, help="Robot model."),
    ] = None
    describe: Annotated[
        str | None,
        _swarm(
            autocompletion=robot_models,
            help="Show what is known of a robot model, and where each value is from; then exit.",
            metavar="ROBOT",
            show_default=False,
        ),
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
        list[Path] | None,
        _swarm("--package-path", help="Folder in which a robot's ROS packages are."),
    ] = None
    map_: Annotated[
        Path | None, _swarm("--map", help="Nav2 map (.yaml) to use instead of the world's.")
    ] = None
    keepout_mask: Annotated[
        Path | None,
        _swarm("--keepout-mask", help="Filter mask (.yaml) of keepout zones, as Nav2 has them."),
    ] = None
    speed_mask: Annotated[
        Path | None,
        _swarm("--speed-mask", help="Filter mask (.yaml) of speed limits, as Nav2 has them."),
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
        Path | None, _swarm(help="ROS 2 parameter file for navigators and world.")
    ] = None
    mission: Annotated[
        str | None, _mission(autocompletion=mission_names, help="Name or file of a mission.")
    ] = None
    laps: Annotated[int, _mission(help="Number of times that each robot drives the mission.")] = 1
    goals_per_robot: Annotated[
        int | None, _mission(help="End each robot's mission after this many goals.")
    ] = None
    seed: Annotated[
        int, _simulation(help="Seed of all random numbers; the same seed repeats the run.")
    ] = 0
    realistic: Annotated[
        bool, _simulation("--realistic/--ideal", help="Noisy sensors and localisation by AMCL.")
    ] = False
    drive: Annotated[
        str | None,
        _simulation(
            show_default="wheels",
            help="wheels: rigid bodies; planar: kinematic, for large swarms.",
        ),
    ] = None
    speed: Annotated[
        str | None,
        _simulation(
            show_default="1.0 with viewer or without mission",
            help="Multiple of real time, or max.",
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
    pack: Annotated[int, _simulation(help="Navigators per process.")] = 1
    until_done: Annotated[bool, _mission("--until-done", help="Stop when the mission is done.")] = (
        False
    )
    duration: Annotated[float | None, _mission(help="Stop after this many simulated seconds.")] = (
        None
    )
    headless: Annotated[bool, _windows("--headless", help="Open no window.")] = False
    viewer: Annotated[bool, _windows(help="3D view in the browser.")] = False
    open_: Annotated[
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
    sweep: Annotated[
        list[str] | None,
        _output(
            help="Runs for each value of an option or parameter: robots=4,8,12; with a page.",
            show_default=False,
        ),
    ] = None
    warm_up: Annotated[
        float | None,
        _output(show_default="a sixth of --duration", help="Time [s] that a sweep leaves out."),
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
        float | None,
        _output(show_default="all", help="Most messages of a topic per simulated second."),
    ] = None
    page: Annotated[bool, _output("--report/--no-report", help="Draw report.html at the end.")] = (
        True
    )
    run_dir: Annotated[
        Path | None, _output(show_default="a new one in runs/", help="Folder of this run.")
    ] = None
    restart: Annotated[
        bool,
        _simulation("--restart/--no-restart", help="Restart processes that died or hang."),
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
        str | None, _vda5050(help="2.1 or 3.0.  [default: 2.1]", metavar="VERSION")
    ] = None
    vda5050_user: Annotated[
        str | None,
        _vda5050(help="User of the broker; the password is in SWARM_VDA5050_PASSWORD."),
    ] = None
    vda5050_ca: Annotated[
        Path | None, _vda5050(help="Certificates to trust with mqtts.  [default: the system's]")
    ] = None

    def options(self) -> UpOptions:
        """Return what they ask for on this host, checked."""
        check_port(self.port)
        viewer = self.viewer or bool(self.open_)
        if viewer and self.headless:
            raise ConfigError("--viewer and --headless exclude each other")
        if viewer:
            DomainLock(domain_id()).release()  # a swarm that runs has the port, too
            check_address(self.viewer_host, self.port)
        add_package_paths(self.package_path or [])
        fleet = load_fleet(self.fleet) if self.fleet is not None else None
        size = swarm_size_of(self.swarm_size, fleet)
        names = names_of(self.names, fleet, size)
        converted: dict[str, Any] = {
            "swarm_size": size,
            "robot": robot_of(self.robot, fleet),
            "fleet": fleet,
            "names": names,
            "map": self.map_,
            "speed": parse_speed(self.speed, viewer or self.mission is None),
            "viewer": viewer,
            "open_page": viewer and (has_display() if self.open_ is None else self.open_),
            "rviz": _rviz_windows(self.rviz, self.headless, names, size),
            "bind": _address_to_bind(self.bind),
            "vda5050": fleet_link(
                self.vda5050,
                self.manufacturer,
                self.vda5050_version,
                self.vda5050_user,
                self.vda5050_ca,
            ),
        }
        given = {item.name for item in fields(self)}
        same = {item.name for item in fields(UpOptions)} & given - converted.keys()
        return UpOptions(**converted, **{name: getattr(self, name) for name in same})


@functools.cache
def parser() -> Any:
    """Return the command line of `swarm-up` that runs nothing."""

    def ignore(context: typer.Context, **_: Any) -> None: ...

    ignore.__signature__ = signature_of(UpArguments)  # type: ignore[attr-defined]
    app = typer.Typer()
    app.command()(ignore)
    return typer.main.get_command(app)


def signature_of(kind: type) -> inspect.Signature:
    """Return the signature from which typer makes the options of a dataclass."""
    hints = get_type_hints(kind, include_extras=True)
    by_name = inspect.Parameter.KEYWORD_ONLY
    options = [
        inspect.Parameter(item.name, by_name, default=item.default, annotation=hints[item.name])
        for item in fields(kind)
    ]
    context = inspect.Parameter(
        "context", inspect.Parameter.POSITIONAL_OR_KEYWORD, annotation=typer.Context
    )
    return inspect.Signature([context, *options])


def _address_to_bind(bind: str | None) -> str:
    """Return the own address of --bind, empty without one."""
    if bind is None:
        return ""
    from swarm_common.middleware.dds_profile import check_environment

    check_environment(os.environ)
    return own_address(bind)


def _rviz_windows(
    text: str | None, headless: bool, names: RobotNames, swarm_size: int
) -> tuple[str, ...]:
    if text is None:
        return ()
    if headless:
        raise ConfigError("--rviz and --headless exclude each other")
    return tuple(windows(text, names.first(swarm_size)))
