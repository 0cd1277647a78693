"""The command `python -m benchmarks`, to which the modules of this folder add theirs."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

Robots = Annotated[int, typer.Option(help="Swarm size.")]
Output = Annotated[
    Path | None, typer.Option("-o", "--output", help="Document in which to replace the part.")
]

benchmarks_app = typer.Typer(add_completion=False, rich_markup_mode=None, no_args_is_help=True)


@benchmarks_app.callback()
def benchmarks() -> None:
    """Measure ourselves against others, and what things cost."""


def load() -> typer.Typer:
    """Return the command with all of its parts."""
    import benchmarks.ablation.command  # each adds its command
    import benchmarks.decisions_command
    import benchmarks.floor_command
    import benchmarks.peers_command
    import benchmarks.results_command
    import benchmarks.scale.command
    import benchmarks.storm.command  # noqa: F401

    return benchmarks_app
