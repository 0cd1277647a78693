"""An external solver by files."""

import contextlib
import os
import subprocess
import tempfile
import time
from pathlib import Path

import numpy as np
import psutil
import pytest

from swarm_central import movingai
from swarm_central.movingai import FOLDER, ExternalSolver, SolverError, map_text, scenario_text
from swarm_central.plan_check import first_fault
from swarm_central.roadmap import grid_roadmap
from swarm_common.model.errors import ConfigError
from tests.fakes import solver

PROGRAM = Path(solver.__file__)
# Vertices 0 1 2 3
#          4 5 6 7
ROADMAP = grid_roadmap(np.ones((2, 4), np.bool_))
START, GOALS = np.array([0, 2], np.int32), np.array([3, 0], np.int32)


def solve(monkeypatch, mode, seconds=5.0):
    monkeypatch.setenv("SOLVER_MODE", mode)
    chosen = ExternalSolver(PROGRAM, ROADMAP, seconds)
    return chosen.solve(START, GOALS, names=["id 4", "id 7"])


def test_files_are_as_moving_ai_has_them():
    cells = np.array([[0, 0], [1, 0], [1, 1]])
    assert map_text(cells) == "type octile\nheight 2\nwidth 2\nmap\n..\n@.\n"
    assert map_text(cells[:1], (2, 2)) == "type octile\nheight 2\nwidth 2\nmap\n.@\n@@\n"
    start, goals = np.array([0], np.int32), np.array([2], np.int32)
    expected = "version 1\n0\troadmap.map\t2\t2\t0\t0\t1\t1\t0\n"
    assert scenario_text(cells, start, goals) == expected


def test_a_program_plans(monkeypatch):
    steps = solve(monkeypatch, "right")
    assert steps[0].tolist() == START.tolist()
    assert steps[-1].tolist() == GOALS.tolist()
    assert first_fault(steps, ROADMAP.costs.neighbors, may_rotate=False) is None


@pytest.mark.parametrize(
    ("mode", "told"),
    [
        ("collide", "robot 1 of 2 (id 4) and robot 2 of 2 (id 7) are both at (1,0) in step 1"),
        ("stand", "robot 1 of 2 (id 4) ends at (0,0) in step 0; its goal is (3,0)"),
        ("swap", "robot 1 of 2 (id 4) and robot 2 of 2 (id 7) change places"),
        ("jump", "robot 1 of 2 (id 4) goes from (0,0) to (3,0) in step 1"),
        ("start", "robot 1 of 2 (id 4) begins at (1,0); it is at (0,0)"),
        ("wall", "has robot 1 on no free cell, (0,2), in line 5, '1:(0,2),(2,0),'"),
        ("twice", "wrote 1 robots in line 5, '1:(2,0),'; expected all 2"),
        ("gap", "wrote step 2 in line 5"),
        ("nan", "'8:(1,nan),(1,nan),'; expected T:(x,y),(x,y),... of whole numbers"),
        ("text", "wrote no step in line 12, 'and so on'"),
        ("empty", "wrote a result without a plan for 2 robots"),
        ("unsolved", "found no plan for 2 robots, as line 2 says: solved=0"),
        ("none", "ended without a file for its option -o"),
        ("fail", "gave up with exit code 1: no way\u00a0found"),
        ("crash", "was ended by signal 11"),
    ],
)
def test_no_plan_and_a_wrong_plan_are_told(monkeypatch, mode, told):
    with pytest.raises(SolverError) as caught:
        solve(monkeypatch, mode)
    assert str(caught.value).startswith(f"--central-solver {PROGRAM} ")
    assert told in str(caught.value)
    assert str(caught.value).endswith("; mend the program, or leave it out")


def test_a_program_that_hangs_is_killed_with_its_child(monkeypatch, tmp_path):
    monkeypatch.setattr(movingai, "GRACE", 0.5)
    monkeypatch.setenv("SOLVER_COUNT", str(tmp_path / "child"))
    with pytest.raises(SolverError, match=r"was killed 0\.5 s after its time of 1\.5 s for 2") as e:
        solve(monkeypatch, "hang", seconds=1.5)
    assert "still searching; give it more by --set central.solver_time=4.5" in str(e.value)
    child = int((tmp_path / "child").read_text())
    end = time.monotonic() + 5.0  # a loaded machine takes its time to end what was killed
    while _lives(child) and time.monotonic() < end:
        time.sleep(0.02)
    assert not _lives(child)


def _lives(process):
    with contextlib.suppress(psutil.NoSuchProcess):
        return psutil.Process(process).status() != psutil.STATUS_ZOMBIE
    return False


@pytest.mark.parametrize("mode", ["right", "jump", "fail", "none"])
def test_no_file_is_left(monkeypatch, tmp_path, mode):
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    with contextlib.suppress(SolverError):
        solve(monkeypatch, mode)
    assert list(tmp_path.iterdir()) == []


def test_files_of_a_killed_process_are_removed_by_the_next(monkeypatch, tmp_path):
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    with subprocess.Popen(["true"]) as process:
        process.wait()
    left, used = tmp_path / f"{FOLDER}{process.pid}-a", tmp_path / f"{FOLDER}{os.getpid()}-b"
    left.mkdir()
    used.mkdir()
    (left / "roadmap.map").touch()
    ExternalSolver(PROGRAM, ROADMAP, 1.0)
    assert list(tmp_path.iterdir()) == [used]


def test_robots_that_stay_and_closed_places_are_walls(monkeypatch, tmp_path):
    """Nobody else may stand there, and the program does not move them."""
    roadmap = grid_roadmap(np.ones((2, 4), np.bool_))
    monkeypatch.setenv("SOLVER_MODE", "right")
    start, goals = np.array([1, 0, 7], np.int32), np.array([1, 3, 6], np.int32)
    closed = np.zeros(8, np.bool_)
    stays = np.array([True, False, False])
    steps = ExternalSolver(PROGRAM, roadmap, 5.0).solve(start, goals, stays=stays, closed=closed)
    assert (steps[:, 0] == 1).all()
    assert steps[-1].tolist() == [1, 3, 6]
    closed[4] = True  # the only other way
    with pytest.raises(SolverError, match=r"robot 1 of 2 ends at \(0,0\)"):
        ExternalSolver(PROGRAM, roadmap, 5.0).solve(start, goals, stays=stays, closed=closed)


def test_what_is_no_program_is_refused(tmp_path):
    with pytest.raises(ConfigError, match="there is no such program"):
        ExternalSolver(tmp_path / "none", ROADMAP, 5.0)
    path = tmp_path / "solver"
    path.write_text("0:(0,0),\n", encoding="utf-8")
    with pytest.raises(ConfigError, match=f"not executable; chmod \\+x {path}"):
        ExternalSolver(path, ROADMAP, 5.0)
    path.chmod(0o755)
    with pytest.raises(SolverError, match="cannot be run: Exec format error; a script begins"):
        ExternalSolver(path, ROADMAP, 5.0).solve(START, GOALS)
