"""The command `swarm-report`: draws the report of a run again, or compares several runs."""

from __future__ import annotations

from functools import partial
from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console
from rich.table import Table

from swarm_common.files.resources import run_folders
from swarm_common.middleware.addresses import check_port
from swarm_common.model.errors import ConfigError
from swarm_report.compare import comparison, sentences, what_differs, write_comparison
from swarm_report.document import write_document
from swarm_report.inputs import differences
from swarm_report.run import RunData

PORT = 8090
COMPARISON = "comparison.html"

EXAMPLES = """Examples:

swarm-report

swarm-report runs/8_robots runs/16_robots -o comparison.html

swarm-report --serve runs
"""
_several = partial(typer.Option, rich_help_panel="Several runs")

report_app = typer.Typer(rich_markup_mode="rich")


@report_app.command(epilog=EXAMPLES)
def report(
    runs: Annotated[
        list[Path] | None,
        typer.Argument(
            metavar="RUN",
            autocompletion=run_folders,
            help="Folders of runs.",
            show_default="runs/latest",
        ),
    ] = None,
    output: Annotated[
        Path | None,
        _several(
            "--output", "-o", help="Page that compares several runs.", show_default=COMPARISON
        ),
    ] = None,
    serve: Annotated[
        Path | None,
        _several(
            help="Folder of runs to list in the browser, with search, reports and comparisons.",
            show_default=False,
        ),
    ] = None,
    port: Annotated[int, _several(help="With --serve: TCP port on 127.0.0.1.")] = PORT,
) -> None:
    """Draw report.html of a run again, compare several runs, or list all runs in the browser.

    One RUN: its report.html and plots/ are written, also for a run that was killed.
    Several: a table is printed, and the page of --output is written with its plots beside it.
    With --serve runs/: a list of the runs there is served on this machine until Ctrl-C.
    """
    console = Console(markup=False)  # brackets in a name are none
    if serve is not None:
        if runs:
            raise ConfigError("--serve takes one folder of runs and no RUN beside it")
        _serve(serve, port)
        return
    folders = runs or [Path("runs/latest")]
    if len(folders) == 1:
        if output is not None:
            raise ConfigError(
                f"--output is for the page that compares several runs, and {folders[0]} is one: "
                f"name another run, or leave --output out; its page is {folders[0]}/report.html"
            )
        console.print(f"report: {write_document(folders[0])}", highlight=False, soft_wrap=True)
        return
    data = [RunData(folder) for folder in folders]
    for sentence in sentences(data):
        console.print(sentence, highlight=False, soft_wrap=True)
    found = comparison(data)
    unequal, _ = differences(data)
    table = Table()
    for index, name in enumerate(found.head):
        table.add_column(name, justify="left" if index == 0 else "right", overflow="fold")
    for line in found.rows:
        table.add_row(*line)
    table.add_section()
    for line in unequal:
        table.add_row(*line)
    console.print(table)
    console.print(f"input: {what_differs(data)}", highlight=False, soft_wrap=True)
    page = output or Path(COMPARISON)
    write_comparison(data, page)
    console.print(f"comparison: {page}", highlight=False, soft_wrap=True)


def _serve(runs: Path, port: int) -> None:
    check_port(port)
    from swarm_report.serve import ReportServer

    with ReportServer(runs, port) as server:
        typer.echo(f"reports: {server.link}")
        server.serve_forever()
