"""The four figures of docs/study.md as SVG, from the lines alone.

Every colour stands out from white and from black paper alike, and methods differ in mark and dash,
so the figures can be read in light, in dark and in grey.
"""

from __future__ import annotations

import io
import math
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import matplotlib as mpl
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from swarm_bench.statistics import Interval
from swarm_bench.study.tables import CellRuns, KeptShare, loss_of, sizes

INK = "#767676"  # of texts and axes
Look = tuple[str, str, Any]  # colour, mark and dash
LOOKS: dict[str, Look] = {
    "ours": ("#0a7bc4", "o", "-"),
    "central-mapf": ("#c26a00", "s", "--"),
    "central-reservation": ("#1a8a64", "^", "-."),
    "central-with-fallback": ("#b0569a", "D", ":"),
    "orca": ("#8a7400", "v", (0, (3, 1, 1, 1, 1, 1))),
    "dwa": ("#8166c9", "X", (0, (1, 3))),
}
OTHER: Look = (INK, "*", "-")
SETTINGS = {
    **mpl.rcParamsDefault,
    "font.size": 9.0,
    "font.family": "sans-serif",
    "text.color": INK,
    "axes.labelcolor": INK,
    "axes.edgecolor": INK,
    "axes.titlesize": 9.0,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "xtick.color": INK,
    "ytick.color": INK,
    "legend.frameon": False,
    "lines.linewidth": 1.5,
    "lines.markersize": 5.0,
    "svg.fonttype": "none",
    "svg.hashsalt": "study",
    "backend": "agg",
}
ALT = {
    "throughput": "throughput by the number of robots, by world and method",
    "makespan": "time above the least possible, by cell and method",
    "cost": "time of a robot's decision, longest of 99 % of a centre's, and bytes sent, by robots",
    "loss": "throughput lost, by fault and method",
}


def drawn(found: Sequence[CellRuns], kept: Sequence[KeptShare]) -> dict[str, str]:
    """Return the figures as SVG, by name.

    Args:
        found: All cells and methods with lines.
        kept: Throughput that is kept in disturbed cells.
    """
    makers: Mapping[str, Callable[[], Figure]] = {
        "throughput": lambda: _throughput(found),
        "makespan": lambda: _makespan(found),
        "cost": lambda: _cost(found),
        "loss": lambda: _loss(kept),
    }
    with mpl.rc_context(SETTINGS):
        return {name: _svg(make(), ALT[name]) for name, make in makers.items()}


def _svg(figure: Figure, title: str) -> str:
    file = io.StringIO()
    about = {"Title": title, "Date": None}
    figure.savefig(file, format="svg", transparent=True, metadata=about)
    lines = (line.rstrip() for line in file.getvalue().splitlines())
    return "\n".join(lines) + "\n"


def _panels(count: int, width: float, height: float) -> tuple[Figure, list[Axes]]:
    figure = Figure(figsize=(width, height), layout="constrained")
    axes = figure.subplots(1, max(count, 1), squeeze=False)[0]
    return figure, list(axes)


def _legend(figure: Figure, axes: Sequence[Axes]) -> None:
    entries: dict[str, Any] = {}
    for each in axes:
        handles, labels = each.get_legend_handles_labels()
        entries |= dict(zip(labels, handles, strict=True))
    if entries:
        place: Any = "outside upper center"
        figure.legend(list(entries.values()), list(entries), loc=place, ncols=len(entries))
    else:
        axes[0].set_title("no lines")


def _curve(axes: Axes, method: str, points: Mapping[int, Interval]) -> None:
    color, mark, dash = LOOKS.get(method, OTHER)
    places = sorted(points)
    values = [points[each].estimate for each in places]
    arms = [_arms(points[each]) for each in places]
    axes.errorbar(
        places, values, yerr=list(zip(*arms, strict=True)), label=method, color=color, marker=mark,
        linestyle=dash, capsize=2.0,
    )  # fmt: skip


def _arms(interval: Interval) -> tuple[float, float]:
    if not interval.is_known:
        return 0.0, 0.0
    return interval.estimate - interval.low, interval.high - interval.estimate


def _throughput(found: Sequence[CellRuns]) -> Figure:
    worlds = sizes(found)
    figure, panels = _panels(len(worlds), 9.6, 2.9)
    for axes, (world, methods) in zip(panels, worlds.items(), strict=False):
        for method, groups in methods.items():
            _curve(axes, method, {size: group.value for size, group in groups.items()})
        axes.set_title(world)
        axes.set_xlabel("robots")
        axes.set_ylim(bottom=0.0)
    panels[0].set_ylabel("orders or goals per hour")
    _legend(figure, panels)
    return figure


def _rows(
    figure: Figure, axes: Axes, rows: Sequence[tuple[str, str, Interval]], label: str
) -> None:
    """Draw a row per cell with a mark per method.

    Args:
        rows: Name of the cell, method and value [%].
    """
    cells = list(dict.fromkeys(cell for cell, _, _ in rows))
    methods = list(dict.fromkeys(method for _, method, _ in rows))
    for rank, method in enumerate(methods):
        color, mark, _ = LOOKS.get(method, OTHER)
        own = [(cells.index(cell), value) for cell, each, value in rows if each == method]
        shift = 0.14 * (rank - 0.5 * (len(methods) - 1))
        arms = [_arms(value) for _, value in own]
        axes.errorbar(
            [value.estimate for _, value in own], [place + shift for place, _ in own],
            xerr=list(zip(*arms, strict=True)), label=method, color=color, marker=mark,
            linestyle="", capsize=2.0,
        )  # fmt: skip
    axes.set_yticks(range(len(cells)), cells)
    axes.invert_yaxis()
    axes.axvline(0.0, color=INK, linewidth=0.8)
    axes.set_xlabel(label)
    _legend(figure, [axes])


def _makespan(found: Sequence[CellRuns]) -> Figure:
    rows = [(g.cell.name, g.method, _scaled(gap)) for g in found if (gap := g.gap) is not None]
    figure, panels = _panels(1, 7.2, 1.4 + 0.55 * len({cell for cell, *_ in rows}))
    _rows(figure, panels[0], rows, "restricted mean time above the bound [%]")
    return figure


def _loss(kept: Sequence[KeptShare]) -> Figure:
    rows = [(row.cell.name, row.method, _scaled(loss_of(row.share))) for row in kept]
    figure, panels = _panels(1, 7.2, 1.4 + 0.55 * len({cell for cell, *_ in rows}))
    _rows(figure, panels[0], rows, "throughput against the undisturbed twin [%]")
    return figure


def _scaled(interval: Interval) -> Interval:
    return Interval(100.0 * interval.estimate, 100.0 * interval.low, 100.0 * interval.high)


COSTS: dict[str, Callable[[CellRuns], float | None]] = {
    "robot's decision [µs]": lambda group: group.mean("tick_us_median"),
    "centre's decision, 99 % [ms]": lambda group: group.mean("p99_decision_ms"),
    "bytes a robot and second": lambda group: group.mean("bytes_per_robot_second"),
}


def _cost(found: Sequence[CellRuns]) -> Figure:
    """Draw the costs in the world with most sizes."""
    figure, panels = _panels(len(COSTS), 9.6, 2.9)
    worlds = sizes(found)
    methods = max(worlds.values(), key=_most_sizes, default={})
    for axes, (label, cost) in zip(panels, COSTS.items(), strict=True):
        for method, groups in methods.items():
            values = {size: cost(group) for size, group in groups.items()}
            known = {size: Interval(value) for size, value in values.items() if value is not None}
            if known and not all(math.isclose(each.estimate, 0.0) for each in known.values()):
                _curve(axes, method, known)
        axes.set_title(label)
        axes.set_xlabel("robots")
        axes.set_ylim(bottom=0.0)
    _legend(figure, panels)
    return figure


def _most_sizes(methods: Mapping[str, Mapping[int, CellRuns]]) -> int:
    return max(map(len, methods.values()))
