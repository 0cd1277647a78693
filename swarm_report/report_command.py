"""The command `swarm-report`: draws the report of a run again, or compares several runs."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console
from rich.table import Table

from swarm_report.compare import comparison, write_comparison
from swarm_report.document import write_document
from swarm_report.run import RunData

report_app = typer.Typer(rich_markup_mode=None)


@report_app.command()
def report(
    runs: Annotated[
        list[Path] | None,
        typer.Argument(metavar="[RUN]...", help="Folders of runs.  [default: runs/latest]"),
    ] = None,
    output: Annotated[
        Path, typer.Option("--output", "-o", help="Page that compares several runs.")
    ] = Path("comparison.html"),
) -> None:
    """Draw report.html of a run again, or compare several runs in a table and a page.

    One RUN: its report.html and plots/ are written, also for a run that was killed.
    Several: a table is printed, and the page of --output is written with its plots beside it.
    """
    console = Console()
    folders = runs or [Path("runs/latest")]
    if len(folders) == 1:
        console.print(f"report: {write_document(folders[0])}", highlight=False, soft_wrap=True)
        return
    data = [RunData(folder) for folder in folders]
    head, rows = comparison(data)
    table = Table()
    for index, name in enumerate(head):
        table.add_column(name, justify="left" if index == 0 else "right", overflow="fold")
    for row in rows:
        table.add_row(*row)
    console.print(table)
    write_comparison(data, output)
    console.print(f"comparison: {output}", highlight=False, soft_wrap=True)
