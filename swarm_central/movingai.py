"""An external solver by files: Moving AI map and scenario in, paths out.

It is called as LaCAM's programs are: `SOLVER -m MAP -i SCEN -N ROBOTS -t SECONDS -o RESULT`. The
result has a line `T:(x,y),(x,y),...,` per step, from 0 on; lines `name=value` may stand before.
Robots that must stay, and places that nobody may enter, are walls of the map and not in the
scenario. Whatever goes wrong is a `SolverError`: no other method plans in the solver's name.
"""

from __future__ import annotations

import contextlib
import os
import re
import shutil
import tempfile
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import NoReturn

import numpy as np
from numpy.typing import NDArray

from swarm_central.plan_check import first_fault, sentence
from swarm_central.program import run_limited
from swarm_central.roadmap import Roadmap
from swarm_common.model.errors import ConfigError

OPTION = "--central-solver"
STEP = re.compile(r"(\d{1,9}):((?:\(\d{1,9},\d{1,9}\),?)+)", re.ASCII)
PLACE = re.compile(r"\((\d+),(\d+)\)", re.ASCII)
HEADER = re.compile(r"\w+=.*", re.ASCII)
UNSOLVED = re.compile(r"solved=(0|false)", re.ASCII | re.IGNORECASE)
GRACE = 10.0  # [s] beyond its time that a solver is waited for: a busy machine must not end a run
MOST_BYTES = 1 << 26  # of a result
MOST_SHOWN = 60  # letters of a line
FOLDER = "swarm-central-"  # begins the names of folders of files; the process id follows


class SolverError(ConfigError):
    """An external solver gave no plan, or one that cannot be driven."""


class ExternalSolver:
    """Solves joint plans by another program."""

    def __init__(self, program: Path, roadmap: Roadmap, seconds: float) -> None:
        """Check that there is such a program.

        Args:
            program: Executable file that is run for each plan.
            roadmap: Its vertices are the passable cells.
            seconds: [s] of wall time that it gets for a plan.

        Raises:
            ConfigError: If it is no program.
        """
        check_program(program)
        self._name = program
        self._program = program.resolve()
        self._seconds = seconds
        self._neighbors = roadmap.costs.neighbors
        self._cells = roadmap.cells - roadmap.cells.min(axis=0)
        _remove_leftovers()

    def solve(
        self,
        start: NDArray[np.int32],
        goals: NDArray[np.int32],
        *,
        names: Sequence[str] = (),
        stays: NDArray[np.bool_] | None = None,
        closed: NDArray[np.bool_] | None = None,
    ) -> NDArray[np.int32]:
        """Return the vertices (k + 1, n) of all robots, step by step, from `start` to `goals`.

        Args:
            start: (n,) vertices, all different.
            goals: (n,) vertices, all different.
            names: Names of the robots, for messages; none: numbers from 1.
            stays: (n,) robots that must not move; None for none.
            closed: (V,) vertices that no robot may enter; None for none.

        Raises:
            SolverError: If the program cannot be run, fails, takes too long, or its plan is not one
                that robots can drive.
        """
        moving = np.arange(len(start)) if stays is None else np.flatnonzero(~stays)
        plan = np.tile(start, (1, 1))
        if (start[moving] == goals[moving]).all():
            return plan
        walls = np.zeros(len(self._cells), np.bool_) if closed is None else closed.copy()
        walls[start] = True
        walls[start[moving]] = False
        named = [
            f"robot {number} of {len(moving)}" + (f" ({names[robot]})" if len(names) else "")
            for number, robot in enumerate(moving.tolist(), 1)
        ]
        steps = self._steps(start[moving], goals[moving], walls)
        neighbors = np.where(walls[self._neighbors], -1, self._neighbors)
        fault = first_fault(
            steps, neighbors, start=start[moving], goals=goals[moving], may_rotate=False
        )
        if fault is not None:
            self._refuse(f"wrote a plan in which {sentence(fault, named, self._cells)}")
        plan = np.tile(start, (len(steps), 1))
        plan[:, moving] = steps
        return plan

    def _steps(
        self, start: NDArray[np.int32], goals: NDArray[np.int32], walls: NDArray[np.bool_]
    ) -> NDArray[np.int32]:
        """Return the plan that the program writes, unchecked but for its format."""
        prefix = f"{FOLDER}{os.getpid()}-"
        with tempfile.TemporaryDirectory(prefix=prefix, ignore_cleanup_errors=True) as name:
            folder = Path(name)
            free = self._cells[~walls]
            size = self._cells.max(axis=0) + 1
            (folder / "roadmap.map").write_text(map_text(free, size), encoding="utf-8")
            scenario = scenario_text(self._cells, start, goals)
            (folder / "robots.scen").write_text(scenario, encoding="utf-8")
            result = folder / "result.txt"
            self._run(folder, result, len(start))
            vertices = {
                (int(x), int(y)): vertex
                for vertex, (x, y) in enumerate(self._cells)
                if not walls[vertex]
            }
            return self._read(result, len(start), vertices)

    def _run(self, folder: Path, result: Path, robots: int) -> None:
        command = [
            str(self._program),
            "-m",
            str(folder / "roadmap.map"),
            "-i",
            str(folder / "robots.scen"),
            "-N",
            str(robots),
            "-t",
            f"{self._seconds:g}",
            "-o",
            str(result),
        ]
        try:
            ended = run_limited(command, self._seconds + GRACE)
        except OSError as cause:
            raise SolverError(
                f"{OPTION} {self._name} cannot be run: {cause.strerror}; a script begins with a "
                "line like #!/usr/bin/env python3"
            ) from cause
        said = f": {ended.complaint}" if ended.complaint else ""
        if ended.code is None:
            raise SolverError(
                f"{OPTION} {self._name} was killed {GRACE:g} s after its time of "
                f"{self._seconds:g} s for {robots} robots{said}; give it more by "
                f"--set central.solver_time={3 * self._seconds:g}, or leave it out"
            )
        if ended.code < 0:
            self._refuse(f"was ended by signal {-ended.code}{said}")
        if ended.code > 0:
            self._refuse(f"gave up with exit code {ended.code}{said}")
        if not result.is_file():
            self._refuse(f"ended without a file for its option -o{said}")

    def _read(
        self, result: Path, count: int, vertices: Mapping[tuple[int, int], int]
    ) -> NDArray[np.int32]:
        """Return the steps in a result.

        Args:
            count: Number of robots.
            vertices: By column and row, of the free cells.
        """
        if result.stat().st_size > MOST_BYTES:
            self._refuse(f"wrote more than {MOST_BYTES >> 20} MB")
        text = result.read_text(encoding="utf-8", errors="replace")
        steps: list[list[int]] = []
        for number, line in enumerate(map(str.strip, text.splitlines()), 1):
            where = f"in line {number}, {line[:MOST_SHOWN]!r}"
            if UNSOLVED.fullmatch(line):
                self._refuse(f"found no plan for {count} robots, as line {number} says: {line}")
            if not line or (not steps and HEADER.fullmatch(line)):
                continue
            found = STEP.fullmatch(line)
            if found is None:
                self._refuse(f"wrote no step {where}; expected T:(x,y),(x,y),... of whole numbers")
            cells = [(int(x), int(y)) for x, y in PLACE.findall(found[2])]
            if int(found[1]) != len(steps):
                self._refuse(f"wrote step {found[1]} {where}; expected step {len(steps)}")
            if len(cells) != count:
                self._refuse(f"wrote {len(cells)} robots {where}; expected all {count}")
            blocked = next((robot for robot, at in enumerate(cells) if at not in vertices), None)
            if blocked is not None:
                x, y = cells[blocked]
                self._refuse(f"has robot {blocked + 1} on no free cell, ({x},{y}), {where}")
            steps.append([vertices[cell] for cell in cells])
        if not steps:
            self._refuse(f"wrote a result without a plan for {count} robots")
        return np.array(steps, np.int32)

    def _refuse(self, told: str) -> NoReturn:
        raise SolverError(f"{OPTION} {self._name} {told}; mend the program, or leave it out")


def check_program(program: Path) -> None:
    """Refuse what is no executable file.

    Raises:
        ConfigError: With what it is instead.
    """
    if not program.is_file():
        raise ConfigError(f"{OPTION} is {program}; there is no such program")
    if not os.access(program, os.X_OK):
        raise ConfigError(f"{OPTION} is {program}, which is not executable; chmod +x {program}")


def _remove_leftovers() -> None:
    """Remove the files of processes that were killed while a solver ran."""
    for folder in Path(tempfile.gettempdir()).glob(f"{FOLDER}*-*"):
        number = folder.name.removeprefix(FOLDER).partition("-")[0]
        with contextlib.suppress(OSError):
            if number.isdecimal() and folder.stat().st_uid == os.getuid() and not _lives(number):
                shutil.rmtree(folder, ignore_errors=True)


def _lives(process: str) -> bool:
    try:
        os.kill(int(process), 0)
    except ProcessLookupError:
        return False
    except (OSError, OverflowError):
        return True
    return True


def map_text(cells: NDArray[np.int64], size: Sequence[int] | NDArray[np.int64] = (0, 0)) -> str:
    """Return a map in Moving AI's format.

    Args:
        cells: (V, 2) columns and rows of the passable cells, from 0.
        size: Least number of columns and of rows.
    """
    width, height = np.maximum(cells.max(axis=0) + 1, size).tolist()
    rows = np.full((height, width), "@")
    rows[cells[:, 1], cells[:, 0]] = "."
    lines = ["type octile", f"height {height}", f"width {width}", "map"]
    return "\n".join([*lines, *("".join(row) for row in rows.tolist())]) + "\n"


def scenario_text(
    cells: NDArray[np.int64], start: NDArray[np.int32], goals: NDArray[np.int32]
) -> str:
    """Return a scenario in Moving AI's format; its optimal lengths are not filled in.

    Args:
        cells: (V, 2) columns and rows.
        start: (n,) vertices.
        goals: (n,) vertices.
    """
    width, height = (cells.max(axis=0) + 1).tolist()
    lines = ["version 1"]
    for first, last in zip(cells[start].tolist(), cells[goals].tolist(), strict=True):
        values = (0, "roadmap.map", width, height, *first, *last, 0)
        lines.append("\t".join(map(str, values)))
    return "\n".join(lines) + "\n"
