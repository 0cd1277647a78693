"""The command `python -m benchmarks`, to which the modules of this folder add theirs."""

from __future__ import annotations

from typing import Annotated

import typer

Robots = Annotated[int, typer.Option(help="Swarm size.")]

benchmarks_app = typer.Typer(add_completion=False, rich_markup_mode=None, no_args_is_help=True)


@benchmarks_app.callback()
def benchmarks() -> None:
    """Measure ourselves: results, reliability, and what things cost."""
