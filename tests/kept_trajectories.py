"""Short seeded runs and the hashes that they are known by, in kept_trajectories.json.

`python -m tests.kept_trajectories` writes the file anew; do it when a change is meant to move
robots otherwise. `python -m tests.kept_trajectories NAME ...` prints the hashes of some runs.
"""

import dataclasses
import json
import platform
import sys
from importlib.metadata import version
from pathlib import Path

from swarm_bench.execution.cluster import NUMERICAL
from swarm_bench.runs.episode import RunOptions
from swarm_bench.runs.harness import run
from swarm_bench.runs.scenario import load_scenario

KEPT = Path(__file__).with_suffix(".json")
SECONDS = 40.0  # of simulated time


def _options(
    scenario: str, robots: int, *, engine: str = "planar", realistic: bool = False
) -> RunOptions:
    full = load_scenario(scenario)
    with_lidar = full.with_lidar or realistic
    short = dataclasses.replace(full, time_limit={robots: SECONDS}, with_lidar=with_lidar)
    return RunOptions(scenario=short, robots=robots, seed=1, engine=engine, realistic=realistic)


RUNS = {
    "circle": _options("circle", 8),
    "radio": _options("radio", 20),
    "walkers": _options("walkers", 8),
    "mixed fleet": _options("mixed_fleet", 12),
    "corridor, realistic": _options("corridor", 20, realistic=True),
    "pillars, realistic": _options("pillars", 20, realistic=True),
    "walkers, realistic, rigid bodies": _options("walkers", 4, engine="bullet", realistic=True),
}


def trajectory(name: str) -> str:
    return run(RUNS[name]).trajectory_sha256


def libraries() -> dict[str, str]:
    here = {name: version(name) for name in NUMERICAL}
    return here | {"libc": " ".join(platform.libc_ver()), "machine": platform.machine()}


def main() -> None:
    if names := sys.argv[1:]:
        sys.stdout.write(json.dumps({name: trajectory(name) for name in names}))
        return
    kept = {"libraries": libraries(), "runs": {name: trajectory(name) for name in RUNS}}
    KEPT.write_text(json.dumps(kept, indent=2) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
