"""report.html of one run, and its plots as files."""

from __future__ import annotations

import io
import shutil
from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Generic, TypeVar

from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from swarm_common.model.errors import ConfigError
from swarm_common.model.run_words import OPEN, makespan, robots_text
from swarm_report import blockers, charts, style, tables
from swarm_report.bottleneck import lost_words
from swarm_report.headline import headline, stops
from swarm_report.judgement import breach_lines, judge
from swarm_report.measures import IDLE, LOST, lost_spans, mission_spans, shares_of
from swarm_report.orders import order_sections
from swarm_report.page import (
    Plot,
    cards_html,
    escape,
    headline_html,
    page_html,
    plots_html,
    table_html,
    verdict_html,
)
from swarm_report.run import RunData, mission_goals
from swarm_report.still import still
from swarm_report.tables import Table, percent

Data = TypeVar("Data")  # a run, or several
PAGE, PLOTS = "report.html", "plots"
MAIN = (
    "of the mission's goals reached", "collisions robot-robot, robot-world", "smallest clearance",
    "makespan", "goals per minute",
)  # fmt: skip
DPI = 150  # of the PNG files
PIXELS_DPI = 130  # of the pixel images within an SVG


@dataclass(frozen=True, slots=True)
class Drawing(Generic[Data]):
    """How a plot of a page comes about."""

    chart: Callable[[Data], charts.Chart | None]  # the plot; None if there are no data for it
    table: Callable[[Data], Table | None]  # its figures
    caption: str
    is_wide: bool = False  # whether it takes the whole width


DRAWINGS: dict[str, Drawing[RunData]] = {
    "timeline": Drawing(
        charts.timeline, tables.timeline,
        "What each robot did when; crosses are missed goals", is_wide=True,
    ),
    "waiting": Drawing(
        charts.waiting, tables.waiting,
        "Where robots lost time: they held, waited, made way or recovered",
    ),
    "blockers": Drawing(
        blockers.chart, blockers.table,
        "Who stopped for whom; the wider an arrow, the longer",
    ),
    "trajectories": Drawing(
        charts.trajectories, tables.trajectories,
        "Where the robots drove, by ground truth",
    ),
    "density": Drawing(
        charts.density, tables.density,
        "Where the robots were, in robot-seconds per area",
    ),
    "goals": Drawing(
        charts.goals, tables.goals, "Goals reached over simulated time"
    ),
    "throughput": Drawing(
        charts.flow, tables.flow, "Goals reached per minute"
    ),
    "stations": Drawing(
        charts.stations, tables.stations,
        "How much the stations were used and waited for",
    ),
    "states": Drawing(
        charts.states, tables.states,
        "How many of the robots were in which state",
    ),
    "clearance": Drawing(
        charts.clearance, tables.clearance,
        "Distances of hulls to each other and to obstacles",
    ),
    "usage": Drawing(
        charts.usage, tables.usage,
        "CPU and memory; memory that processes share counts once", is_wide=True,
    ),
}  # fmt: skip


def write_document(folder: Path) -> Path:
    """Draw the report of a run into its folder; return the page.

    Raises:
        ConfigError: If the folder is not that of a run, or cannot be written.
    """
    run = RunData(folder)
    try:
        page = folder / PAGE
        page.write_text(_document(run, _draw(run, folder / PLOTS)), encoding="utf-8")
    except OSError as cause:
        raise ConfigError(f"cannot write the report to {folder}: {cause.strerror}") from cause
    return page


def document_html(run: RunData) -> str:
    """Return the page of a run; nothing is written."""
    return _document(run, _draw(run, None))


def _draw(run: RunData, folder: Path | None) -> list[Plot]:
    """Draw the plots of a run; also as SVG and PNG, if there is a folder."""
    if folder is not None:
        shutil.rmtree(folder, ignore_errors=True)
    if run.series is None and not run.spans:
        return []
    if folder is not None:
        folder.mkdir(parents=True)
    return drawn(DRAWINGS, run, folder, None if run.grid is None else charts.map_image(run.grid))


def drawn(
    drawings: Mapping[str, Drawing[Data]],
    data: Data,
    folder: Path | None = None,
    map_image: charts.Chart | None = None,
) -> list[Plot]:
    """Return the plots that there are data for; also write SVG and PNG, if there is a folder."""
    plots = []
    with style.settings():
        for name, drawing in drawings.items():
            if (chart := drawing.chart(data)) is not None:
                picture = still(chart, map_image, is_wide=drawing.is_wide)
                svg = _save(picture, None if folder is None else folder / name)
                table = drawing.table(data)
                plots.append(Plot(name, drawing.caption, svg, drawing.is_wide, chart, table))
    return plots


def _save(drawing: Figure, path: Path | None) -> bytes:
    """Return a figure as SVG; write it as .svg and .png, if there is a path."""
    buffer = io.BytesIO()
    drawing.savefig(buffer, format="svg", dpi=PIXELS_DPI, metadata={"Date": None})
    if path is not None:
        path.with_suffix(".svg").write_bytes(buffer.getvalue())
        drawing.set_layout_engine("none")  # all is in its place already; savefig would draw twice
        drawing.set_dpi(DPI)
        canvas: Any = FigureCanvasAgg(drawing)  # print_png has no types
        canvas.print_png(path.with_suffix(".png"))
    return buffer.getvalue()


def _document(run: RunData, plots: list[Plot]) -> str:
    verdict, report = judge(run), run.report
    world = Path(str(report.get("world") or run.config.get("world", "?")))
    robots = robots_text(report) if report else f"{len(run.robots)} robots"
    title = f"{robots} in {world.parent.name if world.suffix else world.name}"
    subtitle = (
        f"mission {report.get('mission') or 'none'}, robot {report.get('robot', '?')},"
        f" seed {report.get('seed', run.config.get('seed', '?'))}, run {run.name}"
    )
    damaged = [
        f"{name} is damaged: {count} line{'' if count == 1 else 's'} left out"
        for name, count in run.left_out.items()  # known once all has been drawn
    ]
    body = [verdict_html(verdict.kind, verdict.headline, (*verdict.lines, *damaged))]
    if parts := headline(run):
        body.append(headline_html(parts, run.folder))
    if words := lost_words(run):
        body.append(f'<p class="bottleneck">{escape(words)}</p>')
    figures = merits(report)
    main = {name: figures.pop(name) for name in MAIN if name in figures}
    body.append(cards_html(main | shares(run)))
    if figures:
        body.append(
            '<details class="more"><summary>More figures</summary>'
            f"{table_html(['', ''], list(figures.items()))}</details>"
        )
    body.append(plots_html(plots, None if run.grid is None else charts.map_image(run.grid)))
    if report.get("orders"):
        body += order_sections(report["orders"])
    lines = breach_lines(report) if report else []
    if lines:
        body += ["<h2>Breaches</h2>", table_html(["what"], [[line] for line in lines])]
    if report.get("robots"):
        body += ["<h2>Robots</h2>", _robots(run, report.get("broken") or ())]
    if report:
        body.append(
            f"<footer>trajectory_sha256 {report.get('trajectory_sha256') or 'unknown'};"
            " fields are explained in docs/report.md</footer>"
        )
    return page_html(title, subtitle, body)


def shares(run: RunData) -> dict[str, str]:
    """Return what the robots did with their time; the shares add up to all of it."""
    known = shares_of(mission_spans(run))
    if not known:
        return {}
    lost = sum(known.get(state, 0.0) for state in LOST)
    others = 1.0 - lost - sum(known.get(state, 0.0) for state in ("driving", IDLE))
    found = {
        "of the robots' time driving": known.get("driving", 0.0),
        "of it lost (holding, waiting, making way, recovering)": lost,
        "of it without a goal": known.get(IDLE, 0.0),
        "of it served, charging or not active": others,
    }
    return {name: percent(share) for name, share in found.items() if share > 5e-4}


def merits(report: Mapping[str, Any]) -> dict[str, str]:
    """Return the figures of merit of a report, with units."""
    if not report:
        return {}
    goals, crashes, cpu = report["goals"], report["collisions"], report["cpu_ms_per_robot_second"]
    duration = report.get("goal_duration") or {}
    total = mission_goals(report)
    return {
        "goals reached of sent": f"{goals['reached']} / {goals['sent']}",
        "of the mission's goals reached": percent(goals["reached"] / total if total else None),
        "goals missed, pending": f"{goals.get('failed', 0)}, {goals.get('pending', 0)}",
        "collisions robot-robot, robot-world": (
            f"{number(crashes['robot_robot'])}, {number(crashes['robot_world'])}"
        ),
        "near misses": number(report.get("near_misses")),
        **_zones(report.get("zones") or {}),
        "smallest clearance": number(report.get("min_clearance"), "m"),
        "makespan": OPEN if goals.get("pending") else number(makespan(report), "s"),
        "goals per minute": number(report.get("throughput_per_minute")),
        "median time of a goal": number(duration.get("median"), "s"),
        "longest time of a goal": number(duration.get("worst"), "s"),
        "real-time factor": number(report.get("real_time_factor")),
        "CPU per robot and second": number(cpu.get("total"), "ms"),
    }


def _zones(zones: Mapping[str, Any]) -> dict[str, str]:
    """Return the counts of a world with keepout or speed zones."""
    texts = {
        "entries into keepout zones": ("keepout_entries", "keepout_time"),
        "speeds above a limit": ("speed_violations", "speed_violation_time"),
    }
    return {
        text: f"{number(zones.get(count))} ({number(zones.get(time), 's')})"
        for text, (count, time) in texts.items()
        if zones
    }


def number(value: float | None, unit: str = "") -> str:
    """Return a number with its unit; a dash for an unknown one."""
    if value is None:
        return "–"
    digits = ".0f" if abs(value) >= 1000.0 else ".4g"
    text = f"{value:{digits}}" if isinstance(value, float) else str(value)
    return f"{text} {unit}".strip()


LOST_TIME, LONGEST = "lost", "longest_stop"  # out of the time series, as in the headline
# Of a robot: key -> heading and decimals
COLUMNS = {
    "goals_reached": ("reached", 0),
    "goals_failed": ("missed", 0),
    LOST_TIME: ("lost [s]", 1),
    LONGEST: ("longest stop [s]", 1),
    "worst_goal_duration": ("longest goal [s]", 1),
    "pushes": ("pushes", 0),
    "replans": ("replans", 0),
    "recoveries": ("recoveries", 0),
    "distance": ("distance [m]", 1),
    "collisions": ("collisions", 0),
    "near_misses": ("near misses", 0),
    "min_clearance": ("clearance [m]", 3),
}


def _robots(run: RunData, broken: Collection[str]) -> str:
    lost: dict[str, dict[str, float]] = {}
    for index in {span.robot for span in run.spans}:
        lost[run.robots[index]] = {LOST_TIME: 0.0, LONGEST: 0.0}
    for span in lost_spans(run):
        lost[run.robots[span.robot]][LOST_TIME] += span.length
    for stop in stops(run):
        longest = lost[run.robots[stop.robot]]
        longest[LONGEST] = max(longest[LONGEST], stop.length)
    rows = []
    for name, measured in run.report["robots"].items():
        values = {**measured, **lost.get(name, {})}
        row = [f"{name} (broken)" if name in broken else name]
        for key, (_, digits) in COLUMNS.items():
            value = values.get(key)
            row.append("–" if value is None else f"{value:.{digits}f}")
        rows.append(row)
    return table_html(["robot", *(heading for heading, _ in COLUMNS.values())], rows)
