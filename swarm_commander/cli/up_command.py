"""The command `swarm-up`: its options."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Annotated

import typer

from swarm_commander.cli.listing import listing, world_names
from swarm_commander.cli.session import bring_up
from swarm_commander.hosts.host_options import Role, check_combination
from swarm_commander.mission.mission import mission_names
from swarm_commander.run.domain import DomainLock, domain_id
from swarm_commander.run.input.options import (
    DEFAULT_ROBOT,
    LOOPBACK,
    VIEWER_PORT,
    UpOptions,
    parse_speed,
    robot_names,
    robot_of,
    swarm_size_of,
)
from swarm_commander.run.input.plan import check_plan
from swarm_commander.viewers.rviz import windows
from swarm_common.files.bytecode import ensure_bytecode, own_packages
from swarm_common.middleware.addresses import check_address, check_port, own_address
from swarm_common.middleware.secret import given_secret
from swarm_common.model.errors import ConfigError
from swarm_common.robots.fleet import fleet_names, load_fleet
from swarm_common.robots.loading import robot_names as robot_models
from swarm_common.robots.packages import add_package_paths
from swarm_setup.build import ensure_interfaces, interface_packages

SWARM, MISSION, SIMULATION = "Robots and world", "Mission and end", "Simulation"
VIEW, OUTPUT, HOSTS = "Windows", "Recording and report", "Several hosts"
EXAMPLES = """Examples:

swarm-up --viewer

swarm-up --swarm-size 20 --mission loading_route --until-done

swarm-up --world warehouse --swarm-size 30 --mission warehouse_orders --viewer --speed 5

swarm-up --world my_hall.sdf --map my_hall.yaml --robot my_robot.urdf --rviz
"""

up_app = typer.Typer(rich_markup_mode="rich")


def _list(wanted: bool) -> None:
    """Answer --list."""
    if wanted:
        typer.echo(listing())
        raise typer.Exit()


@up_app.command(epilog=EXAMPLES)
def up(
    context: typer.Context,
    list_: Annotated[
        bool,
        typer.Option(
            "--list",
            help="List the worlds, missions, robots and fleets to choose from, and exit.",
            is_eager=True,
            callback=_list,
        ),
    ] = False,
    swarm_size: Annotated[
        int | None, typer.Option(show_default="5", rich_help_panel=SWARM, help="Number of robots.")
    ] = None,
    world: Annotated[
        str,
        typer.Option(
            autocompletion=world_names, rich_help_panel=SWARM, help="Name or path of a world."
        ),
    ] = "slim_blockage",
    robot: Annotated[
        str | None,
        typer.Option(
            autocompletion=robot_models,
            show_default=DEFAULT_ROBOT,
            rich_help_panel=SWARM,
            help="Robot model.",
        ),
    ] = None,
    fleet: Annotated[
        str | None,
        typer.Option(
            autocompletion=fleet_names,
            rich_help_panel=SWARM,
            help="Name or file of a fleet of several robot models.",
        ),
    ] = None,
    package_path: Annotated[
        list[Path] | None,
        typer.Option(
            "--package-path",
            rich_help_panel=SWARM,
            help="Folder in which a robot's ROS packages are.",
        ),
    ] = None,
    map_: Annotated[
        Path | None,
        typer.Option(
            "--map", rich_help_panel=SWARM, help="Nav2 map (.yaml) to use instead of the world's."
        ),
    ] = None,
    skip_missing: Annotated[
        bool,
        typer.Option(
            "--skip-missing",
            rich_help_panel=SWARM,
            help="Leave out models and meshes of the world that are not found.",
        ),
    ] = False,
    skip_broken: Annotated[
        bool,
        typer.Option(
            "--skip-broken",
            rich_help_panel=SWARM,
            help="Leave out models of the world that are unusable.",
        ),
    ] = False,
    params: Annotated[
        Path | None,
        typer.Option(rich_help_panel=SWARM, help="ROS 2 parameter file for navigators and world."),
    ] = None,
    mission: Annotated[
        str | None,
        typer.Option(
            autocompletion=mission_names, rich_help_panel=MISSION, help="Name or file of a mission."
        ),
    ] = None,
    laps: Annotated[
        int,
        typer.Option(
            rich_help_panel=MISSION, help="Number of times that each robot drives the mission."
        ),
    ] = 1,
    goals_per_robot: Annotated[
        int | None,
        typer.Option(
            rich_help_panel=MISSION, help="End each robot's mission after this many goals."
        ),
    ] = None,
    seed: Annotated[
        int,
        typer.Option(
            rich_help_panel=SIMULATION,
            help="Seed of all random numbers; the same seed repeats the run.",
        ),
    ] = 0,
    realistic: Annotated[
        bool,
        typer.Option(
            "--realistic/--ideal",
            rich_help_panel=SIMULATION,
            help="Noisy sensors and localisation by AMCL.",
        ),
    ] = False,
    drive: Annotated[
        str | None,
        typer.Option(
            show_default="wheels",
            rich_help_panel=SIMULATION,
            help="wheels: rigid bodies; planar: kinematic, for large swarms.",
        ),
    ] = None,
    speed: Annotated[
        str | None,
        typer.Option(
            show_default="1.0 with viewer or without mission",
            rich_help_panel=SIMULATION,
            help="Multiple of real time, or max.",
        ),
    ] = None,
    free_run: Annotated[
        bool,
        typer.Option(
            "--free-run", rich_help_panel=SIMULATION, help="No lockstep; runs no longer repeat."
        ),
    ] = False,
    pack: Annotated[
        int, typer.Option(rich_help_panel=SIMULATION, help="Navigators per process.")
    ] = 1,
    until_done: Annotated[
        bool,
        typer.Option(
            "--until-done", rich_help_panel=MISSION, help="Stop when the mission is done."
        ),
    ] = False,
    duration: Annotated[
        float | None,
        typer.Option(rich_help_panel=MISSION, help="Stop after this many simulated seconds."),
    ] = None,
    headless: Annotated[
        bool, typer.Option("--headless", rich_help_panel=VIEW, help="Open no window.")
    ] = False,
    viewer: Annotated[
        bool, typer.Option(rich_help_panel=VIEW, help="3D view in the browser.")
    ] = False,
    port: Annotated[
        int, typer.Option(rich_help_panel=VIEW, help="TCP port of the viewer.")
    ] = VIEWER_PORT,
    viewer_host: Annotated[
        str, typer.Option(rich_help_panel=VIEW, help="Address that the viewer listens on.")
    ] = LOOPBACK,
    rviz: Annotated[
        str | None,
        typer.Option(
            rich_help_panel=VIEW,
            help="Open RViz: for the swarm, or for Srobot3,Srobot4, or for all robots; merged:"
            " the swarm with its models.",
            metavar="[NAMES]",
        ),
    ] = None,
    autostart: Annotated[
        bool, typer.Option(rich_help_panel=SIMULATION, help="Activate the navigators at the start.")
    ] = True,
    record: Annotated[
        bool,
        typer.Option(
            "--record", rich_help_panel=OUTPUT, help="Record the topics to recording/ (MCAP)."
        ),
    ] = False,
    record_topics: Annotated[
        str,
        typer.Option(
            rich_help_panel=OUTPUT,
            help="Topics to record, like scan,*costmap,/Srobot1/*; or all.",
            show_default=False,
        ),
    ] = "",
    record_rate: Annotated[
        float | None,
        typer.Option(
            show_default="all",
            rich_help_panel=OUTPUT,
            help="Most messages of a topic per simulated second.",
        ),
    ] = None,
    page: Annotated[
        bool,
        typer.Option(
            "--report/--no-report", rich_help_panel=OUTPUT, help="Draw report.html at the end."
        ),
    ] = True,
    run_dir: Annotated[
        Path | None,
        typer.Option(
            show_default="a new one in runs/", rich_help_panel=OUTPUT, help="Folder of this run."
        ),
    ] = None,
    restart: Annotated[
        bool,
        typer.Option(
            "--restart/--no-restart",
            rich_help_panel=SIMULATION,
            help="Restart processes that died or hang.",
        ),
    ] = True,
    over_limit: Annotated[
        bool,
        typer.Option("--over-limit", rich_help_panel=SWARM, help="Allow more than 100 robots."),
    ] = False,
    role: Annotated[
        Role | None,
        typer.Option(
            show_default="the whole swarm",
            rich_help_panel=HOSTS,
            help="On several hosts: the part of this host.",
        ),
    ] = None,
    robots: Annotated[
        str | None,
        typer.Option(
            rich_help_panel=HOSTS,
            help="With --role robots: numbers of the robots, like 1-50.",
            show_default=False,
        ),
    ] = None,
    connect: Annotated[
        str | None,
        typer.Option(
            rich_help_panel=HOSTS,
            help="With --role robots: address of the world's host.",
            show_default=False,
        ),
    ] = None,
    bind: Annotated[
        str | None,
        typer.Option(
            show_default="the route to --connect",
            rich_help_panel=HOSTS,
            help="Address or interface to use.",
        ),
    ] = None,
) -> None:
    """Start a swarm of robots: world, navigators and, if wanted, their mission.

    Exit code: 0 all goals reached without collision, or stopped by you or at
    --duration without a miss or a collision; 1 a goal missed (also by
    --duration, if --until-done is given) or a collision; 2 bad input; 3 a
    component failed.
    """
    check_combination(role, robots, connect, bind)
    if role is Role.ROBOTS:
        from swarm_commander.hosts import hosts_command, robots_plan

        plan = robots_plan.robots_plan(
            robots or "",
            connect or "",
            bind,
            pack,
            run_dir,
            _typed(context),
            given_secret(os.environ),
        )
        raise typer.Exit(hosts_command.bring_up_robots(plan))
    check_port(port)
    if viewer and headless:
        raise ConfigError("--viewer and --headless exclude each other")
    if viewer:
        DomainLock(domain_id()).release()  # a swarm that runs has the port, too
        check_address(viewer_host, port)
    add_package_paths(package_path or [])
    crew = load_fleet(fleet) if fleet is not None else None
    options = UpOptions(
        swarm_size=swarm_size_of(swarm_size, crew),
        world=world,
        robot=robot_of(robot, crew),
        fleet=crew,
        map=map_,
        params=params,
        mission=mission,
        laps=laps,
        goals_per_robot=goals_per_robot,
        seed=seed,
        realistic=realistic,
        drive=drive,
        speed=parse_speed(speed, viewer or mission is None),
        free_run=free_run,
        pack=pack,
        until_done=until_done,
        duration=duration,
        autostart=autostart,
        page=page,
        rviz=_windows(rviz, headless, swarm_size_of(swarm_size, crew)),
        viewer=viewer,
        viewer_host=viewer_host,
        port=port,
        record=record,
        record_topics=record_topics,
        record_rate=record_rate,
        run_dir=run_dir,
        over_limit=over_limit,
        restart=restart,
        skip_missing=skip_missing,
        skip_broken=skip_broken,
        bind=_address_to_bind(bind),
    )
    run_plan = check_plan(options)
    lock = DomainLock(domain_id())  # from now on commands in other terminals wait for us
    ensure_interfaces()
    code = bring_up(run_plan, lock)
    ensure_bytecode([*own_packages(), *interface_packages()])  # for the next start
    raise typer.Exit(code)


def _typed(context: typer.Context) -> dict[str, object]:
    """Return the options that were given on the command line."""
    return {
        name: value
        for name, value in context.params.items()
        if getattr(context.get_parameter_source(name), "name", "") == "COMMANDLINE"
    }


def _address_to_bind(bind: str | None) -> str:
    """Return the own address of --bind, empty without one."""
    if bind is None:
        return ""
    from swarm_common.middleware.dds_profile import check_environment

    check_environment(os.environ)
    return own_address(bind)


def _windows(text: str | None, headless: bool, swarm_size: int) -> tuple[str, ...]:
    """Return which windows of RViz to open."""
    if text is None:
        return ()
    if headless:
        raise ConfigError("--rviz and --headless exclude each other")
    return tuple(windows(text, robot_names(swarm_size)))
