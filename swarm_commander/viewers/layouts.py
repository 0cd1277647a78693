"""Layouts of RViz and Foxglove for a run: the files in `layouts/`, filled in with its robots."""

from __future__ import annotations

import json
from collections.abc import Collection, Mapping, Sequence
from pathlib import Path
from string import Template
from typing import Any

import yaml

from swarm_run.spec import MERGED, SWARM

COLORS = ("#0072B2", "#E69F00", "#009E73", "#D55E00", "#56B4E9", "#CC79A7")  # as in the reports
FEW = 8  # robots whose curves have a legend
EACH, MOST = "each robot", "at most"  # keys of a layout
FOLDER = Path(__file__).with_suffix("")
LOADER = getattr(yaml, "CSafeLoader", yaml.SafeLoader)
DUMPER = getattr(yaml, "CSafeDumper", yaml.SafeDumper)  # the one in C is ten times as fast

Values = Mapping[str, Any]


def write_rviz(
    folder: Path, robots: Sequence[str], newcomers: Collection[str] | None = None
) -> None:
    """Write `NAME.rviz` for each robot, or newcomers only, `swarm.rviz` and `merged.rviz`."""
    for name, layout in layouts("rviz", robots, newcomers).items():
        text = yaml.dump(layout, Dumper=DUMPER, sort_keys=False)
        _write(folder / f"{name}.rviz", text)


def write_foxglove(
    folder: Path, robots: Sequence[str], newcomers: Collection[str] | None = None
) -> None:
    """Write `NAME.json` for each robot, or for newcomers only, and `swarm.json`."""
    for name, layout in layouts("foxglove", robots, newcomers).items():
        _write(folder / f"{name}.json", json.dumps(layout, indent=1) + "\n")


def _write(path: Path, text: str) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(text, encoding="utf-8")


def layouts(
    program: str, robots: Sequence[str], newcomers: Collection[str] | None = None
) -> dict[str, Any]:
    """Return the filled-in layouts of a program, by the name of a robot, `swarm` or `merged`.

    Args:
        program: `rviz` or `foxglove`.
        newcomers: Robots of which one is wanted; None for all.
    """
    text = (FOLDER / f"{program}.yaml").read_text(encoding="utf-8")
    templates = yaml.load(text, Loader=LOADER)
    each = [_values(name, index, len(robots)) for index, name in enumerate(robots)]
    wanted = [one for one in each if newcomers is None or one["robot"] in newcomers]
    whole = [name for name in (SWARM, MERGED) if name in templates]
    found = {one["robot"]: filled(templates["robot"], one, ()) for one in wanted}
    return found | {name: filled(templates[name], each[0], each) for name in whole}


def _values(robot: str, index: int, count: int) -> Values:
    color = COLORS[index % len(COLORS)]
    rgb = "; ".join(str(number) for number in bytes.fromhex(color[1:]))
    return {"robot": robot, "color": color, "rgb": rgb, "few": count <= FEW}


def filled(node: Any, values: Values, each: Sequence[Values]) -> Any:
    """Return a part of a layout with its values.

    Args:
        node: Text with `$robot` and the like; what stands under `each robot` is repeated.
        values: What is put in place of these.
        each: The same for each robot.
    """
    if isinstance(node, str):
        return values["few"] if node == "$few" else Template(node).substitute(values)
    if isinstance(node, list):
        return [one for item in node for one in _repeated(item, values, each)]
    if not isinstance(node, dict):
        return node
    result: dict[str, Any] = {}
    for key, value in node.items():
        if key == EACH:
            for one in each:
                result |= filled(value, one, ())
        else:
            result[filled(key, values, each)] = filled(value, values, each)
    return result


def _repeated(item: Any, values: Values, each: Sequence[Values]) -> list[Any]:
    if not isinstance(item, dict) or EACH not in item:
        return [filled(item, values, each)]
    return [filled(item[EACH], one, ()) for one in each[: item.get(MOST)]]
