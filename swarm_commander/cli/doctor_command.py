"""The command `swarm-doctor`: looks at the machine before a large run."""

from __future__ import annotations

from typing import Annotated

import typer
from rich.console import Console
from rich.table import Table
from rich.text import Text

from swarm_commander.cli.doctor import Finding, Level, examine, look
from swarm_common.model.errors import ConfigError
from swarm_run.domain import domain_id

STYLES = {Level.GOOD: "green", Level.WARNING: "yellow", Level.ERROR: "bold red"}
MOST_ROBOTS = 1000
UNFIT = 1

doctor_app = typer.Typer(rich_markup_mode="rich")


@doctor_app.command(epilog="Example: swarm-doctor --swarm-size 100 --pack 10")
def doctor(
    swarm_size: Annotated[int, typer.Option(help="Number of robots to check for.")] = 100,
    pack: Annotated[int, typer.Option(help="Navigators per process.")] = 1,
) -> None:
    """Check whether this machine is fit for a swarm, and say what to change.

    Exit code: 0 fit (perhaps with warnings), 1 something is in the way, 2 bad input.
    """
    if not 1 <= swarm_size <= MOST_ROBOTS:
        raise ConfigError(f"--swarm-size is {swarm_size}; expected 1 to {MOST_ROBOTS}")
    if pack < 1:
        raise ConfigError(f"--pack is {pack}; it must be 1 or more")
    findings = examine(look(), swarm_size, domain_id(), pack)
    console = Console(markup=False)  # brackets in a name are none
    console.print(_table(findings, swarm_size))
    if any(finding.level is Level.ERROR for finding in findings):
        raise typer.Exit(UNFIT)


def _table(findings: list[Finding], swarm_size: int) -> Table:
    table = Table(title=f"This machine and {swarm_size} robots", title_justify="left")
    for column in ("", "what", "found", "to do"):
        table.add_column(column, overflow="fold")
    for finding in findings:
        level = Text(finding.level.value, style=STYLES[finding.level])
        table.add_row(level, finding.subject, finding.found, finding.advice)
    return table
