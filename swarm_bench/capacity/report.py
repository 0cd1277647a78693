"""Results as a page with plots, as CSV and as JSON."""

from __future__ import annotations

import csv
import io
import json
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import Figure
from rich.console import Console
from rich.markup import escape
from rich.table import Table as RichTable

from swarm_bench.capacity.curve import Curve, Point
from swarm_bench.capacity.estimate import SizeEstimate
from swarm_bench.capacity.findings import comparison_sentences, knee_sentence, reason_sentence
from swarm_bench.runs.json_lines import rounded
from swarm_bench.runs.machine import machine_line
from swarm_common.model.errors import ConfigError
from swarm_report import charts, style
from swarm_report.document import Drawing, drawn
from swarm_report.page import page_html, plots_html, table_html, verdict_html
from swarm_report.tables import Table

ENDINGS = (".html", ".csv", ".json")


@dataclass(frozen=True, slots=True)
class Measure:
    """Figure that is drawn over the number of robots."""

    title: str  # with its unit
    caption: str
    of: Callable[[Point], SizeEstimate | None]
    is_share: bool = False


def _busiest(point: Point) -> SizeEstimate | None:
    return next(iter(point.station_use().values()), None)


MEASURES = {
    "throughput": Measure(
        "finished per hour", "Throughput after the warm-up, with 95 % intervals",
        lambda point: point.throughput,
    ),
    "lead_time": Measure(
        "lead time [s]", "Mean time that a goal or an order took, with 95 % intervals",
        lambda point: point.lead_time,
    ),
    "stood": Measure(
        "share of time", "How much of their time robots stood on their way",
        lambda point: point.stood, is_share=True,
    ),
    "station": Measure(
        "share of time", "How much of the time the busiest station was occupied or approached",
        _busiest, is_share=True,
    ),
}  # fmt: skip


def sentences(curves: Sequence[Curve], *, compare: bool) -> list[str]:
    """Return what the results say.

    Args:
        curves: Curves of all variants; a comparison has two.
        compare: Whether the second is compared with the first.
    """
    if compare and len(curves) == 2:
        return comparison_sentences(*curves)
    found = []
    for curve in curves:
        if curve.points:
            label = f"{curve.label}: " if curve.label else ""
            text = " ".join(filter(None, (knee_sentence(curve), reason_sentence(curve))))
            found.append(label + text)
    return found


def points_table(curves: Sequence[Curve]) -> Table:
    """Return a row per variant and size."""
    head = ["variant", "robots", "seeds", "per hour", "95 %", "lead time [s]", "95 %", "stood",
            "busiest station", "in use", "collisions", "deadlocks", "clearance [m]"]  # fmt: skip
    rows = [_row(curve.label, point) for curve in curves for point in curve.points]
    if not any(curve.label for curve in curves):
        return Table(head[1:], [row[1:] for row in rows])
    return Table(head, rows)


def _row(label: str, point: Point) -> list[str]:
    uses = point.station_use()
    name = next(iter(uses), "")
    lead = point.lead_time
    return [
        label, str(point.robots), str(len(point.runs)),
        f"{point.throughput.mean:.0f}", _interval(point.throughput),
        "–" if lead is None else f"{lead.mean:.1f}", "–" if lead is None else _interval(lead, 1),
        "–" if point.stood is None else f"{100 * point.stood.mean:.0f} %", name or "–",
        f"{100 * uses[name].mean:.0f} %" if name else "–", str(point.collisions),
        "–" if point.deadlocks is None else str(point.deadlocks),
        "–" if point.clearance is None else f"{point.clearance:.3f}",
    ]  # fmt: skip


def _interval(value: SizeEstimate, digits: int = 0) -> str:
    if value.freedom < 1:
        return "–"
    return f"[{value.low:.{digits}f}, {value.high:.{digits}f}]"


def print_curves(curves: Sequence[Curve], told: Sequence[str], console: Console) -> None:
    """Print a table, and what the results say."""
    points = points_table(curves)
    table = RichTable(box=None, header_style="bold")
    for column in points.head:
        table.add_column(escape(column), justify="right")
    for row in points.rows:
        table.add_row(*map(escape, row))
    console.print(table)
    for sentence in told:
        console.print(sentence, highlight=False, soft_wrap=True, markup=False)


def write_output(path: Path, curves: Sequence[Curve], told: Sequence[str], command: str) -> None:
    """Write the results; the ending of the file says how.

    Raises:
        ConfigError: If the file cannot be written.
    """
    writers = {".html": _html, ".csv": _csv, ".json": _json}
    text = writers[path.suffix](curves, told, command)
    try:
        path.write_text(text, encoding="utf-8")
    except OSError as cause:
        raise ConfigError(f"cannot write {path}: {cause.strerror}") from cause


def check_output(path: Path) -> None:
    """Check that the results can be written to a file.

    Raises:
        ConfigError: If its ending is unknown, or its folder is not there.
    """
    if path.suffix not in ENDINGS:
        raise ConfigError(
            f"--output is '{path}'; expected a file that ends in .html, .csv or .json"
        )
    if not path.parent.is_dir():
        raise ConfigError(f"--output is '{path}': there is no folder {path.parent}")


def _html(curves: Sequence[Curve], told: Sequence[str], command: str) -> str:
    table = points_table(curves)
    points = [point for curve in curves for point in curve.points]
    flaws = sum(point.collisions + (point.deadlocks or 0) for point in points)
    drawings = {
        name: Drawing(
            partial(_still, measure), partial(_chart, measure), lambda _: None, measure.caption
        )
        for name, measure in MEASURES.items()
    }
    is_known = all(point.deadlocks is not None for point in points)
    flawless = "No collision and no deadlock" if is_known else "No collision"
    headline = "Collisions or deadlocks occurred" if flaws else flawless
    body = [
        verdict_html("bad" if flaws else "good", headline, told),
        plots_html(drawn(drawings, curves)),
        table_html(table.head, table.rows),
    ]
    return page_html("How many robots", f"{command} · {machine_line()}", body)


def _known(measure: Measure, curve: Curve) -> list[tuple[int, SizeEstimate]]:
    found = [(point.robots, measure.of(point)) for point in curve.points]
    return [(robots, value) for robots, value in found if value is not None]


def _still(measure: Measure, curves: Sequence[Curve]) -> Figure | None:
    if not any(_known(measure, curve) for curve in curves):
        return None
    drawing, axes = style.plot("robots", measure.title, height=3.2)
    for number, curve in enumerate(curves):
        known = _known(measure, curve)
        ends = np.array([_ends(measure, value) for _, value in known]).reshape(-1, 2)
        axes.errorbar(
            [robots for robots, _ in known], [value.mean for _, value in known], ends.T,
            label=curve.label or None, capsize=2,
            color=style.CYCLE[number % len(style.CYCLE)], marker="o", markersize=3,
        )  # fmt: skip
        if measure is MEASURES["throughput"] and curve.knee is not None:
            axes.axvspan(curve.knee.low, curve.knee.high, alpha=0.12, color=style.GREY)
    axes.set_ylim(bottom=0.0)
    if any(curve.label for curve in curves):
        style.legend_below(axes)
    return drawing


def _chart(measure: Measure, curves: Sequence[Curve]) -> charts.Chart:
    data = []
    for number, curve in enumerate(curves):
        known = _known(measure, curve)
        data.append(
            charts.line(
                charts.text(curve.label or measure.title),
                [robots for robots, _ in known],
                [value.mean for _, value in known],
                mode="lines+markers",
                error_y={
                    "type": "data",
                    "symmetric": False,
                    "array": [_ends(measure, value)[1] for _, value in known],
                    "arrayminus": [_ends(measure, value)[0] for _, value in known],
                },
                line={"color": style.CYCLE[number % len(style.CYCLE)]},
                hovertemplate="%{x} robots: %{y:.3g} ± %{error_y.array:.2g}",
            )
        )
    layout = {
        "xaxis": charts.axis("robots"),
        "yaxis": charts.axis(
            measure.title, rangemode="tozero", **({"tickformat": ".0%"} if measure.is_share else {})
        ),
        "hovermode": "closest",
    }
    return {"data": data, "layout": layout}


def _ends(measure: Measure, value: SizeEstimate) -> tuple[float, float]:
    """Return how far the interval goes below and above the mean; nothing is less than 0."""
    if value.freedom < 1:
        return 0.0, 0.0
    most = 1.0 - value.mean if measure.is_share else math.inf
    return min(value.half_width, value.mean), min(value.half_width, most)


def _csv(curves: Sequence[Curve], told: Sequence[str], command: str) -> str:
    lines = [line for curve in curves for line in _records(curve)]
    output = io.StringIO()
    writer = csv.DictWriter(output, list(lines[0]) if lines else [], lineterminator="\n")
    writer.writeheader()
    writer.writerows(lines)
    return output.getvalue()


def _json(curves: Sequence[Curve], told: Sequence[str], command: str) -> str:
    data = {
        "schema": 1,
        "command": command,
        "machine": machine_line(),
        "sentences": list(told),
        "variants": [
            {
                "label": curve.label,
                "unit": curve.unit,
                "knee": None
                if curve.knee is None
                else {"robots": curve.knee.robots, "interval": [curve.knee.low, curve.knee.high]},
                "points": [rounded(record) for record in _records(curve)],
            }
            for curve in curves
        ],
    }
    return json.dumps(data, indent=1, allow_nan=False) + "\n"


def _records(curve: Curve) -> list[dict[str, Any]]:
    """Return the points of a curve as plain numbers."""
    records = []
    for point in curve.points:
        record: dict[str, Any] = {
            "variant": curve.label, "robots": point.robots, "seeds": len(point.runs),
        }  # fmt: skip
        for name, measure in MEASURES.items():
            value = measure.of(point)
            ends = (None, None) if value is None or value.freedom < 1 else (value.low, value.high)
            record[name] = None if value is None else value.mean
            record[f"{name}_low"], record[f"{name}_high"] = ends
        record["busiest_station"] = next(iter(point.station_use()), "")
        record["collisions"], record["deadlocks"] = point.collisions, point.deadlocks
        record["min_clearance"] = point.clearance
        records.append(record)
    return records
