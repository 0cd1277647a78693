"""The command `swarm-up`."""

from __future__ import annotations

import os
import sys
import textwrap
from pathlib import Path
from typing import Any

import typer

from swarm_commander.cli.session import start
from swarm_common.middleware.secret import given_secret
from swarm_common.model.errors import ConfigError
from swarm_describe.files.packages import add_package_paths
from swarm_run.flags import actions_of, signature, stated_of, text_of
from swarm_run.host_options import Role, check_combination
from swarm_run.spec import RunSpec

WIDTH = 100  # characters of a line
UNITS = {
    "wheel_radius": "m", "wheel_separation": "m", "wheel_base": "m", "height": "m",
    "footprint": "m", "max_vel_x": "m/s", "max_vel_y": "m/s", "max_vel_theta": "rad/s",
    "acc_lim_x": "m/s²", "acc_lim_y": "m/s²", "acc_lim_theta": "rad/s²", "lidar.x": "m",
    "lidar.y": "m", "lidar.z": "m", "lidar.yaw": "rad", "lidar.angle_min": "rad",
    "lidar.angle_increment": "rad", "lidar.range_min": "m", "lidar.range_max": "m",
    "lidar.rate": "Hz", "lidar.sigma": "m",
}  # fmt: skip
SWEEP = "swarm_bench.capacity.on_graph"  # runs this command for each value
EXAMPLES = """Examples:

swarm-up --viewer

swarm-up --swarm-size 20 --mission loading_route --until-done

swarm-up --world warehouse --swarm-size 30 --mission warehouse_orders --viewer --speed 5

swarm-up --world my_hall.sdf --map my_hall.yaml --robot my_robot.urdf --rviz
"""

up_app = typer.Typer(rich_markup_mode="rich")


def robot_table(name_or_path: str) -> str:
    """Return a line for each value of a robot model; below, what is missing and what was assumed.

    Raises:
        SwarmError: If there is no such model, or something of it is unusable.
    """
    from swarm_describe.robots.loading import account_of  # slow to import

    account = account_of(name_or_path)
    rows = [
        (name, f"{_shown(value)} {UNITS.get(name, '')}".strip(), source)
        for name, value, source in account.rows
    ]
    rows += [(name, "missing", f"{why}; write it into robot.yaml") for name, why in account.missing]
    wide = max(len(name) for name, _, _ in rows)
    values = max((len(value) for _, value, _ in rows if len(value) <= WIDTH // 3), default=0)
    lines = [account.where]
    for name, value, source in rows:
        start = f"  {name:<{wide}}  {value:<{values}}  "
        lines.append(f"{start}{source}")
    for note in account.notes:
        lines += textwrap.wrap(note, WIDTH, initial_indent="  note: ", subsequent_indent="    ")
    return "\n".join(lines)


def _shown(value: Any) -> str:
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, int | float):
        return f"{value:.5g}"
    if isinstance(value, dict):
        return "; ".join(f"{key}: {_shown(item)}" for key, item in value.items())
    if isinstance(value, list | tuple):
        if value and isinstance(value[0], list | tuple):
            return " ".join(f"({', '.join(map(_shown, item))})" for item in value)
        return ", ".join(map(_shown, value)) or "none"
    return str(value)


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
