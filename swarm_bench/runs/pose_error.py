"""How well the robots of a run know where they are: estimated poses against the true ones."""

from __future__ import annotations

from array import array
from collections.abc import Collection, Sequence

import numpy as np

from swarm_common.model.records import FloatArray
from swarm_nav.interfaces import Reserving
from swarm_run.loop import Driver
from swarm_run.record.figures import percentiles


class PoseErrors:
    """Distances [m] of all robots in all ticks so far."""

    def __init__(self) -> None:
        self._values = array("f")

    def note(self, drivers: Sequence[Driver], truth_map: FloatArray, dead: Collection[int]) -> None:
        """Record the pose errors of a tick.

        Args:
            drivers: What decides for each robot; only those that reserve space are asked.
            truth_map: True poses (n, 3) in map.
            dead: Indices of the robots that do nothing.
        """
        for index, driver in enumerate(drivers):
            if index not in dead and isinstance(driver, Reserving):
                pose = driver.services.pose_map
                self._values.append(
                    float(np.hypot(pose.x - truth_map[index, 0], pose.y - truth_map[index, 1]))
                )

    def figures(self) -> dict[str, float] | None:
        """Return `median`, `p95` and `max` [m]; None if nobody was asked."""
        return percentiles(self._values, median=50, p95=95, max=100) if self._values else None
