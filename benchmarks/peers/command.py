"""`python -m benchmarks peers`: environments of others and ours in turns, on one machine."""

from __future__ import annotations

import json
import os
import statistics
import subprocess
import sys
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Annotated

import typer

from benchmarks.app import benchmarks_app
from benchmarks.peers.drivers import DRIVERS
from swarm_bench.suite.command import new_console
from swarm_bench.tables import BenchTable
from swarm_common.model.errors import ConfigError, UnknownNameError

DRIVER = Path(__file__).with_name("drivers.py")
OURS = "ours"


@dataclass(slots=True)
class PeerRow:
    """What one simulator cost."""

    name: str
    version: str = ""
    rates: list[float] = field(default_factory=list)  # robot-steps per CPU-second of each round
    ratios: list[float] = field(default_factory=list)  # of these to ours in the same round


COLUMNS: dict[str, Callable[[PeerRow], str]] = {
    "simulator": lambda row: f"{row.name} {row.version}".strip(),
    "robot-steps per CPU-second": lambda row: f"{statistics.median(row.rates):,.0f}",
    "lowest to highest": lambda row: f"{min(row.rates):,.0f} to {max(row.rates):,.0f}",
    "times ours": lambda row: f"{statistics.median(row.ratios):.3g}",
}


def measure_peers(names: Sequence[str], python: str, rounds: int, seconds: float) -> list[PeerRow]:
    """Measure simulators in turns.

    Args:
        names: Keys of `DRIVERS`; ours is added.
        python: Interpreter in which those of others are installed.
        rounds: How often each is measured.
        seconds: CPU time of a measurement.

    Raises:
        SwarmError: If one is unknown, or does not run.
    """
    for name in names:
        if name not in DRIVERS:
            raise UnknownNameError("simulator", name, DRIVERS)
    rows = [PeerRow(name) for name in dict.fromkeys((OURS, *names))]
    for _ in range(rounds):
        for row in rows:
            rate, row.version = _measured(row.name, python, seconds)
            row.rates.append(rate)
            row.ratios.append(rate / rows[0].rates[-1])
    return rows


def _measured(name: str, python: str, seconds: float) -> tuple[float, str]:
    interpreter = sys.executable if name == OURS else python
    command = [interpreter, str(DRIVER), name, str(seconds)]
    threads = {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}
    root = str(DRIVER.parents[2])
    paths = {"PYTHONPATH": root} if name == OURS else {}
    try:
        done = subprocess.run(
            command, capture_output=True, text=True, env={**os.environ, **threads, **paths}
        )
    except OSError as error:
        raise ConfigError(f"--python is {python}, which does not start: {error}") from None
    if done.returncode:
        last = (done.stderr.strip().splitlines() or ["no word"])[-1]
        raise ConfigError(
            f"{name} does not run with {interpreter}: {last}; install it there, or leave it out"
            " with --simulators"
        )
    found = json.loads(done.stdout.splitlines()[-1])
    return found["rate"], found["version"]


@benchmarks_app.command()
def peers(
    python: Annotated[
        str, typer.Option(help="Interpreter with navground, vmas and ir-sim.")
    ] = sys.executable,
    simulators: Annotated[str, typer.Option(help="Their names.")] = ",".join(DRIVERS),
    rounds: Annotated[int, typer.Option(min=1, help="How often each is measured.")] = 5,
    seconds: Annotated[float, typer.Option(min=0.1, help="CPU time of a measurement.")] = 5.0,
) -> None:
    """Measure environments of others and ours in turns: 20 robots with 360 rays at each step."""
    rows = measure_peers(simulators.split(","), python, rounds, seconds)
    new_console().print(BenchTable.of(COLUMNS, rows).rich())
