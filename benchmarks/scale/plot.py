"""How cost grows with the swarm: CPU time, real-time factor, start-up and memory by size."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from benchmarks.scale.row import ScaleRow
from swarm_common.model.errors import ConfigError

PARTS = {"world": "#4477aa", "navigators": "#ee6677", "other": "#bbbbbb"}
LINE = "#222222"
SIZE = (9.0, 6.2)  # [inch]


def draw_scale(rows: Sequence[ScaleRow], path: Path) -> list[Path]:
    """Draw rows of one system; return the files: SVG and PNG beside each other.

    Raises:
        ConfigError: If they cannot be written.
    """
    import matplotlib

    matplotlib.use("Agg")
    matplotlib.rcParams["svg.hashsalt"] = "swarm-bench"
    from matplotlib import pyplot

    figure, axes = pyplot.subplots(2, 2, figsize=SIZE, layout="constrained")
    sizes = [row.first.robots for row in rows]
    _draw_cost(axes[0, 0], rows)
    _draw_line(axes[0, 1], sizes, [row.factor for row in rows], "real-time factor", log=True)
    axes[0, 1].axhline(1.0, color=LINE, linewidth=0.8, linestyle=":")
    starts = [row.median(lambda run: run.start_up) for row in rows]
    _draw_line(axes[1, 0], sizes, starts, "start-up [s]")
    graph = rows[0].first.system == "graph"
    memory = [row.memory("total") for row in rows]
    _draw_line(axes[1, 1], sizes, memory, "memory of all processes [MB]" if graph else "RSS [MB]")
    files = [path.with_suffix(".svg"), path.with_suffix(".png")]
    try:
        figure.savefig(files[0], metadata={"Date": None})
        figure.savefig(files[1], dpi=110)
    except OSError as cause:
        raise ConfigError(f"cannot write {path}: {cause}") from cause
    finally:
        pyplot.close(figure)
    return files


def _draw_cost(axes: Any, rows: Sequence[ScaleRow]) -> None:
    """Stack what a robot costs in a simulated second."""
    places = range(len(rows))
    below = [0.0] * len(rows)
    for part, color in PARTS.items():
        values = [row.cpu(part) or 0.0 for row in rows]
        axes.bar(places, values, bottom=below, color=color, label=part, width=0.7)
        below = [a + b for a, b in zip(below, values, strict=True)]
    for place, row in zip(places, rows, strict=True):
        dds = row.cpu("dds")
        if dds is not None:
            label = "of it DDS threads" if place == 0 else None
            axes.plot([place - 0.35, place + 0.35], [dds, dds], color=LINE, label=label)
    names = [f"{row.first.robots}" + ("*" if row.label != rows[0].label else "") for row in rows]
    axes.set_xticks(list(places), names)
    axes.set_xlabel(_note(rows))
    axes.set_ylabel("CPU per robot-second [ms]")
    axes.set_ylim(0.0, 1.3 * max(below, default=1.0))  # room for the legend
    axes.legend(fontsize=8, frameon=False, loc="upper center", ncols=2)
    axes.spines[["top", "right"]].set_visible(False)


def _note(rows: Sequence[ScaleRow]) -> str:
    others = {row.label for row in rows} - {rows[0].label}
    return f"robots ({rows[0].label}" + "".join(f"; *: {name}" for name in sorted(others)) + ")"


def _draw_line(
    axes: Any, sizes: Sequence[int], values: Sequence[float | None], label: str, log: bool = False
) -> None:
    from matplotlib.ticker import LogFormatter

    known = [(size, value) for size, value in zip(sizes, values, strict=True) if value is not None]
    axes.plot(*zip(*known, strict=True), marker="o", color=PARTS["world"]) if known else None
    axes.set_xlabel("robots")
    axes.set_ylabel(label)
    if log:
        axes.set_yscale("log")
        axes.yaxis.set_major_formatter("{x:g}")
        axes.yaxis.set_minor_formatter(LogFormatter(minor_thresholds=(1.5, 0.5)))
    else:
        axes.set_ylim(bottom=0.0)
    axes.set_xlim(left=0.0)
    axes.grid(color="#dddddd", linewidth=0.6)
    axes.spines[["top", "right"]].set_visible(False)
