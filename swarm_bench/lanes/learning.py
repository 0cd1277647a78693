"""Time that robots lose in a run, and lanes that cost it.

A guidance graph prices the edges of a map, so that robots which plan alone spread (Zhang et al.,
"Guidance Graph Optimization for Lifelong Multi-Agent Path Finding", 2024). Here the price of a
place is the time that robots lost in it: what stations and queues cost is the same for all who must
go there, and through traffic goes around.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy import ndimage

from swarm_common.model.grid import KEEPOUT, Grid
from swarm_common.model.records import FloatArray
from swarm_nav.planning.terrain import KEEPOUT_COST

SMOOTHING = 0.2  # [m] standard deviation over which time and way are averaged
MOST_LOST = 3.0  # times the free driving time that a place may cost
LEAST_DRIVEN = 0.02  # [m] a robot-hour and cell of way below which nothing is known of a place


@dataclass(frozen=True, slots=True)
class Traffic:
    """Traffic of one run; arrays are of the map's cells.

    Attributes:
        throughput: [1/h] of finished orders or goals.
        contacts: Contacts of robots with each other and with the world.
        hours: Robot-hours of the run.
        seconds: (h, w) [s] that robots spent in a cell.
        metres: (h, w) [m] that they drove there.
    """

    throughput: float
    contacts: int
    hours: float
    seconds: FloatArray
    metres: FloatArray


def lost_time(runs: Sequence[Traffic], speed: float, resolution: float) -> FloatArray:
    """Return the time lost per free driving time (h, w); 0 where hardly anybody drove.

    Args:
        speed: [m/s] of free driving.
        resolution: [m] of a cell.
    """
    width = SMOOTHING / resolution
    seconds = ndimage.gaussian_filter(sum(run.seconds for run in runs), width)
    metres = ndimage.gaussian_filter(sum(run.metres for run in runs), width)
    is_known = metres > LEAST_DRIVEN * sum(run.hours for run in runs)
    lost = seconds / np.where(is_known, metres, 1.0) * speed - 1.0
    return np.where(is_known, lost, 0.0).clip(0.0, MOST_LOST)


def lanes_of(costs: FloatArray, grid: Grid) -> Grid:
    """Return the mask of lanes, as Nav2's KeepoutFilter takes it.

    Args:
        costs: (h, w) extra cost per metre.
        grid: The map.
    """
    values = np.rint(costs * (KEEPOUT - 1) / KEEPOUT_COST).clip(0, KEEPOUT - 1)
    return Grid(values.astype(np.int8), grid.resolution, grid.origin_x, grid.origin_y)
