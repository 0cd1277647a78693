"""Checks that a change of the code changes no trajectory: `python -m tests.same_trajectories BASE`.

Runs a fixed set of seeded runs in a checkout of the commit BASE and in the working tree, and
compares `trajectory_sha256` run by run: every scenario of the bench at its smallest size, with
perfect and with realistic sensors, and three runs on the ROS graph. Both sides are driven by their
command lines only, so that modules may be moved and renamed between them.

Files and results of BASE are kept in a folder by commit; a check that was interrupted goes on where
it was.
Exit code: 0 all equal, 1 some differ, 2 bad input.
"""

import argparse
import json
import os
import subprocess
import sys
import tempfile
import tomllib
from collections.abc import Mapping, Sequence
from pathlib import Path

import yaml

from swarm_bench.suite.selection import parse_seeds

ROOT = Path(__file__).resolve().parents[1]
FOLDER = Path(tempfile.gettempdir()) / "swarm-same-trajectories"
GRAPH_RUNS = {  # by name: what `swarm-up` is given
    "hall_12, station": ("--world", "hall_12", "--mission", "one_station", "--swarm-size", "4"),
    "corridor, AMCL": (
        *("--world", "corridor", "--mission", "change_rooms", "--swarm-size", "4", "--realistic"),
        *("--goals-per-robot", "1"),
    ),
    "slim_blockage, mixed fleet": (
        *("--world", "slim_blockage", "--mission", "loading_route", "--fleet", "fleet.yaml"),
        *("--goals-per-robot", "2"),
    ),
}
FLEET = """
order: mixed
groups:
  - {model: turtlebot3_burger, count: 3}
  - {model: turtlebot3_waffle, count: 2}
"""
Hashes = dict[str, str]


def command(tree: Path, name: str) -> list[str]:
    with (tree / "pyproject.toml").open("rb") as file:
        module, function = tomllib.load(file)["project"]["scripts"][name].split(":")
    return [sys.executable, "-c", f"from {module} import {function} as main; main()"]


def run(tree: Path, words: Sequence[str], folder: Path) -> None:
    """Run a command of a tree in a folder; its exit code says how the robots fared, not whether."""
    variables = {"PYTHONPATH": str(tree), "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST"}
    subprocess.run(words, cwd=folder, env=os.environ | variables, check=False)


def scenarios(tree: Path) -> dict[str, int]:
    found = {}
    for path in sorted((tree / "params" / "scenarios").glob("*.yaml")):
        sizes = yaml.safe_load(path.read_text(encoding="utf-8"))["robots"]
        found[path.stem] = min(sizes)
    return found


def bench_hashes(
    tree: Path, chosen: Mapping[str, int], seeds: str, *, realistic: bool, folder: Path
) -> Hashes:
    """Return the hashes of bench runs by what was run.

    Args:
        tree: Checkout whose code runs.
        chosen: Robots of each scenario.
        seeds: Like 0-2.
        realistic: Whether sensors err and robots localise.
        folder: For the results; runs whose results are there are not repeated.
    """
    kind = "realistic" if realistic else "ideal"
    found: Hashes = {}
    wanted = parse_seeds(seeds) or ()  # those of earlier calls are in the folder, too
    for name, robots in chosen.items():
        lines = folder / f"{name}-{kind}.jsonl"
        flags = ("--scenario", name, "--robots", str(robots), "--seeds", seeds, f"--{kind}")
        words = [*command(tree, "swarm-bench"), "traffic", *flags, "--json", str(lines)]
        run(tree, words, folder)
        for line in lines.read_text(encoding="utf-8").splitlines():
            result = json.loads(line)
            if result["robots"] == robots and result["seed"] in wanted:
                key = f"{name} {robots}, {kind}, seed {result['seed']}"
                found[key] = result["trajectory_sha256"]
    return found


def graph_hashes(tree: Path, folder: Path) -> Hashes:
    """Return the hashes of runs on the ROS graph; what is in the folder is not repeated."""
    found: Hashes = {}
    (folder / "fleet.yaml").write_text(FLEET, encoding="utf-8")
    for number, (name, flags) in enumerate(GRAPH_RUNS.items()):
        run_dir = folder / f"graph-{number}"
        report = run_dir / "report.json"
        if not report.is_file():
            common = ("--until-done", "--headless", "--speed", "max", "--no-report")
            words = [*command(tree, "swarm-up"), *flags, *common, "--run-dir", str(run_dir)]
            run(tree, words, folder)
        if not report.is_file():
            raise SystemExit(f"error: no report of '{name}' in {run_dir}; see above")
        found[f"graph: {name}"] = json.loads(report.read_text("utf-8"))["trajectory_sha256"]
    return found


def hashes(tree: Path, options: argparse.Namespace, chosen: Mapping[str, int], to: Path) -> Hashes:
    """Return all hashes of a tree."""
    to.mkdir(parents=True, exist_ok=True)
    found = bench_hashes(tree, chosen, options.seeds, realistic=False, folder=to)
    if not options.quick:
        found |= bench_hashes(tree, chosen, options.seeds, realistic=True, folder=to)
        found |= graph_hashes(tree, to)
    return found


def checkout(commit: str) -> Path:
    """Return a folder with the files of a commit, made once, so that its kernels compile once."""
    tree = FOLDER / commit / "tree"
    if not tree.is_dir():
        tree.parent.mkdir(parents=True, exist_ok=True)
        part = Path(tempfile.mkdtemp(dir=tree.parent))
        with subprocess.Popen(("git", "archive", commit), cwd=ROOT, stdout=subprocess.PIPE) as out:
            subprocess.run(("tar", "-x", "-C", str(part)), stdin=out.stdout, check=True)
        part.rename(tree)
    return tree


def arguments() -> argparse.Namespace:
    """Return what was asked for; ends with exit code 2 on bad input."""
    parser = argparse.ArgumentParser(prog="python -m tests.same_trajectories")
    parser.add_argument("base", help="commit to compare the working tree with")
    parser.add_argument("--seeds", default="0-2", help="of the bench runs, like 0-2")
    parser.add_argument("--scenarios", default="", help="comma-separated; default: all")
    parser.add_argument("--quick", action="store_true", help="bench runs with perfect sensors only")
    return parser.parse_args()


def main() -> int:
    """Compare the working tree with a commit."""
    options = arguments()
    words = ("git", "rev-parse", "--verify", "--quiet", f"{options.base}^{{commit}}")
    parsed = subprocess.run(words, cwd=ROOT, capture_output=True, text=True, check=False)
    if parsed.returncode:
        sys.stderr.write(f"error: no commit '{options.base}' in this repository\n")
        return 2
    commit = parsed.stdout.strip()
    chosen = scenarios(tree := checkout(commit))
    if options.scenarios:
        chosen = {key: chosen[key] for key in options.scenarios.split(",")}
    before = hashes(tree, options, chosen, FOLDER / commit)
    with tempfile.TemporaryDirectory(prefix="swarm-after-") as name:
        after = hashes(ROOT, options, chosen, Path(name))
    changed = [key for key in before if before[key] != after.get(key)]
    for key in changed:
        sys.stdout.write(f"differs: {key}\n")
    equal = f"{len(before) - len(changed)} of {len(before)}"
    sys.stdout.write(f"{equal} trajectories are equal to those of {commit[:7]}\n")
    return 1 if changed else 0


if __name__ == "__main__":
    sys.exit(main())
