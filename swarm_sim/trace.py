"""Light time series of the truth for the report: where everybody was, once a second."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from swarm_common.errors import ConfigError
from swarm_common.journal import Journal
from swarm_common.map_io import save_map
from swarm_common.records import CONTROL_PERIOD, FloatArray
from swarm_sim.build import Stage
from swarm_sim.engine import NEAR

MAP_FILE, SERIES_FILE = "map.yaml", "world.jsonl"

PERIOD_TICKS = 10  # between two lines
THOUSANDTHS = 1000.0  # whole mm and mrad are short to write


class Trace:
    """Writes a line each second of simulated time: poses, and the smallest clearances since.

    Lengths are in mm and angles in mrad; clearances beyond `NEAR` are not measured and shown as
    `NEAR`.
    """

    def __init__(self, journal: Journal, names: Sequence[str]) -> None:
        self._journal = journal
        self._clearances = np.full((len(names), 2), NEAR)
        journal.write(robots=list(names), near_mm=round(NEAR * THOUSANDTHS))

    def observe(self, tick: int, poses: FloatArray, clearances: FloatArray) -> None:
        """Take in a tick.

        Args:
            tick: Control ticks since the start.
            poses: True x, y, yaw (n, 3) in the map frame.
            clearances: (n, 2) to the nearest robot, obstacle; inf where there is none.
        """
        np.minimum(self._clearances, clearances, out=self._clearances)
        if tick % PERIOD_TICKS:
            return
        x, y, yaw = _whole(poses).T.tolist()
        robot, world = _whole(self._clearances).T.tolist()
        self._journal.write(
            t=round(tick * CONTROL_PERIOD, 3), x=x, y=y, yaw=yaw, to_robot=robot, to_world=world
        )
        self._clearances[:] = NEAR


def _whole(values: FloatArray) -> NDArray[np.int64]:
    return np.rint(np.nan_to_num(values) * THOUSANDTHS).astype(np.int64)


def begin_trace(folder: Path, stage: Stage) -> Trace:
    """Write the map that the robots get into a folder, and begin the time series beside it.

    Raises:
        ConfigError: If the folder cannot be written.
    """
    world = stage.world
    try:
        save_map(stage.grid, folder / MAP_FILE)
        trace = Trace(Journal(folder / SERIES_FILE), world.names)
    except OSError as cause:
        raise ConfigError(f"trace_dir: cannot write to {folder}: {cause.strerror}") from cause
    trace.observe(world.tick, world.poses, world.clearances)
    return trace
