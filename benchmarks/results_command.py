"""The command `python -m benchmarks results`: its options."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from benchmarks.app import benchmarks_app
from benchmarks.measured_runs import PARTS, SCALE, measure
from benchmarks.results_page import page, readme_table
from swarm_bench.runs.document import replace_part
from swarm_bench.suite.command import Jobs, new_console
from swarm_common.model.errors import UnknownNameError

ROOT = Path(__file__).resolve().parents[1]
PAGE = ROOT / "docs" / "results.md"


@benchmarks_app.command()
def results(
    measured: Annotated[
        list[str] | None,
        typer.Option("--measure", help=f"Part to run first: {', '.join((*PARTS, SCALE))}."),
    ] = None,
    jobs: Jobs = 1,
) -> None:
    """Write docs/results.md and README's table from benchmarks/results; first run what lacks."""
    for name in measured or ():
        if name not in (*PARTS, SCALE):
            raise UnknownNameError("part", name, (*PARTS, SCALE))
        measure(name, jobs, new_console())
    PAGE.write_text(page(), encoding="utf-8")
    replace_part(ROOT / "README.md", "results", readme_table())
