"""The command `swarm-up`."""

from __future__ import annotations

import os
import sys
from typing import Any

import typer

from swarm_commander.cli.robot_table import robot_table
from swarm_commander.cli.session import start
from swarm_common.middleware.secret import given_secret
from swarm_common.model.errors import ConfigError
from swarm_describe.files.packages import add_package_paths
from swarm_run.arguments import UpArguments, signature_of
from swarm_run.host_options import Role, check_combination

SWEEP = "swarm_bench.capacity.on_graph"  # runs this command for each value
PLACE = ("role", "robots", "connect", "bind")  # options of a run on several hosts
EXAMPLES = """Examples:

swarm-up --viewer

swarm-up --swarm-size 20 --mission loading_route --until-done

swarm-up --world warehouse --swarm-size 30 --mission warehouse_orders --viewer --speed 5

swarm-up --world my_hall.sdf --map my_hall.yaml --robot my_robot.urdf --rviz
"""

up_app = typer.Typer(rich_markup_mode="rich")


def _up(context: typer.Context, **values: Any) -> None:
    """Start a swarm of robots: world, navigators and, if wanted, their mission.

    Exit code: 0 all goals reached without collision, or stopped by you or at
    --duration without a miss or a collision; 1 a goal missed (also by
    --duration, if --until-done is given) or a collision; 2 bad input; 3 a
    component failed; 130 Ctrl-C before the robots drove.
    """
    arguments = UpArguments(**values)
    if arguments.describe is not None:
        add_package_paths(arguments.package_path or [])
        typer.echo(robot_table(arguments.describe))
        raise typer.Exit()
    role, robots, connect, bind = (getattr(arguments, name) for name in PLACE)
    check_combination(role, robots, connect, bind)
    if role is Role.ROBOTS:
        from swarm_commander.hosts import hosts_command, robots_plan

        plan = robots_plan.robots_plan(
            robots or "",
            connect or "",
            bind,
            arguments.pack,
            arguments.run_dir,
            _typed(context),
            given_secret(os.environ),
        )
        raise typer.Exit(hosts_command.bring_up_robots(plan))
    if arguments.sweep:
        os.execv(sys.executable, (sys.executable, "-m", SWEEP, *sys.argv[1:]))
    if arguments.warm_up is not None:
        raise ConfigError("--warm-up is for --sweep")
    raise typer.Exit(start(arguments.options()))


_up.__signature__ = signature_of(UpArguments)  # type: ignore[attr-defined]
up_app.command("up", epilog=EXAMPLES)(_up)


def _typed(context: typer.Context) -> dict[str, object]:
    return {
        name: value
        for name, value in context.params.items()
        if getattr(context.get_parameter_source(name), "name", "") == "COMMANDLINE"
    }
