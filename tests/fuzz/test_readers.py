"""Every element of a file counts: one key renamed, moved or doubled changes result or message."""

import copy
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
import yaml

from swarm_bench.runs.scenario import load_scenario
from swarm_common.files.map_io import load_map
from swarm_common.files.params_io import default_parameters
from swarm_common.files.sites_io import load_sites
from swarm_common.model.errors import SwarmError
from swarm_describe.robots.fleet import load_fleet
from swarm_describe.robots.loading import account_of
from swarm_describe.robots.source import find_robot
from swarm_describe.worlds.actors import load_actors
from swarm_map.floor_plan import load_plan
from swarm_mission.mission import load_mission
from swarm_run.params import load_overrides

ROBOTS = ["Srobot1", "Srobot2"]
AREA = {"x_min": 1, "y_min": 1, "x_max": 4, "y_max": 4, "pitch": 1.2, "yaw": 0.5}
SITES: dict[str, Any] = {
    "stations": {"a": [1, 2, 0.5], "01": [2, 3, 0]},
    "circuits": {"ring": [[0, 0], [1, 0], [1, 1]]},
    "spawn": AREA,
    "spawns": {"ring": {"x": 0, "y": 1, "radius": 2}, "two": [AREA, AREA | {"x_max": 5}]},
    "places": [[1, 1, 0]],
}
BLOCK = {"name": "crate", "at": [1, 2, 0.5], "size": [1, 1, 1], "z": 0.1, "mass": 3, "repeat":
         [[2, 3, 0]], "friction": 0.7, "color": [0, 0, 1]}  # fmt: skip
MAP: dict[str, Any] = {
    "image": "m.pgm", "resolution": 0.1, "origin": [1, 2, 0], "mode": "scale", "negate": 1,
    "occupied_thresh": 0.7, "free_thresh": 0.2,
}  # fmt: skip
PARAMS: dict[str, Any] = {
    "/**": {"ros__parameters": {"max_vel_x": 0.2, "holding": {"mode": "park"}}},
    "Srobot1": {"navigator": {"ros__parameters": {"max_vel_x": 0.1, "vx_samples": 9}}},
    "/world": {"ros__parameters": {"radio": {"loss": 0.1}, "broken": {"Srobot2": [1, 1, 0]}}},
}
MISSION: dict[str, Any] = {
    "retries": 5, "spawn": "ring", "start_spread": 2.0,
    "route": [
        {"stations": ["a", "01"], "take": 1, "order": "random", "pause": 1.0},
        {"pose": [1, 2, 0]}, {"roam": 3, "distance": 2.0}, {"swap": "opposite"}, {"home": True},
    ],
}  # fmt: skip
FLEET: dict[str, Any] = {
    "order": "mixed",
    "groups": [
        {"model": "turtlebot3_burger", "count": 2, "limits": {"max_vel_x": 0.1}, "start": "ring"},
        {"model": "turtlebot3_waffle", "count": 1, "mission": "tour", "start": AREA},
    ],
}
SCENARIO: dict[str, Any] = {
    "world": "crossing", "mission": "m", "robots": [3, 5], "fleet": ["a", "b"], "loss": 0.1,
    "seeds": {"5": 3}, "time_limit": {"5": 60}, "targets": {"5": {"release": 9, "stretch": 8}},
    "dead": [[1, 1, 0]], "with_lidar": True,
}  # fmt: skip
WALKER = {"name": "no", "path": [[0, 0], [1, 0]], "speed": 0.5, "start": 0.1}
ACTORS: dict[str, Any] = {
    "walkers": [WALKER], "forklifts": [WALKER | {"name": "f", "length": 3, "turn_speed": 0.5}],
}  # fmt: skip


PLAN: dict[str, Any] = {
    **{"name": "hall", "wall_thickness": 0.2, "wall_height": 2, "wall_color": [0.1, 0.2, 0.3]},
    **SITES,
    "walls": [{"name": "w", "points": [[0, 0], [9, 0], [9, 9]], "closed": True, "thickness": 0.3}],
    "boxes": [BLOCK],
    "posts": [{"name": "p", "at": [7, 5], "radius": 0.2, "height": 1.0, "color": [0, 1, 0]}],
}
ROBOT = yaml.safe_load(find_robot("turtlebot3_waffle").settings.read_text(encoding="utf-8"))


def account(path):
    found = account_of(path.rename(path.with_name("robot.yaml")))
    return found.rows, found.missing, found.notes


def parameters(path):
    overrides = load_overrides(path, ROBOTS, default_parameters())
    return [overrides.for_robot(robot) for robot in ROBOTS], overrides.world


def grid(path):
    path.with_name("m.pgm").write_bytes(b"P5 3 1 255\n" + bytes([0, 120, 254]))
    found = load_map(path)
    return found.cells.tolist(), found.resolution, found.origin_x, found.origin_y, found.origin_yaw


READERS: dict[str, tuple[dict[str, Any], Callable[[Path], Any]]] = {
    "sites": (SITES, load_sites),
    "plan": (PLAN, load_plan),
    "robot": (ROBOT, account),
    "map": (MAP, grid),
    "params": (PARAMS, parameters),
    "mission": (MISSION, lambda path: load_mission(str(path))),
    "fleet": (FLEET, load_fleet),
    "scenario": (SCENARIO, lambda path: load_scenario(str(path))),
    "actors": (ACTORS, load_actors),
}  # fmt: skip


def mappings(tree, where=()):
    """Yield the place of every mapping in a document, the document itself first."""
    if isinstance(tree, dict):
        yield where
    items = tree.items() if isinstance(tree, dict) else enumerate(tree)
    for key, value in items:
        if isinstance(value, dict | list):
            yield from mappings(value, (*where, key))


def at(tree, where):
    for key in where:
        tree = tree[key]
    return tree


class Dumper(yaml.SafeDumper):
    """Writes what occurs twice twice."""

    def ignore_aliases(self, _):
        return True


def dumped(tree):
    return str(yaml.dump(tree, Dumper=Dumper, sort_keys=False))


def changes(tree):
    """Yield a name and a text of every document with one key renamed, moved up or doubled."""
    for where in mappings(tree):
        for key in at(tree, where):
            label = ".".join(map(str, (*where, key)))
            renamed = copy.deepcopy(tree)
            parent = at(renamed, where)
            at_key = {(f"{k}x" if k == key else k): v for k, v in parent.items()}
            parent.clear()
            parent.update(at_key)
            yield f"{label} renamed", dumped(renamed)
            doubled = copy.deepcopy(tree)
            at(doubled, where)["DOUBLE"] = at(doubled, (*where, key))
            text = dumped(doubled)
            written = yaml.safe_dump({key: 0}).partition(":")[0]
            yield f"{label} doubled", text.replace("DOUBLE:", f"{written}:")
            if where and isinstance(where[-1], str):
                moved = copy.deepcopy(tree)
                above = at(moved, where[:-1])
                if isinstance(above, dict) and key not in above:
                    above[key] = at(moved, where).pop(key)
                    yield f"{label} moved up", dumped(moved)


def outcome(read, path, text):
    path.write_text(text, encoding="utf-8")
    try:
        return repr(read(path))
    except SwarmError as error:
        return f"{type(error).__name__}: {error}"


@pytest.mark.parametrize("kind", READERS)
def test_no_element_is_dropped_without_a_word(tmp_path, kind):
    tree, read = READERS[kind]
    path = tmp_path / "mine.yaml"
    usual = outcome(read, path, dumped(tree))
    assert not re.match(r"\w+Error: ", usual), usual
    silent = [name for name, text in changes(tree) if outcome(read, path, text) == usual]
    assert silent == []
