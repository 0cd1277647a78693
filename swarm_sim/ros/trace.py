"""Time series of the truth: where everybody was, each second for the report, and each tick."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from swarm_common.files.journal import Journal
from swarm_common.files.map_io import save_map
from swarm_common.files.trajectory_io import TRAJECTORY_FILE, TrajectoryWriter
from swarm_common.model.errors import ConfigError
from swarm_common.model.grid import Grid
from swarm_common.model.records import CONTROL_PERIOD, FloatArray
from swarm_sim.physics.engine import NEAR
from swarm_sim.world.world import World

MAP_FILE, SERIES_FILE = "map.yaml", "world.jsonl"

PERIOD_TICKS = 10  # between two lines
THOUSANDTHS = 1000.0  # whole mm and mrad are short to write


class Trace:
    """Writes a line each second of simulated time: poses, and the smallest clearances since.

    Lengths are in mm and angles in mrad; clearances beyond `NEAR` are not measured and shown as
    `NEAR`.
    """

    def __init__(
        self, journal: Journal, names: Sequence[str], ticks: TrajectoryWriter | None = None
    ) -> None:
        """Begin; the names of the robots are written first.

        Args:
            names: The list may grow while the run goes on.
            ticks: Receives the poses of every tick; None for nobody.
        """
        self._journal = journal
        self._ticks = ticks
        self._names = names
        self._clearances = np.full((0, 2), NEAR)
        self._grow()

    def _grow(self) -> None:
        more = np.full((len(self._names) - len(self._clearances), 2), NEAR)
        self._clearances = np.vstack([self._clearances, more])
        self._journal.write(robots=list(self._names), near_mm=round(NEAR * THOUSANDTHS))

    def observe(
        self, tick: int, poses: FloatArray, clearances: FloatArray, absent: Collection[int] = ()
    ) -> None:
        """Record a tick.

        Args:
            absent: Indices of robots that are not there; null is written for them.
        """
        if len(poses) > len(self._clearances):
            self._grow()
        if self._ticks is not None:
            self._ticks.write(tick, poses, absent)
        np.minimum(self._clearances, clearances, out=self._clearances)
        if tick % PERIOD_TICKS:
            return
        x, y, yaw = _whole(poses).T.tolist()
        robot, world = _whole(self._clearances).T.tolist()
        for column in (x, y, yaw, robot, world):
            for index in absent:
                column[index] = None
        self._journal.write(
            t=round(tick * CONTROL_PERIOD, 3), x=x, y=y, yaw=yaw, to_robot=robot, to_world=world
        )
        self._clearances[:] = NEAR


def _whole(values: FloatArray) -> NDArray[np.int64]:
    return np.rint(np.nan_to_num(values) * THOUSANDTHS).astype(np.int64)


def begin_trace(folder: Path, world: World, grid: Grid) -> Trace:
    """Write the map that the robots get into a folder, and begin the time series beside it."""
    try:
        save_map(grid, folder / MAP_FILE)
        ticks = TrajectoryWriter(folder / TRAJECTORY_FILE)
        trace = Trace(Journal(folder / SERIES_FILE), world.names, ticks)
    except OSError as cause:
        raise ConfigError(f"trace_dir: cannot write to {folder}: {cause.strerror}") from cause
    trace.observe(world.tick, world.poses, world.clearances)
    return trace
