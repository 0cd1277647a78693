"""Pictures and films of a run by matplotlib."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from swarm_common.model.errors import ConfigError
from swarm_common.model.grid import Grid
from swarm_common.model.records import Pose
from swarm_workbench.trajectories import Trajectories

FRAMES_PER_SECOND, TICKS_PER_SECOND = 10, 10


def draw(
    grid: Grid, stations: Mapping[str, Pose], trajectories: Trajectories, axes: Any = None
) -> Any:
    """Draw the true paths of a run; return the axes.

    Args:
        axes: To draw on; None for a new figure.
    """
    axes = _draw_map(grid, axes)
    for index, name in enumerate(trajectories.names):
        path = trajectories.true[:, index]
        (line,) = axes.plot(path[:, 0], path[:, 1], linewidth=1.2, label=name)
        if len(path):
            axes.plot(*path[-1, :2], marker="o", color=line.get_color())
    for name, pose in stations.items():
        axes.plot(pose.x, pose.y, marker="s", color="black", markersize=4, fillstyle="none")
        axes.annotate(name, (pose.x, pose.y), fontsize=7, xytext=(4, 4), textcoords="offset points")
    if len(trajectories.names) <= 10:
        axes.legend(fontsize=7)
    return axes


def film(
    grid: Grid, radii: Sequence[float], trajectories: Trajectories, path: Path, speed: float
) -> None:
    """Write a film of the true poses: a GIF, or by ffmpeg what the suffix says.

    Args:
        radii: [m] of the robots.
        speed: Speed of the film, in multiples of real time.

    Raises:
        ConfigError: If ffmpeg is wanted and missing, or it cannot be written.
    """
    from matplotlib import animation, pyplot
    from matplotlib.patches import Circle

    axes = _draw_map(grid, None)
    discs = [axes.add_patch(Circle((0.0, 0.0), r, color=f"C{i}")) for i, r in enumerate(radii)]
    step = max(1, round(speed * TICKS_PER_SECOND / FRAMES_PER_SECOND))

    def move(tick: int) -> list[Any]:
        axes.set_title(f"t = {trajectories.times[tick]:.1f} s")
        for disc, pose in zip(discs, trajectories.true[tick], strict=True):
            disc.center = pose[:2]
        return discs

    made = animation.FuncAnimation(axes.figure, move, range(0, len(trajectories.times), step))
    writer = "pillow" if path.suffix == ".gif" else "ffmpeg"
    try:
        made.save(path, writer=writer, fps=FRAMES_PER_SECOND, dpi=80)
    except (OSError, ValueError) as error:
        raise ConfigError(f"cannot write the film {path}: {error}; take a .gif") from None
    finally:
        pyplot.close(axes.figure)


def _draw_map(grid: Grid, axes: Any) -> Any:
    from matplotlib import pyplot

    if axes is None:
        axes = pyplot.subplots(figsize=(7.0, 5.0))[1]
    right = grid.origin_x + grid.width * grid.resolution
    top = grid.origin_y + grid.height * grid.resolution
    shade = np.select([grid.cells == 0, grid.cells < 0], [1.0, 0.85], 0.3)
    extent = (grid.origin_x, right, grid.origin_y, top)
    axes.imshow(shade, cmap="gray", vmin=0.0, vmax=1.0, origin="lower", extent=extent)
    axes.set_aspect("equal")
    axes.set_xlabel("x [m]")
    axes.set_ylabel("y [m]")
    return axes
