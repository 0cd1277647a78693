"""Plots over time, and of distances: goals, clearance, speed and CPU."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from swarm_report.measures import shares_over_time, throughput
from swarm_report.run import RunData, UsageSeries, mission_goals
from swarm_report.style import (
    BLACK,
    BLUE,
    GROUPS,
    LABELS,
    LINE_STYLES,
    ORANGE,
    SKY,
    STATES,
    VERMILLION,
    WIDE_WIDTH,
    figure,
    legend_below,
    plot,
)

NEAR_MISS = 0.03  # [m] closer without contact is a near miss
BIN = 0.02  # [m] of the clearance histogram


def goals_over_time(run: RunData) -> Figure | None:
    """Return goals reached and missed over simulated time; None without goals."""
    settled = [event for event in run.goals if event.outcome != "sent"]
    if not settled:
        return None
    title = "Goals over time"
    drawing, axes = plot("simulated time [s]", "goals of all robots", title, height=3.0)
    kinds = (("reached", "reached", BLUE, "-"), ("failed", "missed", VERMILLION, "--"))
    for outcome, word, color, style in kinds:
        times = [event.time for event in settled if event.outcome == outcome]
        if times or outcome == "reached":
            count = np.arange(len(times) + 2)
            count[-1] = len(times)
            label = f"{word} ({len(times)})"
            at = [0.0, *times, run.end]
            axes.step(at, count, style, where="post", color=color, label=label, linewidth=1.6)
    total = mission_goals(run.report)
    if total:
        axes.axhline(total, color=BLACK, linestyle=":", linewidth=1.0, label=f"mission ({total})")
    axes.set_xlim(0.0, max(run.end, 1.0))
    axes.set_ylim(bottom=0.0)
    axes.legend(loc="lower right")
    return drawing


def throughput_over_time(run: RunData) -> Figure | None:
    """Return goals per minute over simulated time; None without goals."""
    flow = throughput(run)
    if flow is None:
        return None
    title = f"Throughput (windows of {flow.window:g} s)"
    drawing, axes = plot("simulated time [s]", "goals per minute", title, height=3.0)
    widths = np.maximum(flow.ends - flow.starts, 1e-3)
    axes.bar(flow.starts, flow.per_minute, widths, align="edge", color=SKY, linewidth=0.0)
    axes.axhline(flow.mean, color=BLACK, linestyle="--", linewidth=1.0, label=flow.mean_label)
    axes.set_xlim(0.0, max(run.end, 1.0))
    axes.legend(loc="lower left", bbox_to_anchor=(0.6, 1.0))
    return drawing


def states_over_time(run: RunData) -> Figure | None:
    """Return the share of the robots in each state over time; None without a state log."""
    shares = shares_over_time(run)
    if shares is None:
        return None
    drawing, axes = plot("simulated time [s]", "robots [%]", "What the robots did", height=3.6)
    axes.stackplot(
        shares.times,
        *(100.0 * line for line in shares.by_state.values()),
        labels=[LABELS.get(state, state) for state in shares.by_state],
        colors=[STATES.get(state, BLACK) for state in shares.by_state],
        linewidth=0.0,
    )
    axes.set_xlim(0.0, max(run.end, 1.0))
    axes.set_ylim(0.0, 100.0)
    legend_below(axes, 4)
    return drawing


def clearance(run: RunData) -> Figure | None:
    """Return how near robots came to each other and to obstacles; None without a series."""
    series = run.series
    if series is None or not len(series.times):
        return None
    x = "smallest clearance within a second [m]"
    drawing, axes = plot(x, f"robot-seconds per {BIN:g} m", "Clearance", height=3.6)
    edges = np.arange(0.0, series.near + BIN, BIN)
    for values, label, color, style in (
        (series.to_robot, "to the nearest robot", BLUE, "-"),
        (series.to_world, "to the nearest obstacle", ORANGE, "--"),
    ):
        measured = values[values < series.near - 1e-9]
        part = f"{100.0 * measured.size / values.size:.1f} %" if values.size else "0 %"
        share = f"{label} (below {series.near:g} m in {part})"
        counts, _ = np.histogram(measured, bins=edges)
        axes.stairs(counts, edges, color=color, linestyle=style, linewidth=1.6, label=share)
    axes.axvline(NEAR_MISS, color=VERMILLION, linestyle=":", label=f"near miss ({NEAR_MISS} m)")
    smallest = run.report.get("min_clearance")
    if smallest is not None:
        label = f"smallest of the run ({smallest:.3f} m)"
        axes.axvline(smallest, color=BLACK, linewidth=1.0, linestyle="-.", label=label)
    axes.set_yscale("symlog", linthresh=1.0)
    axes.set_ylim(bottom=0.0)
    axes.set_xlim(0.0, series.near)
    legend_below(axes)
    return drawing


def usage(run: RunData) -> Figure | None:
    """Return real-time factor, CPU and memory over the wall clock; None if not measured."""
    data = run.usage
    if data is None:
        return None
    drawing = figure(5.0, WIDE_WIDTH)
    speed, cores, memory = drawing.subplots(3, 1, sharex=True)
    speed.plot(data.wall, data.factor, color=BLACK, linewidth=1.4)
    speed.set_ylabel("real-time factor")
    speed.set_title("Speed, CPU and memory", loc="left")
    _draw_groups(cores, data, data.cores)
    cores.set_ylabel("CPU [cores]")
    cores.legend(loc="upper left", bbox_to_anchor=(1.0, 1.0))
    _draw_groups(memory, data, {k: v / 1000.0 for k, v in data.memory_mb.items()})
    memory.set_ylabel("memory [GB]")
    memory.set_xlabel("wall time since the start of the command [s]")
    for axes in (speed, cores, memory):
        axes.set_ylim(bottom=0.0)
    return drawing


def _draw_groups(axes: Axes, data: UsageSeries, values: dict[str, np.ndarray]) -> None:
    for index, (group, line) in enumerate(values.items()):
        color = GROUPS.get(group, BLACK)
        style = LINE_STYLES[index % len(LINE_STYLES)]
        axes.plot(data.wall, line, style, color=color, linewidth=1.4, label=group)
