"""Two sweeps of `python -m benchmarks scale` side by side: two files, or two commits."""

from __future__ import annotations

import contextlib
import dataclasses
import subprocess
import tempfile
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

from rich.console import Console
from rich.markup import escape
from rich.table import Table

from benchmarks.scale.plan import ScaleJob
from benchmarks.scale.result import ScaleResult, read_scale_results
from benchmarks.scale.row import ScaleRow, rows_of
from benchmarks.scale.sweep import run_jobs, scale_line
from swarm_bench.suite.table import number
from swarm_common.model.errors import ConfigError

FIGURES: dict[str, Callable[[ScaleRow], float | None]] = {
    "real-time factor": lambda row: row.factor,
    "CPU [ms]": lambda row: row.cpu_total,
    "world": lambda row: row.cpu("world"),
    "navigators": lambda row: row.cpu("navigators"),
    "other": lambda row: row.cpu("other"),
    "DDS threads": lambda row: row.cpu("dds"),
    "start-up [s]": lambda row: row.median(lambda run: run.start_up),
    "memory [MB]": lambda row: row.memory("total"),
}
REPOSITORY = Path(__file__).resolve().parents[2]


@dataclass(frozen=True, slots=True)
class Side:
    """Side of a comparison: a file or a commit, with its results."""

    name: str  # a file or a commit
    results: Sequence[ScaleResult]  # of its runs


def compare(
    names: tuple[str, str], jobs: Sequence[ScaleJob], console: Console
) -> tuple[Side, Side]:
    """Return two sides: result files as they are, or commits that are run now, in turn."""
    first, second = names
    if all(Path(name).is_file() for name in names):
        one, other = (Side(name, read_scale_results(Path(name))) for name in names)
        return one, other
    with contextlib.ExitStack() as stack:
        folders = [stack.enter_context(_worktree(name)) for name in names]
        sides: list[list[ScaleResult]] = [[], []]
        for job in jobs:  # in turn, so that both meet the same disturbances
            for side, folder in zip(sides, folders, strict=True):
                side += run_jobs([dataclasses.replace(job, code=folder)])
                console.print(scale_line(side[-1]), highlight=False, soft_wrap=True, markup=False)
    return Side(first, sides[0]), Side(second, sides[1])


def comparison_table(first: Side, second: Side) -> Table:
    """Return each figure of both sides and their ratio, second to first, of runs both have."""
    table = Table(box=None, header_style="bold")
    for name in ("system", "workload", "robots", "figure", first.name, second.name, "ratio"):
        table.add_column(
            escape(name), justify="left" if name in ("system", "workload") else "right"
        )
    others = {row.first.kind: row for row in rows_of(second.results)}
    for row in rows_of(first.results):
        other = others.get(row.first.kind)
        if other is None:
            continue
        for name, figure in FIGURES.items():
            before, after = figure(row), figure(other)
            if before is None or after is None:
                continue
            ratio = after / before if before else None
            table.add_row(
                row.first.system, row.label, str(row.first.robots), escape(name),
                number(before, 2), number(after, 2), number(ratio, 2),
            )  # fmt: skip
    return table


@contextlib.contextmanager
def _worktree(commit: str) -> Iterator[Path]:
    """Yield a folder with the code of a commit."""
    with tempfile.TemporaryDirectory(prefix="swarm-commit-") as name:
        folder = Path(name) / "code"
        git = ("git", "-C", str(REPOSITORY), "worktree")
        made = subprocess.run(
            (*git, "add", "--detach", str(folder), commit), capture_output=True, text=True
        )
        if made.returncode:
            raise ConfigError(
                f"--compare: '{commit}' is neither a file nor a commit of this repository: "
                f"{made.stderr.strip()}"
            )
        try:
            yield folder
        finally:
            subprocess.run((*git, "remove", "--force", str(folder)), capture_output=True)
