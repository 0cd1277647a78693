"""Inputs of a run as flat names and values, and the differences between several runs."""

from __future__ import annotations

import hashlib
import json
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import yaml

from swarm_report.run import RunData
from swarm_report.run_files import read_json

ABSENT = "not given"
SEED = "seed"
# Of the world's configuration: what is told by other names, or says nothing about the run.
TOLD_OTHERWISE = {"robots", "processes", "verdict_path", "trace_dir", "map", "sites", "world"}
# Of a robot's parameters: its own number and place, and paths.
OWN = ("robot_id", "initial_pose.", "sites", "map", "peers")


def inputs(run: RunData) -> dict[str, str]:
    """Return what the run was given, by name; as much as its folder still says."""
    found = _options(run)
    found |= {f"parameter {name}": value for name, value in _parameters(run).items()}
    return found


def differences(runs: Sequence[RunData]) -> tuple[list[list[str]], int]:
    """Return rows of a name and a value per run where these differ, and how many are equal."""
    given = [inputs(run) for run in runs]
    names = dict.fromkeys(name for one in given for name in one)
    rows = [[name, *(one.get(name, ABSENT) for one in given)] for name in names]
    unequal = [row for row in rows if len(set(row[1:])) > 1]
    return unequal, len(rows) - len(unequal)


def _options(run: RunData) -> dict[str, str]:
    report, config = run.report, run.config
    models = Counter(str(robot.get("model", "?")) for robot in config.get("robots", []))
    places = {name: (pose.x, pose.y, pose.yaw) for name, pose in run.sites.stations.items()}
    found = {
        "world": _short(report.get("world") or config.get("world")),
        "robots": ", ".join(f"{count} {_short(model)}" for model, count in sorted(models.items()))
        or str(len(run.robots)),
        "mission": _short(report.get("mission")),
        SEED: str(report.get("seed", config.get("seed", ABSENT))),
        "map": _map(run),
        "stations": f"{len(places)}, {_digest(places)}",
    }
    found |= {
        name.replace("_", " "): _text(value)
        for name, value in config.items()
        if name not in TOLD_OTHERWISE and name != SEED and not isinstance(value, dict)
    }
    for name, value in config.items():
        if isinstance(value, dict) and name not in TOLD_OTHERWISE:
            found |= {f"{name} {key}": _text(each) for key, each in _flat(value)}
    mission = read_json(run.folder / "config" / "mission.json")
    for key in ("laps", "goals_per_robot"):
        if key in mission:
            found[key.replace("_", " ")] = _text(mission[key])
    if "homes" in mission:
        found["start poses"] = _digest(mission["homes"])
    pack = read_json(run.folder / "config" / "navigators.json").get("pack")
    if pack is not None:
        found["navigators per process"] = str(pack)
    return found


def _map(run: RunData) -> str:
    grid = run.grid
    if grid is None:
        return ABSENT
    height, width = (count * grid.resolution for count in grid.cells.shape)
    return f"{width:.1f} x {height:.1f} m, {_digest(grid.cells.tobytes().hex())}"


def _parameters(run: RunData) -> dict[str, str]:
    """Return the navigators' parameters; where robots differ, each value and for how many."""
    values: dict[str, Counter[str]] = {}
    for path in sorted((run.folder / "params").glob("*.yaml")):
        for name, value in _flat(_node_parameters(path)):
            if not name.startswith(OWN):
                values.setdefault(name, Counter())[_text(value)] += 1
    return {
        name: next(iter(counts))
        if len(counts) == 1
        else ", ".join(f"{value} ({count} robots)" for value, count in counts.most_common())
        for name, counts in values.items()
    }


def _node_parameters(path: Path) -> dict[str, Any]:
    try:
        content = yaml.load(path.read_text(encoding="utf-8"), yaml.CSafeLoader)
    except (OSError, ValueError, yaml.YAMLError):
        return {}
    nodes = content.values() if isinstance(content, dict) else []
    found: dict[str, Any] = {}
    for node in nodes:
        if isinstance(node, dict) and isinstance(node.get("ros__parameters"), dict):
            found |= node["ros__parameters"]
    return found


def _flat(values: Mapping[str, Any], before: str = "") -> Iterator[tuple[str, Any]]:
    for name, value in values.items():
        if isinstance(value, dict):
            yield from _flat(value, f"{before}{name}.")
        else:
            yield f"{before}{name}", value


def _text(value: Any) -> str:
    if value is None or value == "":
        return "none"
    text = value if isinstance(value, str) else json.dumps(value)
    return text if len(text) <= 60 else f"{text[:40]}… ({_digest(text)})"


def _short(value: Any) -> str:
    path = Path(str(value or "none"))
    return path.parent.name if path.name == "world.sdf" else path.name


def _digest(value: Any) -> str:
    text = json.dumps(value, sort_keys=True)
    return f"#{hashlib.sha256(text.encode()).hexdigest()[:6]}"
