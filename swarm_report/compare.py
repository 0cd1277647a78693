"""Several runs side by side: a table, and plots that lay them over each other."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from swarm_common.model.errors import ConfigError
from swarm_report import style
from swarm_report.document import makespan, merits, number, save
from swarm_report.judgement import judge
from swarm_report.page import Plot, page_html, plots_html, table_html
from swarm_report.run import RunData
from swarm_report.style import CYCLE, LINE_STYLES, figure

BIN = 0.02  # [m] of the clearance curve
BARS = {  # of the report -> what the panel is called
    "makespan": "makespan [s]",
    "throughput_per_minute": "goals per minute",
    "hold_time": "holding, all robots [s]",
    "wait_time": "waiting, all robots [s]",
    "real_time_factor": "real-time factor",
    "min_clearance": "smallest clearance [m]",
}


def labels(runs: Sequence[RunData]) -> list[str]:
    """Return a short name per run, told apart by number where folders share theirs."""
    names = [run.name for run in runs]
    return [
        name if names.count(name) == 1 else f"{name} ({place})"
        for place, name in enumerate(names, 1)
    ]


def comparison(runs: Sequence[RunData]) -> tuple[list[str], list[list[str]]]:
    """Return the head and rows of a table with a column per run."""
    columns = [_column(run) for run in runs]
    rows = list(dict.fromkeys(name for column in columns for name in column))
    table = [[name, *(column.get(name, "–") for column in columns)] for name in rows]
    return ["", *labels(runs)], table


def _column(run: RunData) -> dict[str, str]:
    report = run.report
    facts = {
        "verdict": judge(run).headline,
        "robots": str(len(run.robots)),
        "world": str(report.get("world", "–")),
        "mission": str(report.get("mission") or "–"),
        "seed": str(report.get("seed", "–")),
    }
    hashed = str(report.get("trajectory_sha256") or "–")
    return facts | merits(report) | {"trajectories (sha256)": hashed[:12]}


def write_comparison(runs: Sequence[RunData], page: Path) -> None:
    """Write a page that compares runs, and its plots beside it.

    Raises:
        ConfigError: If it cannot be written.
    """
    folder = page.with_name(f"{page.stem}_plots")
    try:
        folder.mkdir(parents=True, exist_ok=True)
        plots = _draw(runs, folder)
        head, rows = comparison(runs)
        body = [
            table_html(head, rows),
            "<h2>Plots</h2>",
            plots_html(plots),
        ]
        title = f"{len(runs)} runs compared"
        page.write_text(page_html(title, ", ".join(labels(runs)), body), encoding="utf-8")
    except OSError as cause:
        raise ConfigError(f"cannot write {page}: {cause.strerror}; choose another -o") from cause


def _draw(runs: Sequence[RunData], folder: Path) -> list[Plot]:
    drawings = {
        "goals": (_goals, "Goals reached over simulated time, as a share of the mission"),
        "clearance": (_clearance, "Share of robot-seconds nearer than a distance to anything"),
        "merits": (_merits, "Figures of merit; a dash stands for what was not measured"),
    }
    plots = []
    with style.settings():
        for name, (draw, caption) in drawings.items():
            svg = save(draw(runs), folder / name)
            plots.append(Plot(name, caption, svg, name == "merits"))
    return plots


def _look(index: int) -> dict[str, Any]:
    style_of = LINE_STYLES[(index // len(CYCLE) + index) % len(LINE_STYLES)]
    return {"color": CYCLE[index % len(CYCLE)], "linestyle": style_of, "linewidth": 1.6}


def _goals(runs: Sequence[RunData]) -> Figure:
    drawing = figure(3.4)
    axes = drawing.add_subplot()
    for index, (run, label) in enumerate(zip(runs, labels(runs), strict=True)):
        times = [event.time for event in run.goals if event.outcome == "reached"]
        counts = run.report.get("goals", {})
        total = sum(counts.get(key, 0) for key in ("reached", "failed", "pending"))
        share = 100.0 * np.append(np.arange(len(times) + 1), len(times)) / max(total, len(times), 1)
        axes.step([0.0, *times, run.end], share, where="post", label=label, **_look(index))
    axes.set_ylim(0.0, 102.0)
    axes.set_xlim(left=0.0)
    axes.set_xlabel("simulated time [s]")
    axes.set_ylabel("goals reached [% of the mission]")
    _legend(axes)
    return drawing


def _clearance(runs: Sequence[RunData]) -> Figure:
    drawing = figure(3.4)
    axes = drawing.add_subplot()
    for index, (run, label) in enumerate(zip(runs, labels(runs), strict=True)):
        series = run.series
        if series is None:
            continue
        nearest = np.minimum(series.to_robot, series.to_world).ravel()
        edges = np.arange(0.0, series.near, BIN)
        share = 100.0 * np.searchsorted(np.sort(nearest), edges) / max(nearest.size, 1)
        axes.plot(edges, share, label=label, **_look(index))
    axes.set_xlim(left=0.0)
    axes.set_ylim(bottom=0.0)
    axes.set_xlabel("distance to the nearest robot or obstacle [m]")
    axes.set_ylabel("robot-seconds nearer [%]")
    _legend(axes)
    return drawing


def _merits(runs: Sequence[RunData]) -> Figure:
    names = labels(runs)
    drawing = figure(1.2 + 2 * max(1.2, 0.3 * len(runs)), style.WIDE_WIDTH)
    panels = drawing.subplots(2, 3, sharey=True)
    rows = np.arange(len(runs))
    colors = [CYCLE[row % len(CYCLE)] for row in rows]
    for axes, (key, title) in zip(panels.ravel(), BARS.items(), strict=True):
        values = [
            makespan(run.report) if key == "makespan" else run.report.get(key) for run in runs
        ]
        bars = axes.barh(rows, [value or 0.0 for value in values], color=colors, height=0.7)
        axes.bar_label(bars, [number(value) for value in values], padding=3, fontsize=8)
        axes.margins(x=0.18)
        axes.set_xlabel(title)
        axes.set_yticks(rows, names)
        axes.grid(visible=False, axis="y")
    panels[0, 0].invert_yaxis()
    return drawing


def _legend(axes: Axes) -> None:
    axes.legend(fontsize=8, ncols=2, loc="upper left", bbox_to_anchor=(0.0, -0.18))
