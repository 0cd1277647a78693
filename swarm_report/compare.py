"""Several runs side by side: a table, and plots that lay them over each other."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from swarm_common.model.errors import ConfigError
from swarm_common.model.records import FloatArray
from swarm_common.model.run_words import makespan
from swarm_report.charts import DASHES, INK, Chart, axis, line, packed, text
from swarm_report.document import Drawing, drawn, number
from swarm_report.inputs import SEED, differences
from swarm_report.judgement import judge
from swarm_report.measures import lost_time
from swarm_report.page import escape, page_html, plots_html, table_html
from swarm_report.run import RunData, mission_goals
from swarm_report.style import BLACK, CYCLE
from swarm_report.tables import Table

BIN = 0.02  # [m] of the clearance curve
FACTOR = 2.0  # from which a change is told as a factor
BARS = {  # of the report -> what the panel is called
    "makespan": "makespan [s]",
    "throughput_per_minute": "goals per minute",
    "lost.seconds": "lost, all robots [s]",
    "longest_stop.duration": "longest stop of a robot [s]",
    "real_time_factor": "real-time factor",
    "min_clearance": "smallest clearance [m]",
}


@dataclass(frozen=True, slots=True)
class Comparison:
    """A table of several runs; `marks` are better or worse, by row and column."""

    head: list[str]
    rows: list[list[str]]
    marks: dict[tuple[int, int], str]


@dataclass(frozen=True, slots=True)
class Merit:
    """A figure of a run that is compared."""

    name: str  # for people
    path: tuple[str, ...]  # keys within the report
    unit: str = ""  # of the value
    better: int = -1  # 1 if more is better, -1 if less is, 0 if neither

    def read(self, run: RunData) -> float | None:
        """Return its value; None if it was not measured."""
        if self.path == ("makespan",):
            return makespan(run.report)
        value: Any = run.report
        for key in self.path:
            value = value.get(key) if isinstance(value, Mapping) else None
        return value if isinstance(value, int | float) else None

    def delta(self, base: float | None, value: float | None) -> str:
        """Return the difference from the first run as text, with its percentage."""
        if base is None or value is None:
            return ""
        if value == base:
            return " (=)"
        change = value - base
        share = f", {100.0 * change / abs(base):+.1f} %" if base else ""
        return f" ({'+' if change > 0 else '−'}{number(abs(change))}{share})".replace(", -", ", −")

    def judged(self, base: float | None, value: float | None) -> str:
        """Return better or worse; empty if neither, or unknown."""
        if base is None or value is None or value == base or not self.better:
            return ""
        return "better" if (value > base) == (self.better > 0) else "worse"


FIGURES = (
    Merit("robots", ("swarm_size",), better=0),
    Merit("goals sent", ("goals", "sent"), better=0),
    Merit("goals reached", ("goals", "reached"), better=1),
    Merit("goals missed", ("goals", "failed")),
    Merit("goals pending", ("goals", "pending")),
    Merit("collisions robot-robot", ("collisions", "robot_robot")),
    Merit("collisions robot-world", ("collisions", "robot_world")),
    Merit("near misses", ("near_misses",)),
    Merit("smallest clearance", ("min_clearance",), "m", better=1),
    Merit("makespan", ("makespan",), "s"),
    Merit("goals per minute", ("throughput_per_minute",), better=1),
    Merit("median time of a goal", ("goal_duration", "median"), "s"),
    Merit("longest time of a goal", ("goal_duration", "worst"), "s"),
    Merit("longest / median", ("fairness",)),
    Merit("time lost", ("lost", "seconds"), "s"),
    Merit("longest stop of a robot", ("longest_stop", "duration"), "s"),
    Merit("pushes", ("pushes",), better=0),
    Merit("replans", ("replans",), better=0),
    Merit("recoveries", ("recoveries",)),
    Merit("real-time factor", ("real_time_factor",), better=1),
    Merit("CPU per robot and second", ("cpu_ms_per_robot_second", "total"), "ms"),
    Merit("memory of the navigators", ("memory_mb", "navigators"), "MB"),
    Merit("restarts", ("restarts",)),
)


def labels(runs: Sequence[RunData]) -> list[str]:
    """Return a short name per run, told apart by number where folders share theirs."""
    names = [run.name for run in runs]
    return [
        name if names.count(name) == 1 else f"{name} ({place})"
        for place, name in enumerate(names, 1)
    ]


def comparison(runs: Sequence[RunData]) -> Comparison:
    """Return a table with a column per run, and differences from the first run."""
    names = labels(runs)
    rows: list[list[str]] = [["verdict", *(judge(run).headline for run in runs)]]
    marks: dict[tuple[int, int], str] = {}
    for merit in FIGURES:
        values = [merit.read(run) for run in runs]
        if all(value is None for value in values):
            continue
        row = [merit.name, number(values[0], merit.unit)]
        for column, value in enumerate(values[1:], 2):
            row.append(number(value, merit.unit) + merit.delta(values[0], value))
            mark = merit.judged(values[0], value)
            if mark:
                marks[len(rows), column] = mark
        rows.append(row)
    hashes = [str(run.report.get("trajectory_sha256") or "–")[:12] for run in runs]
    rows.append(["trajectories (sha256)", *hashes])
    return Comparison(["", *names], rows, marks)


def sentences(runs: Sequence[RunData]) -> list[str]:
    """Return a sentence for each run after the first: what it has more or less of than that."""
    base = runs[0]
    found = []
    for label, run in list(zip(labels(runs), runs, strict=True))[1:]:
        size = run.report.get("swarm_size")
        who = label if size is None else f"{label} ({size} robots)"
        lost = lost_time(base), lost_time(run)
        waits = None if None in lost else tuple(one.share for one in lost if one is not None)
        parts = [
            _change(
                "goals per minute", *(_merit(one, "throughput_per_minute") for one in (base, run))
            ),
            _change("makespan", *(_merit(one, "makespan") for one in (base, run))),
            _change("share of time lost", *waits) if waits else "",
            _crashes(base, run),
        ]
        found.append(f"{who}: {', '.join(filter(None, parts)) or 'no figure to compare'}.")
    return found


def _change(name: str, base: float | None, value: float | None) -> str:
    """Return by how much a figure differs; from a factor of two on, how many times it is."""
    if not base or value is None:
        return ""
    share = value / base
    if share >= FACTOR:
        return f"{name} {share:.1f} times as large"
    change = round(100.0 * (share - 1.0))
    return f"{name} equal" if not change else f"{change:+d} % {name}".replace("-", "−")


def _crashes(base: RunData, run: RunData) -> str:
    counts = [
        sum(value or 0 for value in one.report.get("collisions", {}).values())
        for one in (base, run)
    ]
    return "" if counts[0] == counts[1] else f"{counts[1]} collisions instead of {counts[0]}"


def what_differs(runs: Sequence[RunData]) -> str:
    """Return in words what differed in the input, and what that says about the results."""
    unequal, equal = differences(runs)
    known = [str(run.report.get("trajectory_sha256") or "") for run in runs]
    same = f"{equal} other inputs are equal." if equal else ""
    if not unequal:
        words = f"All {equal} inputs that are known are equal"
        if all(known) and len(set(known)) == 1:
            return f"{words}, and so are the trajectories, bit for bit."
        return f"{words}; the trajectories are not, or not known."
    if [row[0] for row in unequal] == [SEED]:
        return f"Only the seed differs: the deltas are what chance makes of it. {same}"
    return f"{len(unequal)} input{'s differ' if len(unequal) > 1 else ' differs'}. {same}"


def write_comparison(runs: Sequence[RunData], page: Path) -> None:
    """Write a page that compares runs, and its plots beside it."""
    folder = page.with_name(f"{page.stem}_plots")
    try:
        folder.mkdir(parents=True, exist_ok=True)
        page.write_text(comparison_html(runs, folder), encoding="utf-8")
    except OSError as cause:
        raise ConfigError(f"cannot write {page}: {cause.strerror}; choose another -o") from cause


def comparison_html(runs: Sequence[RunData], folder: Path | None = None) -> str:
    """Return the page that compares runs; plots are also written to `folder`, if there is one."""
    found = comparison(runs)
    unequal, _ = differences(runs)
    body = [
        *(f'<p class="headline">{escape(sentence)}</p>' for sentence in sentences(runs)),
        "<h2>Results</h2>",
        f'<p class="note">In brackets: the difference from {escape(found.head[1])}.'
        " Blue is better, orange is worse, whatever the reason.</p>",
        table_html(found.head, found.rows, found.marks),
        "<h2>Plots</h2>",
        plots_html(drawn(DRAWINGS, runs, folder)),
        f"<h2>Input</h2><p>{escape(what_differs(runs))}</p>",
        table_html(found.head, unequal) if unequal else "",
    ]
    return page_html(f"{len(runs)} runs compared", ", ".join(labels(runs)), body)


def _goal_shares(run: RunData) -> tuple[FloatArray, FloatArray]:
    """Return times [s] and the share [%] of the mission's goals that were reached by then."""
    times = [event.time for event in run.goals if event.outcome == "reached"]
    total = mission_goals(run.report)
    share = 100.0 * np.append(np.arange(len(times) + 1), len(times)) / max(total, len(times), 1)
    return np.array([0.0, *times, run.end]), share


def _goals(runs: Sequence[RunData]) -> Chart:
    data = [
        _line(index, label, _goal_shares(run), "%{y:.1f} % after %{x:.1f} s", shape="hv")
        for index, (run, label) in enumerate(zip(runs, labels(runs), strict=True))
    ]
    layout = {
        "xaxis": axis("simulated time [s]", rangemode="tozero"),
        "yaxis": axis("goals reached [% of the mission]", range=[0, 102]),
        "hovermode": "closest",
    }
    return {"data": data, "layout": layout}


def _goals_table(runs: Sequence[RunData]) -> Table:
    """Return when each share of the goals was reached."""
    curves = [_goal_shares(run) for run in runs]
    rows = []
    for share in range(10, 101, 10):
        reached = [np.flatnonzero(shares >= share - 1e-9) for _, shares in curves]
        cells = [
            f"{times[found[0]]:.1f}" if len(found) else "–"
            for (times, _), found in zip(curves, reached, strict=True)
        ]
        rows.append([f"{share} %", *cells])
    return Table(["of the mission's goals, at [s]", *labels(runs)], rows)


def _clearance_table(runs: Sequence[RunData]) -> Table:
    """Return the share of robot-seconds nearer than a distance."""
    curves = [_nearness(run) for run in runs]
    rows = []
    for edge in np.arange(0.04, 0.5, 0.04):  # edges of the curves' bins
        shares = ["–" if curve is None else f"{np.interp(edge, *curve):.2f} %" for curve in curves]
        rows.append([f"{edge:.2f} m", *shares])
    return Table(["nearer than", *labels(runs)], rows, "Of all robot-seconds.")


def _merits_table(runs: Sequence[RunData]) -> Table:
    rows = [[title, *(number(_merit(run, key)) for run in runs)] for key, title in BARS.items()]
    return Table(["", *labels(runs)], rows)


def _nearness(run: RunData) -> tuple[FloatArray, FloatArray] | None:
    """Return distances [m] and the share [%] of robot-seconds nearer than that to anything."""
    series = run.series
    if series is None:
        return None
    nearest = np.minimum(series.to_robot, series.to_world).ravel()
    nearest = nearest[np.isfinite(nearest)]
    edges = np.arange(0.0, series.near, BIN)
    return edges, 100.0 * np.searchsorted(np.sort(nearest), edges) / max(nearest.size, 1)


def _clearance(runs: Sequence[RunData]) -> Chart:
    data = [
        _line(index, label, curve, "%{y:.2f} % nearer than %{x:.2f} m")
        for index, (run, label) in enumerate(zip(runs, labels(runs), strict=True))
        if (curve := _nearness(run)) is not None
    ]
    layout = {
        "xaxis": axis("distance to the nearest robot or obstacle [m]", rangemode="tozero"),
        "yaxis": axis("robot-seconds nearer [%]", rangemode="tozero"),
        "hovermode": "closest",
    }
    return {"data": data, "layout": layout}


def _line(
    index: int, label: str, curve: tuple[FloatArray, FloatArray], says: str, **look: str
) -> Chart:
    x, y = map(packed, curve)
    return line(text(label), x, y, line=_look(index) | look, hovertemplate=says)


def _look(index: int) -> dict[str, Any]:
    color = CYCLE[index % len(CYCLE)]
    dash = DASHES[(index // len(CYCLE) + index) % len(DASHES)]
    return {"color": INK if color == BLACK else color, "dash": dash, "width": 2}


def _merits(runs: Sequence[RunData]) -> Chart:
    names = [text(name) for name in labels(runs)]
    colors = [_look(index)["color"] for index in range(len(runs))]
    layout: Chart = {
        "grid": {"rows": 2, "columns": 3, "pattern": "independent", "ygap": 0.5, "xgap": 0.12},
        "showlegend": False,
        "hovermode": "closest",
        "height": 200 + 2 * max(80, 30 * len(runs)),
    }
    data = []
    for place, (key, title) in enumerate(BARS.items(), 1):
        panel = "" if place == 1 else str(place)
        data.append(
            {
                "type": "bar", "orientation": "h",
                "y": names, "x": [_merit(run, key) for run in runs],
                "text": [number(_merit(run, key)) for run in runs], "textposition": "none",
                "xaxis": f"x{panel}", "yaxis": f"y{panel}", "marker": {"color": colors},
                "hovertemplate": f"%{{y}}<br>{title}: %{{x:.4g}}<extra></extra>",
            }
        )  # fmt: skip
        layout[f"xaxis{panel}"] = axis(title, rangemode="tozero")
        layout[f"yaxis{panel}"] = axis(
            "", autorange="reversed", automargin=True, showticklabels=place in (1, 4)
        )
    return {"data": data, "layout": layout}


def _merit(run: RunData, key: str) -> float | None:
    return Merit(key, tuple(key.split("."))).read(run)


DRAWINGS: dict[str, Drawing[Sequence[RunData]]] = {
    "goals": Drawing(
        _goals, _goals_table, "Goals reached over simulated time, as a share of the mission"
    ),
    "clearance": Drawing(
        _clearance, _clearance_table, "Share of robot-seconds nearer than a distance to anything"
    ),
    "merits": Drawing(
        _merits,
        _merits_table,
        "Figures of merit; a dash stands for what was not measured",
        is_wide=True,
    ),
}
