"""Where every robot was at each tick; one reader for all kinds of runs."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from swarm_common.files.journal import Journal, read_journal
from swarm_common.files.trajectory_io import TRAJECTORY_FILE, TrajectoryWriter, read_trajectory
from swarm_common.model.errors import ConfigError
from swarm_common.model.records import CONTROL_PERIOD, FloatArray
from swarm_workbench.tables import table

NAMES_FILE = "world.jsonl"


@dataclass(frozen=True, slots=True)
class Trajectories:
    """Poses of all robots, ten a simulated second."""

    names: tuple[str, ...]  # names of the robots
    times: FloatArray  # (T,) [s]
    true: FloatArray  # (T, n, 3) x, y [m], yaw [rad] in map; NaN where a robot was not there
    # (T, n, 3) likewise, what the robots believed; NaN where nobody recorded it
    estimated: FloatArray

    @classmethod
    def load(cls, run: str | Path) -> Trajectories:
        """Return the true poses of a run of `swarm-up` or `Swarm`, or what `save` wrote.

        Args:
            run: Its folder, like `runs/latest`.

        Raises:
            ConfigError: If there are none in the folder.
        """
        trace = Path(run) / "trace"
        try:
            ticks, poses = read_trajectory(trace / TRAJECTORY_FILE)
        except OSError:
            raise ConfigError(
                f"{run} has no {TRAJECTORY_FILE}; expected the folder of a run, like runs/latest"
            ) from None
        named = [line["robots"] for line in read_journal(trace / NAMES_FILE) if "robots" in line]
        names = tuple(named[-1]) if named else ()
        true = poses.astype(np.float64)
        times = ticks.astype(np.float64) * CONTROL_PERIOD
        return cls(names, times, true, np.full_like(true, np.nan))

    def save(self, run: str | Path) -> None:
        """Write the true poses into a folder, as runs of processes have them.

        Raises:
            ConfigError: If it cannot be written.
        """
        trace = Path(run) / "trace"
        try:
            trace.mkdir(parents=True, exist_ok=True)
            names, poses = Journal(trace / NAMES_FILE), TrajectoryWriter(trace / TRAJECTORY_FILE)
        except OSError as error:
            raise ConfigError(f"cannot write trajectories to {run}: {error.strerror}") from None
        names.write(robots=self.names)
        for time, row in zip(self.times.tolist(), self.true, strict=True):
            poses.write(round(time / CONTROL_PERIOD), row)
        names.close()
        poses.close()

    def of(self, name: str) -> FloatArray:
        """Return the true poses (T, 3) of one robot."""
        if name not in self.names:
            raise ConfigError(f"no robot '{name}' in this run; there are {', '.join(self.names)}")
        return self.true[:, self.names.index(name)]

    def table(self) -> Any:
        """Return a row per tick and robot."""
        ticks, robots = self.true.shape[:2]
        columns: dict[str, Any] = {
            "t": np.repeat(self.times, robots),
            "robot": np.tile(np.array(self.names), ticks),
        }
        for kind, poses in (("", self.true), ("_estimated", self.estimated)):
            for axis, name in enumerate(("x", "y", "yaw")):
                columns[f"{name}{kind}"] = poses[:, :, axis].ravel()
        return table(columns)
