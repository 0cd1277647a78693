"""Results and refusals of the runs in goldens_runs.yaml, as goldens.json keeps them.

`python -m tests.goldens` writes the file anew; do it when a change is meant to change a result.
`python -m tests.goldens NAME ...` prints some of them. Runs are described by command lines and
files, so that the code behind them may be moved and renamed.
"""

import contextlib
import dataclasses
import importlib
import io
import json
import shlex
import shutil
import sys
import tempfile
import tomllib
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import Any
from unittest import mock

import msgspec
import yaml

from swarm_common.model.errors import SwarmError
from swarm_workbench import Swarm, run_scenario
from tests.fakes.charging import waffle_with_battery
from tests.fakes.programs import run_program
from tests.fakes.ros_domains import reserved_domain
from tests.kept_trajectories import libraries
from tests.same_trajectories import ROOT, command

KEPT = Path(__file__).with_suffix(".json")
RUNS: dict[str, dict[str, Any]] = yaml.safe_load(
    Path(__file__).with_name("goldens_runs.yaml").read_text(encoding="utf-8")
)
# What depends on the machine, the time of day or the code's edition: only its keys count.
MASKED = frozenset(
    {
        "wall_time", "real_time_factor", "active_after_wall", "tick_us_median", "tick_us_p99",
        "cpu_ms_per_robot_second", "longest_decision_ms", "p99_decision_ms", "memory_mb",
        "private_mb", "rss_mb", "origin",
    }
)  # fmt: skip
# Put together from status messages on the graph, as these come: not even its keys count.
MASKED_ON_GRAPH = frozenset(
    {
        "wait_time", "hold_time", "worst_wait", "state_shares", "bottleneck", "headline", "lost",
        "longest_stop", "waited_for", "queue", "longest_queue", "queue_time", "orders.robots",
        "orders.floor",
    }
)  # fmt: skip
ABSENT = "(absent)"
COMPILING = "compiling kernels"  # begins a line on stderr, in the first run of a process
LINES, REPORT = Path("golden.jsonl"), Path("golden_run") / "report.json"
BENCH = "swarm-bench {} --json golden.jsonl"
UP = "swarm-up {} --headless --speed max --no-report --run-dir golden_run"


def _mission() -> object:
    with Swarm(2, "hall_12", mission="one_station", seed=3, bench=True) as swarm:
        swarm.run(seconds=15.0)
        return swarm.report


def _goals() -> object:
    with Swarm(world="golden_hall", fleet="golden_fleet.yaml", bench=True) as swarm:
        result = swarm["Srobot1"].go_to("in_1").wait(timeout=60.0)
        return {"robots": swarm.names, "goal": result, "report": swarm.report}


PYTHON: dict[str, Callable[[], object]] = {
    "python: mission": _mission,
    "python: fleet and a goal": _goals,
    "python: run_scenario": lambda: run_scenario("golden_noisy.yaml", robots=2, seed=1),
    "python: refused brain": lambda: Swarm(2, brain="dwa"),
    "python: refused speed": lambda: Swarm(2, bench=True, speed=2.0),
    "python: refused drive": lambda: Swarm(2, drive="hover"),
    "python: refused world": lambda: Swarm(2, "hall_21", bench=True).start(),
    "python: refused size": lambda: Swarm(0, bench=True).start(),
    "python: refused parameter": lambda: Swarm(2, bench=True, parameters={"max_vel": 1}).start(),
    "python: refused scenario": lambda: run_scenario("circel"),
    "python: refused method": lambda: run_scenario("circle", brain="mine"),
}
COMMANDS = {
    **{f"bench: {name}": BENCH.format(words) for name, words in RUNS["bench"].items()},
    **{f"refused: {name}": words for name, words in RUNS["refused"].items()},
}
GRAPH = {f"up: {name}": UP.format(words) for name, words in RUNS["up"].items()}
LONG_GRAPH = {f"up: {name}": UP.format(words) for name, words in RUNS["long up"].items()}
NAMES = [*COMMANDS, *PYTHON, *GRAPH, *LONG_GRAPH]


def write_files(folder: Path) -> None:
    """Write what runs are made from."""
    for name, content in RUNS["files"].items():
        text = content if isinstance(content, str) else yaml.safe_dump(content)
        (folder / name).write_text(text, encoding="utf-8")
    waffle_with_battery(folder)
    code, errors = _call(shlex.split("swarm-map new golden_hall.yaml"))
    assert code == 0, errors


def _call(words: list[str]) -> tuple[int, str]:
    """Run a command in this process; return its exit code and what it says on stderr."""
    with (ROOT / "pyproject.toml").open("rb") as file:
        module, function = tomllib.load(file)["project"]["scripts"][words[0]].split(":")
    main, errors, code = getattr(importlib.import_module(module), function), io.StringIO(), 0
    with contextlib.redirect_stdout(io.StringIO()), contextlib.redirect_stderr(errors):
        with mock.patch.object(sys, "argv", words):
            try:
                main()
            except SystemExit as end:
                code = end.code if isinstance(end.code, int) else 1
    return code, errors.getvalue()


def _start(words: list[str]) -> tuple[int, str]:
    with reserved_domain() as domain:
        variables = {"PYTHONPATH": str(ROOT), "ROS_DOMAIN_ID": str(domain)}
        ended = run_program((*command(ROOT, words[0]), *words[1:]), variables)
    return ended.returncode, ended.stderr


def _result(words: list[str], run: Callable[[list[str]], tuple[int, str]]) -> dict[str, object]:
    """Return the exit code of a command, and the results that it left or why there are none."""
    LINES.unlink(missing_ok=True)
    shutil.rmtree(REPORT.parent, ignore_errors=True)
    code, errors = run(words)
    if LINES.is_file():
        results = [json.loads(line) for line in LINES.read_text("utf-8").splitlines()]
        return {"exit_code": code, "results": results}
    if REPORT.is_file():
        return {"exit_code": code, "report": json.loads(REPORT.read_text("utf-8"))}
    lines = [line for line in errors.splitlines() if not line.startswith(COMPILING)]
    return {"exit_code": code, "stderr": lines}


def golden(name: str, folder: Path) -> Any:
    """Return what comes of one of `NAMES` in a folder of runs, masked."""
    found: object
    with contextlib.chdir(folder):
        if name in PYTHON:
            try:
                found = PYTHON[name]()
            except SwarmError as error:
                found = {"error": type(error).__name__, "message": str(error)}
        elif name in COMMANDS:
            found = _result(shlex.split(COMMANDS[name]), _call)
        else:
            found = _result(shlex.split((GRAPH | LONG_GRAPH)[name]), _start)
    value = masked(found, on_graph=name.startswith("up: "))
    text = json.dumps(value).replace(str(folder), "FOLDER").replace(str(ROOT), "ROOT")
    return json.loads(text)


def masked(value: Any, path: str = "", *, on_graph: bool = False, is_masked: bool = False) -> Any:
    """Return a result fit for JSON, with * for what is not compared."""
    *_, parent, name = ("", "", *path.split("."))
    if on_graph and not MASKED_ON_GRAPH.isdisjoint({name, f"{parent}.{name}"}):
        return "*"
    if isinstance(value, msgspec.Struct):
        value = msgspec.structs.asdict(value)
    if dataclasses.is_dataclass(value) and not isinstance(value, type):
        value = {field.name: getattr(value, field.name) for field in dataclasses.fields(value)}
    kind = {"on_graph": on_graph, "is_masked": is_masked or name in MASKED}
    if isinstance(value, Mapping):
        return {str(key): masked(item, f"{path}.{key}", **kind) for key, item in value.items()}
    if isinstance(value, (list, tuple)):
        return [masked(item, path, **kind) for item in value]
    return "*" if kind["is_masked"] else value


def differences(old: Any, new: Any, path: str = "") -> Iterator[str]:
    """Yield a line `path: old → new` for each value in which two results differ."""
    if isinstance(old, dict) and isinstance(new, dict):
        for key in dict.fromkeys([*old, *new]):
            yield from differences(old.get(key, ABSENT), new.get(key, ABSENT), f"{path}.{key}")
    elif isinstance(old, list) and isinstance(new, list) and len(old) == len(new):
        for number, (before, after) in enumerate(zip(old, new, strict=True)):
            yield from differences(before, after, f"{path}[{number}]")
    elif json.dumps(old) != json.dumps(new):  # as texts, so that NaN is NaN
        yield f"{path.lstrip('.')}: {json.dumps(old)} → {json.dumps(new)}"


@contextlib.contextmanager
def folder_of_runs() -> Iterator[Path]:
    with tempfile.TemporaryDirectory(prefix="goldens-") as name:
        with contextlib.chdir(name):
            write_files(Path(name))
        yield Path(name)


def main() -> None:
    """Write the file, or print the goldens that are named."""
    with folder_of_runs() as folder:
        names = sys.argv[1:]
        found = {name: golden(name, folder) for name in names or NAMES}
    if names:
        sys.stdout.write(json.dumps(found, indent=1, ensure_ascii=False) + "\n")
        return
    kept = {"libraries": libraries(), "goldens": found}
    KEPT.write_text(json.dumps(kept, indent=1, ensure_ascii=False) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
