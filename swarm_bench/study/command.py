"""`swarm-bench study`: its options."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from pathlib import Path
from typing import Annotated

import typer

from swarm_bench.execution.executor import executor, share_of, values
from swarm_bench.runs.fingerprint import load_inputs
from swarm_bench.runs.json_lines import collected, taken_over
from swarm_bench.study.experiments import load_experiments, runs_of, study_folder
from swarm_bench.study.lines import StudyLine, read_lines
from swarm_bench.study.page import markdown, page
from swarm_bench.study.runner import line_text, run_one
from swarm_bench.suite.command import Cluster, Jobs, Shard, bench_app, keeping, new_console
from swarm_bench.suite.selection import check_jobs
from swarm_common.model.errors import ConfigError

DIFFERS = 1
EXAMPLES = """Example:

swarm-bench study --quick --output study.md
"""


@bench_app.command(epilog=EXAMPLES)
def study(
    quick: Annotated[bool, typer.Option("--quick", help="The short edition: 2 seeds.")] = False,
    check: Annotated[
        bool, typer.Option("--check", help="Run nothing; compare the documents with the lines.")
    ] = False,
    experiments: Annotated[
        Path | None,
        typer.Option(help="Folder of experiments.", show_default="params/study"),
    ] = None,
    folder: Annotated[Path, typer.Option(help="Folder of raw lines and study.html.")] = Path(
        "study"
    ),
    output: Annotated[Path, keeping("-o", "--output", help="Document to write.")] = Path(
        "docs/study.md"
    ),
    most: Annotated[
        int | None,
        typer.Option(help="Runs to add; another call goes on.", show_default="all"),
    ] = None,
    jobs: Jobs = 1,
    cluster: Cluster = None,
    shard: Shard = None,
) -> None:
    """Compare decentralised with central control; what was run before is not repeated.

    Exit code: 0 written, or as written; 1 with --check, if a document differs; 2 bad input.
    """
    check_jobs(jobs, ros=False, method="ours")
    found = load_experiments(experiments or study_folder())
    file = folder / ("quick.jsonl" if quick else "full.jsonl")
    lines = list(read_lines(file)) if file.is_file() else []
    console = new_console()
    if not check:
        folder.mkdir(parents=True, exist_ok=True)
        known = {line.key for line in lines}
        runs = list(runs_of(found, quick=quick))
        todo = [run for run in runs if run.key not in known]
        if len(todo) < len(runs):
            console.print(taken_over(len(runs) - len(todo), len(runs), file), markup=False)
        with executor(jobs, cluster) as chosen:
            share = share_of(todo, shard)[:most]
            new = values(chosen, run_one, share, lambda run: load_inputs(run.options()))
            lines += collected(new, file, console, line_text, StudyLine.as_json)
    if not lines:
        raise ConfigError(f"{file} has no results; run swarm-bench study first")
    command = "swarm-bench study --quick" if quick else "swarm-bench study"
    texts = {
        output: markdown(found, lines, quick=quick, command=command),
        folder / "study.html": page(found, lines),
    }
    if check:
        _compare(texts)
        return
    for path, text in texts.items():
        _write(path, text)


def _counted(lines: Iterable[StudyLine], tell: Callable[[int], None]) -> Iterator[StudyLine]:
    for done, line in enumerate(lines, 1):
        tell(done)
        yield line


def _compare(texts: dict[Path, str]) -> None:
    """Exit with `DIFFERS` if a file is not what the lines say."""
    for path, text in texts.items():
        if not path.is_file() or path.read_text(encoding="utf-8") != text:
            typer.echo(f"{path} differs from the lines; write it with swarm-bench study", err=True)
            raise typer.Exit(DIFFERS)


def _write(path: Path, text: str) -> None:
    try:
        path.write_text(text, encoding="utf-8")
    except OSError as cause:
        raise ConfigError(f"cannot write {path}: {cause}") from cause
