"""Results as a page with plots, as CSV and as JSON."""

from __future__ import annotations

import csv
import io
import json
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Any

from rich.console import Console

from swarm_bench.capacity.curve import Curve, Point
from swarm_bench.capacity.findings import (
    comparison_sentences,
    demand_sentence,
    knee_sentence,
    reason_sentence,
)
from swarm_bench.runs.origin import machine_line
from swarm_bench.statistics import Interval
from swarm_bench.tables import BenchTable
from swarm_common.model.errors import ConfigError
from swarm_report import charts, style
from swarm_report.document import Drawing, drawn
from swarm_report.page import page_html, plots_html, verdict_html
from swarm_run.record.figures import rounded

ENDINGS = (".html", ".csv", ".json")


@dataclass(frozen=True, slots=True)
class Measure:
    """Figure that is drawn over the number of robots."""

    title: str  # with its unit
    caption: str
    of: Callable[[Point], Interval | None]
    is_share: bool = False

    def at(self, point: Point) -> Interval | None:
        """Return the figure; its interval within what is possible, none where all runs agree."""
        value = self.of(point)
        if value is None or not value.half_width or not value.is_known:
            return value and Interval(value.estimate)
        most = 1.0 if self.is_share else math.inf
        return replace(value, low=max(0.0, value.low), high=min(most, value.high))


MEASURES = {
    "throughput": Measure(
        "finished per hour",
        "Throughput after the warm-up, with 95 % intervals",
        lambda point: point.throughput,
    ),
    "lead_time": Measure(
        "lead time [s]",
        "Mean time that a goal or an order took, with 95 % intervals",
        lambda point: point.lead_time,
    ),
    "stood": Measure(
        "share of time",
        "How much of their time robots stood on their way",
        lambda point: point.stood,
        is_share=True,
    ),
    "station": Measure(
        "share of time",
        "How much of the time the busiest station was occupied or approached",
        lambda point: next(iter(point.station_use().values()), None),
        is_share=True,
    ),
}


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
            parts = (knee_sentence(curve), reason_sentence(curve), demand_sentence(curve))
            text = " ".join(filter(None, parts))
            found.append(label + text)
    return found


def _text(value: Interval | None, form: str) -> str:
    return "–" if value is None else form.format(value.estimate)


def _use(point: Point) -> tuple[str, Interval | None]:
    return next(iter(point.station_use().items()), ("–", None))


def _ends(name: str, point: Point, form: str) -> str:
    """Return the interval of a measure; a dash where there is none."""
    value = MEASURES[name].at(point)
    return "–" if value is None else value.ends(form)


def _demand(point: Point) -> tuple[str, str]:
    """Return the orders that were open before and after, and whether the demand is met."""
    one = point.demand
    if one is None:
        return "–", "–"
    return f"{one.before:.0f} to {one.after:.0f}", "yes" if one.is_met else "no"


COLUMNS: dict[str, Callable[[tuple[str, Point]], str]] = {
    "variant": lambda row: row[0],
    "robots": lambda row: str(row[1].robots),
    "seeds": lambda row: str(len(row[1].runs)),
    "per hour": lambda row: _text(row[1].throughput, "{:.0f}"),
    "95 %": lambda row: _ends("throughput", row[1], "{:.0f}"),
    "lead time [s]": lambda row: _text(row[1].lead_time, "{:.1f}"),
    "95 % ": lambda row: _ends("lead_time", row[1], "{:.1f}"),
    "backlog": lambda row: _demand(row[1])[0],
    "demand met": lambda row: _demand(row[1])[1],
    "stood": lambda row: _text(row[1].stood, "{:.0%}").replace("%", " %"),
    "busiest station": lambda row: _use(row[1])[0],
    "in use": lambda row: _text(_use(row[1])[1], "{:.0%}").replace("%", " %"),
    "collisions": lambda row: str(row[1].collisions),
    "deadlocks": lambda row: "–" if row[1].deadlocks is None else str(row[1].deadlocks),
    "clearance [m]": lambda row: "–" if row[1].clearance is None else f"{row[1].clearance:.3f}",
}


def points_table(curves: Sequence[Curve]) -> BenchTable:
    """Return a row per variant and size."""
    rows = [(curve.label, point) for curve in curves for point in curve.points]
    has_label = any(label for label, _ in rows)
    columns = {name: cell for name, cell in COLUMNS.items() if has_label or name != "variant"}
    return BenchTable.of(columns, rows, texts=("variant",))


def print_curves(curves: Sequence[Curve], told: Sequence[str], console: Console) -> None:
    """Print a table, and what the results say."""
    console.print(points_table(curves).rich())
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
    points = [point for curve in curves for point in curve.points]
    flaws = sum(point.collisions + (point.deadlocks or 0) for point in points)
    drawings = {
        name: Drawing(partial(_chart, measure), lambda _: None, measure.caption)
        for name, measure in MEASURES.items()
    }
    is_known = all(point.deadlocks is not None for point in points)
    flawless = "No collision and no deadlock" if is_known else "No collision"
    headline = "Collisions or deadlocks occurred" if flaws else flawless
    body = [
        verdict_html("bad" if flaws else "good", headline, told),
        plots_html(drawn(drawings, curves)),
        points_table(curves).html(),
    ]
    return page_html("How many robots", f"{command} · {machine_line()}", body)


def _known(measure: Measure, curve: Curve) -> list[tuple[int, Interval]]:
    found = [(point.robots, measure.at(point)) for point in curve.points]
    return [(robots, value) for robots, value in found if value is not None]


def _chart(measure: Measure, curves: Sequence[Curve]) -> charts.Chart | None:
    if not any(_known(measure, curve) for curve in curves):
        return None
    data = []
    for number, curve in enumerate(curves):
        known = _known(measure, curve)
        data.append(
            charts.line(
                charts.text(curve.label or measure.title),
                [robots for robots, _ in known],
                [value.estimate for _, value in known],
                mode="lines+markers",
                error_y={
                    "type": "data",
                    "symmetric": False,
                    "array": [v.high - v.estimate if v.is_known else 0.0 for _, v in known],
                    "arrayminus": [v.estimate - v.low if v.is_known else 0.0 for _, v in known],
                },
                line={"color": style.CYCLE[number % len(style.CYCLE)]},
                hovertemplate="%{x} robots: %{y:.3g} ± %{error_y.array:.2g}",
            )
        )
    layout: charts.Chart = {
        "xaxis": charts.axis("robots"),
        "yaxis": charts.axis(
            measure.title, rangemode="tozero", **({"tickformat": ".0%"} if measure.is_share else {})
        ),
        "hovermode": "closest",
    }
    knees = [curve.knee for curve in curves if curve.knee is not None]
    layout["shapes"] = [
        {"type": "rect", "x0": knee.low, "x1": knee.high, "yref": "paper", "y0": 0, "y1": 1,
         "fillcolor": style.GREY, "opacity": 0.12, "line": {"width": 0}}
        for knee in knees if measure is MEASURES["throughput"]
    ]  # fmt: skip
    return {"data": data, "layout": layout}


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
            "variant": curve.label,
            "robots": point.robots,
            "seeds": len(point.runs),
        }
        for name, measure in MEASURES.items():
            value = measure.at(point)
            ends = (None, None) if value is None or not value.is_known else (value.low, value.high)
            record[name] = None if value is None else value.estimate
            record[f"{name}_low"], record[f"{name}_high"] = ends
        demand = point.demand
        record["backlog_before"] = None if demand is None else demand.before
        record["backlog"] = None if demand is None else demand.after
        record["demand_met"] = None if demand is None else demand.is_met
        record["busiest_station"] = next(iter(point.station_use()), "")
        record["collisions"], record["deadlocks"] = point.collisions, point.deadlocks
        record["min_clearance"] = point.clearance
        records.append(record)
    return records
