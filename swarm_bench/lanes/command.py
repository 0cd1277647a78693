"""The command `swarm-bench lanes`: its options."""

from __future__ import annotations

import tempfile
from dataclasses import replace
from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console
from rich.markup import escape

from swarm_bench.execution.executor import executor
from swarm_bench.lanes.training import Candidate, Gain, Training
from swarm_bench.runs.episode import RunOptions, parse_parameters
from swarm_bench.runs.scenario import Scenario
from swarm_bench.suite.command import Jobs, Settings, bench_app, keeping
from swarm_bench.suite.selection import check_jobs, parse_seeds
from swarm_bench.tables import BenchTable
from swarm_common.files.map_io import save_mask
from swarm_common.files.zones_io import LEARNED
from swarm_common.model.errors import ConfigError
from swarm_run.lanes import made_for

LANES_FILE = "lanes.yaml"
NO_GAIN = 1
EXAMPLES = """Example:

swarm-bench lanes --world warehouse --mission warehouse_orders --robots 50 --jobs 2
"""


@bench_app.command(epilog=EXAMPLES)
def lanes(
    world: Annotated[str, typer.Option(help="Name or path of the world.")],
    mission: Annotated[
        list[str],
        typer.Option(help="Name or path of a mission; it goes on for ever. May be given again."),
    ],
    robots: Annotated[int, typer.Option(help="Swarm size.", min=1)],
    robot: Annotated[str, typer.Option(help="Model of the robots.")] = "turtlebot3_waffle",
    seeds: Annotated[str, typer.Option(help="Training seeds like 0-3.")] = "0-3",
    held_out: Annotated[
        str, typer.Option(help="Seeds on which the lanes are compared with none.")
    ] = "100-119",
    rounds: Annotated[int, typer.Option(help="Rounds of learning.", min=1)] = 2,
    duration: Annotated[float, typer.Option(help="Simulated time of a run [s].", min=1.0)] = 720.0,
    warm_up: Annotated[float, typer.Option(help="Time that does not count [s].")] = 120.0,
    set_: Settings = None,
    jobs: Jobs = 1,
    output: Annotated[
        Path | None,
        keeping("-o", "--output", help="Mask to write.", show_default=f"{LANES_FILE} here"),
    ] = None,
) -> None:
    """Learn preferred lanes of a world from where robots lose time, as a filter mask of Nav2.

    Name the mask in the world's sites.yaml (zones: {lanes: lanes.yaml}), or give it to swarm-up by
    --lanes.

    Exit code: 0 written; 1 if it gains nothing on the held-out seeds, and nothing is written; 2 bad
    input.
    """
    console = Console(highlight=False)
    training_seeds, others = parse_seeds(seeds) or (), parse_seeds(held_out) or ()
    if not training_seeds:
        raise ConfigError("--seeds names none; expected seeds to learn from, like 0-3")
    if not all(mission):
        raise ConfigError("--mission names none; robots that stand lose no time")
    if both := sorted(set(training_seeds) & set(others)):
        raise ConfigError(f"--held-out: seed {both[0]} is one of --seeds; expected others")
    if len(others) < 2:
        raise ConfigError("--held-out: an interval needs 2 seeds or more")
    check_jobs(jobs, ros=False, method="ours")
    scenario = Scenario(
        name=Path(world).stem, world=world, robots=(robots,), robot=robot, duration=duration,
        warm_up=warm_up,
    )  # fmt: skip
    plain = RunOptions(scenario=scenario, robots=robots, parameters=parse_parameters(set_ or []))
    options = [
        replace(plain, scenario=replace(scenario, mission=each)) for each in dict.fromkeys(mission)
    ]
    path = output or Path(LANES_FILE)
    if path.suffix not in (".yaml", ".yml"):
        raise ConfigError(f"--output is {path}; expected a map file of Nav2, like {LANES_FILE}")
    if not path.absolute().parent.is_dir():
        raise ConfigError(f"--output: there is no folder {path.absolute().parent}")

    def tell(tried: Candidate) -> None:
        number = len(training.rounds)
        what = "without lanes" if number == 1 else f"round {number - 1}"
        gain = 100.0 * (tried.gain_on(training.rounds[0]) - 1.0)
        console.print(f"{what}: {gain:+.1f} % on {sum(map(len, tried.throughput.values()))} runs")

    with executor(jobs) as chosen, tempfile.TemporaryDirectory() as folder:
        training = Training(options, chosen, Path(folder))
        found = training.train(training_seeds, rounds, tell)
        if not found.cells.any():
            console.print("no lanes are better than none on the training seeds")
            raise typer.Exit(NO_GAIN)
        trial = Path(folder) / LANES_FILE
        learned = made_for(training.setup.scene.file, training.missions, robots)
        save_mask(found, trial, **{LEARNED: learned})
        gain = training.compare(trial, others)
        console.print(_table(gain).rich())
        for name in gain.without:
            console.print(escape(_verdict(name, gain)))
        console.print(f"{gain.contacts} contacts with lanes")
        means = [gain.of(name).mean for name in gain.without]
        if not any(mean.low > 0.0 for mean in means):
            console.print("the lanes gain nothing for certain; nothing is written")
            raise typer.Exit(NO_GAIN)
        if any(mean.high < 0.0 for mean in means):
            console.print("the lanes cost one of the missions for certain; nothing is written")
            raise typer.Exit(NO_GAIN)
        save_mask(found, path, **{LEARNED: learned})
    console.print(f"written: {escape(str(path))}; try it: swarm-up --lanes {escape(str(path))}")


def _table(gain: Gain) -> BenchTable:
    rows = [
        (Path(mission).stem, str(seed), f"{value:.0f}", f"{gain.with_lanes[mission][seed]:.0f}")
        for mission, of_seeds in gain.without.items()
        for seed, value in of_seeds.items()
    ]
    return BenchTable(("mission", "seed", "without lanes [1/h]", "with lanes [1/h]"), rows)


def _verdict(mission: str, gain: Gain) -> str:
    without, found = gain.without[mission].values(), gain.of(mission)
    scale = 100.0 * len(without) / max(1e-9, sum(without))
    ends = f"[{scale * found.mean.low:+.1f}, {scale * found.mean.high:+.1f}]"
    return (
        f"{Path(mission).stem}, {len(without)} held-out seeds: {scale * found.mean.estimate:+.1f}"
        f" {ends} %, {found.mean.text()}/h; p = {found.p:.4f}"
    )
