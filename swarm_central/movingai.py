"""An external solver by files: Moving AI map and scenario in, paths out.

It is called as LaCAM's programs are: `SOLVER -m MAP -i SCEN -N ROBOTS -t SECONDS -o RESULT`. The
result has a line `T:(x,y),(x,y),...,` per step after the line `solution=`.
"""

from __future__ import annotations

import re
import subprocess
import tempfile
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from swarm_central.roadmap import Roadmap
from swarm_common.model.errors import ConfigError

STEP = re.compile(r"^\d+:((?:\(\d+,\d+\),?)+)$")
PLACE = re.compile(r"\((\d+),(\d+)\)")
GRACE = 2.0  # [s] beyond its time that a solver is waited for


class ExternalSolver:
    """Solves joint plans by another program."""

    def __init__(self, program: Path, roadmap: Roadmap, seconds: float) -> None:
        """Take a program.

        Args:
            program: That is run for each plan.
            roadmap: Whose vertices are the passable cells.
            seconds: Of wall time that it gets for a plan.

        Raises:
            ConfigError: If there is no such program.
        """
        if not program.is_file():
            raise ConfigError(f"--central-solver is {program}; there is no such program")
        self._program = program.resolve()
        self._seconds = seconds
        low = roadmap.cells.min(axis=0)
        self._cells = roadmap.cells - low
        self._map = map_text(self._cells)
        self._vertices = {(int(c), int(r)): v for v, (c, r) in enumerate(self._cells)}

    def solve(self, start: NDArray[np.int32], goals: NDArray[np.int32]) -> NDArray[np.int32] | None:
        """Return the vertices (k + 1, n) of all robots, step by step; None without a plan.

        Args:
            start: (n,) vertices.
            goals: (n,) vertices, all different.

        Raises:
            ConfigError: If the program cannot be run or its result cannot be read.
        """
        with tempfile.TemporaryDirectory(prefix="swarm-central-") as name:
            folder = Path(name)
            (folder / "roadmap.map").write_text(self._map, encoding="utf-8")
            scenario = scenario_text(self._cells, start, goals)
            (folder / "robots.scen").write_text(scenario, encoding="utf-8")
            result = folder / "result.txt"
            command = [
                str(self._program), "-m", str(folder / "roadmap.map"),
                "-i", str(folder / "robots.scen"), "-N", str(len(start)),
                "-t", f"{self._seconds:g}", "-o", str(result),
            ]  # fmt: skip
            try:
                subprocess.run(
                    command, capture_output=True, timeout=self._seconds + GRACE, check=False
                )
            except OSError as cause:
                raise ConfigError(f"--central-solver {self._program}: {cause}") from cause
            except subprocess.TimeoutExpired:
                return None
            if not result.is_file():
                return None
            return self._paths(result.read_text(encoding="utf-8"), len(start))

    def _paths(self, text: str, count: int) -> NDArray[np.int32] | None:
        steps = []
        for line in text.splitlines():
            found = STEP.match(line.strip())
            if found is None:
                continue
            cells = [(int(x), int(y)) for x, y in PLACE.findall(found[1])]
            if len(cells) != count or any(cell not in self._vertices for cell in cells):
                raise ConfigError(
                    f"--central-solver {self._program} wrote {line[:60]!r}; "
                    f"expected {count} passable cells (x,y)"
                )
            steps.append([self._vertices[cell] for cell in cells])
        return np.array(steps, np.int32) if steps else None


def map_text(cells: NDArray[np.int64]) -> str:
    """Return a map in Moving AI's format.

    Args:
        cells: (V, 2) columns and rows of the passable cells, from 0.
    """
    width, height = (cells.max(axis=0) + 1).tolist()
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
