"""Map, paths and stations by matplotlib."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from swarm_common.model.grid import Grid
from swarm_common.model.records import Pose
from swarm_workbench.trajectories import Trajectories


def draw(
    grid: Grid, stations: Mapping[str, Pose], trajectories: Trajectories, axes: Any = None
) -> Any:
    """Draw the true paths of a run; return the axes.

    Args:
        axes: To draw on; None for a new figure.
    """
    from matplotlib import pyplot

    if axes is None:
        axes = pyplot.subplots(figsize=(7.0, 5.0))[1]
    right = grid.origin_x + grid.width * grid.resolution
    top = grid.origin_y + grid.height * grid.resolution
    shade = np.select([grid.cells == 0, grid.cells < 0], [1.0, 0.85], 0.3)
    extent = (grid.origin_x, right, grid.origin_y, top)
    axes.imshow(shade, cmap="gray", vmin=0.0, vmax=1.0, origin="lower", extent=extent)
    for index, name in enumerate(trajectories.names):
        path = trajectories.true[:, index]
        (line,) = axes.plot(path[:, 0], path[:, 1], linewidth=1.2, label=name)
        if len(path):
            axes.plot(*path[-1, :2], marker="o", color=line.get_color())
    for name, pose in stations.items():
        axes.plot(pose.x, pose.y, marker="s", color="black", markersize=4, fillstyle="none")
        axes.annotate(name, (pose.x, pose.y), fontsize=7, xytext=(4, 4), textcoords="offset points")
    axes.set_aspect("equal")
    axes.set_xlabel("x [m]")
    axes.set_ylabel("y [m]")
    if len(trajectories.names) <= 10:
        axes.legend(fontsize=7)
    return axes
