"""The command `swarm-up`."""

from __future__ import annotations

import os
import sys
from pathlib import Path
from typing import Any

import typer

from swarm_commander.cli.robot_table import robot_table
from swarm_commander.cli.session import start
from swarm_common.middleware.secret import given_secret
from swarm_common.model.errors import ConfigError
from swarm_describe.files.packages import add_package_paths
from swarm_run.flags import actions_of, signature, stated_of, text_of
from swarm_run.host_options import Role, check_combination
from swarm_run.spec import RunSpec

SWEEP = "swarm_bench.capacity.on_graph"  # runs this command for each value
EXAMPLES = """Examples:

swarm-up --viewer

swarm-up --swarm-size 20 --mission loading_route --until-done

swarm-up --world warehouse --swarm-size 30 --mission warehouse_orders --viewer --speed 5

swarm-up --world my_hall.sdf --map my_hall.yaml --robot my_robot.urdf --rviz
"""

up_app = typer.Typer(rich_markup_mode="rich")


def _up(context: typer.Context, **_: Any) -> None:
    """Start a swarm of robots: world, navigators and, if wanted, their mission.

    Exit code: 0 all goals reached without collision, or stopped by you or at
    --duration without a miss or a collision; 1 a goal missed (also by
    --duration, if --until-done is given) or a collision; 2 bad input; 3 a
    component failed; 130 Ctrl-C before the robots drove.
    """
    actions, stated = actions_of(context), stated_of(context)
    spec = RunSpec(**stated)
    if actions.describe is not None:
        add_package_paths([Path(folder) for folder in spec.package_path])
        typer.echo(robot_table(actions.describe))
        raise typer.Exit()
    if actions.print_spec:
        typer.echo(text_of(spec), nl=False)
        raise typer.Exit()
    check_combination(spec.role, spec.robots, spec.connect, spec.bind)
    if spec.role is Role.ROBOTS:
        from swarm_commander.hosts import hosts_command, robots_plan

        plan = robots_plan.robots_plan(spec, stated, given_secret(os.environ))
        raise typer.Exit(hosts_command.bring_up_robots(plan))
    if actions.sweep:
        os.execv(sys.executable, (sys.executable, "-m", SWEEP, *sys.argv[1:]))
    if actions.warm_up is not None:
        raise ConfigError("--warm-up is for --sweep")
    spec.check_host()
    raise typer.Exit(start(spec))


_up.__signature__ = signature()  # type: ignore[attr-defined]
up_app.command("up", epilog=EXAMPLES)(_up)
