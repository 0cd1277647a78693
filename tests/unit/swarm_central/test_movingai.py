"""An external solver by files."""

from __future__ import annotations

import stat
import sys
from pathlib import Path

import numpy as np
import pytest

from swarm_central.lacam import fault_of
from swarm_central.movingai import ExternalSolver, map_text, scenario_text
from swarm_central.roadmap import grid_roadmap
from swarm_common.model.errors import ConfigError

# Reads the files as any solver would, and sends one robot after the other along a row.
SOLVER = """#!{python}
import argparse
parser = argparse.ArgumentParser()
for flag in "miNto":
    parser.add_argument("-" + flag)
given = parser.parse_args()
rows = open(given.m).read().splitlines()[4:]
robots = [line.split("\\t") for line in open(given.i).read().splitlines()[1:]]
assert len(robots) == int(given.N)
at = [[int(r[4]), int(r[5])] for r in robots]
steps = ["0:" + "".join("(%d,%d)," % tuple(p) for p in at)]
for place, robot in zip(at, robots):
    while place[0] != int(robot[6]):
        place[0] += 1 if int(robot[6]) > place[0] else -1
        assert rows[place[1]][place[0]] == "."
        steps.append("%d:" % len(steps) + "".join("(%d,%d)," % tuple(p) for p in at))
open(given.o, "w").write("solved=1\\nsolution=\\n" + "\\n".join(steps) + "\\n")
"""


def program(folder: Path, text: str) -> Path:
    path = folder / "solver"
    path.write_text(text.replace("{python}", sys.executable), encoding="utf-8")
    path.chmod(path.stat().st_mode | stat.S_IXUSR)
    return path


def test_files_are_as_moving_ai_has_them():
    cells = np.array([[0, 0], [1, 0], [1, 1]])
    assert map_text(cells) == "type octile\nheight 2\nwidth 2\nmap\n..\n@.\n"
    start, goals = np.array([0], np.int32), np.array([2], np.int32)
    expected = "version 1\n0\troadmap.map\t2\t2\t0\t0\t1\t1\t0\n"
    assert scenario_text(cells, start, goals) == expected


def test_a_program_plans(tmp_path):
    roadmap = grid_roadmap(np.ones((2, 4), np.bool_))
    solver = ExternalSolver(program(tmp_path, SOLVER), roadmap, 5.0)
    steps = solver.solve(np.array([0, 4], np.int32), np.array([3, 6], np.int32))
    assert steps is not None
    assert steps[-1].tolist() == [3, 6]
    assert fault_of(steps, roadmap.costs.neighbors) == ""


def test_no_result_is_no_plan(tmp_path):
    solver = ExternalSolver(
        program(tmp_path, "#!/bin/sh\nexit 1\n"), grid_roadmap(np.ones((2, 2), np.bool_)), 5.0
    )
    assert solver.solve(np.array([0], np.int32), np.array([1], np.int32)) is None


def test_what_is_wrong_is_said(tmp_path):
    roadmap = grid_roadmap(np.ones((2, 2), np.bool_))
    with pytest.raises(ConfigError, match="there is no such program"):
        ExternalSolver(tmp_path / "none", roadmap, 5.0)
    text = '#!/bin/sh\nfor last; do :; done\necho "0:(9,9)," > $last\n'
    solver = ExternalSolver(program(tmp_path, text), roadmap, 5.0)
    with pytest.raises(ConfigError, match="expected 1 passable cells"):
        solver.solve(np.array([0], np.int32), np.array([1], np.int32))
