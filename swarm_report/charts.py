"""Plots of a run: what plotly.js is given, as data; nothing of plotly runs here.

`still.py` draws the same for paper. Colours named "ink" become black on white paper and light in
the dark (page.js).
"""

from __future__ import annotations

import base64
import html
import io
from collections.abc import Mapping, Sequence
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.colors import to_hex
from numpy.typing import NDArray
from PIL import Image

from swarm_common.model.grid import FREE, OCCUPIED, Grid
from swarm_common.model.records import Pose
from swarm_common.model.zones import keepout_area, speed_area, triangles
from swarm_report import maps
from swarm_report.measures import AT_STATION, shares_over_time, station_use, throughput
from swarm_report.run import GoalEvent, RunData, Series, Span, mission_goals
from swarm_report.style import (
    BLUE,
    CYCLE,
    GROUPS,
    LABELS,
    ORANGE,
    SKY,
    STATES,
    VERMILLION,
    YELLOW,
    extent,
)

INK = "ink"
NEAR_MISS = 0.03  # [m] closer without contact is a near miss
BIN = 0.02  # [m] of the clearance histogram
MOST_POINTS = 60_000  # of all trajectories; browsers draw them as SVG
MAP_WIDTH = 450  # [px] of a map, about
MOST_BARS = 5_000  # of the timeline; shorter ones are left out
DASHES = ("solid", "dash", "dashdot", "dot")
Chart = dict[str, Any]


def packed(values: NDArray[Any], kind: str = "f4") -> dict[str, str]:
    """Return an array as plotly.js reads it: base64 of little-endian numbers."""
    array = np.ascontiguousarray(values, dtype=f"<{kind}")
    result = {"dtype": kind, "bdata": base64.b64encode(array.tobytes()).decode()}
    if array.ndim > 1:
        result["shape"] = ", ".join(map(str, array.shape))
    return result


def text(value: object) -> str:
    """Return a text in which plotly.js finds no markup."""
    return html.escape(str(value), quote=False)


def axis(title: str, **more: Any) -> Chart:
    """Return an axis with a title."""
    return {"title": {"text": title}, **more}


def line(name: str, x: Any, y: Any, **more: Any) -> Chart:
    """Return a line, or points with `mode="markers"`."""
    return {"type": "scatter", "mode": "lines", "name": name, "x": x, "y": y, **more}


def bars(name: str, x: Any, y: Any, **more: Any) -> Chart:
    """Return horizontal bars."""
    return {"type": "bar", "orientation": "h", "name": name, "x": x, "y": y, **more}


def _over_time(run: RunData, data: list[Chart], y_axis: Chart, **more: Any) -> Chart:
    x_axis = axis("simulated time [s]", range=[0.0, run.end])
    layout = {"xaxis": x_axis, "yaxis": y_axis, "hovermode": "closest", **more}
    return {"data": data, "layout": layout}


def map_image(grid: Grid) -> Chart:
    """Return a map as an image below a plot: walls grey, unknown space pale, the rest clear."""
    shades = np.zeros((*grid.cells.shape, 2), np.uint8)
    shades[grid.cells != FREE] = (128, 40)
    shades[grid.cells == OCCUPIED] = (110, 230)
    buffer = io.BytesIO()
    Image.fromarray(shades[::-1], "LA").save(buffer, "PNG", optimize=True)
    left, right, bottom, top = extent(grid)
    return {
        "source": "data:image/png;base64," + base64.b64encode(buffer.getvalue()).decode(),
        "xref": "x", "yref": "y", "x": left, "y": top,
        "sizex": right - left, "sizey": top - bottom, "sizing": "stretch", "layer": "below",
    }  # fmt: skip


def trajectories(run: RunData) -> Chart | None:
    """Return where each robot drove; a click in the legend hides a robot."""
    series = run.series
    if series is None or len(series.times) < 2:
        return None
    step = 1 + series.poses[..., 0].size // MOST_POINTS
    count = len(run.robots)
    shades = mpl.colormaps["viridis"](np.linspace(0.25, 0.85, max(count, 2)))
    few = count <= maps.FEW
    times = packed(series.times[::step])
    data = []
    for robot, name in enumerate(run.robots):
        x, y = (packed(series.poses[::step, robot, column]) for column in (0, 1))
        color = CYCLE[robot % len(CYCLE)] if few else to_hex(shades[robot])
        look = {"width": 2 if few else 1.2, "color": color}
        says = "x %{x:.2f} y %{y:.2f} m<br>t = %{customdata:.0f} s"
        data.append(line(text(name), x, y, customdata=times, line=look, hovertemplate=says))
    marks = (*_ends(run, series), *_station_marks(run), *_zones(run), *_crashes(run))
    return _on_map(run, [*data, *marks])


def _ends(run: RunData, series: Series) -> list[Chart]:
    """Return where robots began and ended."""
    names = [text(name) for name in run.robots]
    return [
        line(
            word,
            packed(x),
            packed(y),
            mode="markers",
            text=names,
            marker={"symbol": symbol, "size": 7, "color": INK},
            hovertemplate=f"%{{text}}<extra>{word}</extra>",
        )
        for word, symbol, (x, y) in (
            ("start", "triangle-up", series.poses[0, :, :2].T),
            ("end", "circle", series.poses[-1, :, :2].T),
        )
    ]


def _zones(run: RunData) -> list[Chart]:
    kinds = ((keepout_area, VERMILLION, "keepout zone"), (speed_area, YELLOW, "speed limit"))
    found = []
    for area_of, color, label in kinds if run.sites.zones else ():
        if corners := triangles(area_of(run.sites.zones)):
            ends = np.full((len(corners) // 3, 1, 2), np.nan)  # a gap after each triangle
            shape = np.append(np.reshape(corners, (-1, 3, 2)), ends, 1).reshape(-1, 2)
            x, y = ([None if np.isnan(v) else v for v in side] for side in shape.T.tolist())
            look = {"width": 0, "color": color}
            found.append(line(label, x, y, fill="toself", fillcolor=color, opacity=0.35, line=look))
    return found


def _station_marks(run: RunData) -> list[Chart]:
    places = run.sites.stations
    if not places:
        return []
    return [
        line(
            "stations",
            [pose.x for pose in places.values()],
            [pose.y for pose in places.values()],
            mode="markers+text",
            text=[text(name) for name in places],
            textposition=_beside(run, places),
            textfont={"size": 10, "color": INK},
            marker={"symbol": "square-open", "size": 9, "color": INK},
            hovertemplate="%{text}<br>x %{x:.2f} y %{y:.2f} m<extra></extra>",
        )
    ]


def _beside(run: RunData, places: Mapping[str, Pose]) -> list[str]:
    """Return on which side of its station each name meets fewest other names, marks and walls."""
    xs, ys = zip(*((pose.x, pose.y) for pose in places.values()), strict=True)
    left, right = (min(xs), max(xs)) if run.grid is None else extent(run.grid)[:2]
    unit = max(right - left, 1.0) / MAP_WIDTH  # [m] of a pixel
    half = 6.0 * unit
    taken = [(x - half, y - half, x + half, y + half) for x, y in zip(xs, ys, strict=True)]
    found = []
    for name, x, y in zip(places, xs, ys, strict=True):
        wide = 6.0 * len(name) * unit
        boxes = {
            "top center": (x - wide / 2, y + half, x + wide / 2, y + 3 * half),
            "middle right": (x + half, y - half, x + half + wide, y + half),
            "middle left": (x - half - wide, y - half, x - half, y + half),
            "bottom center": (x - wide / 2, y - 3 * half, x + wide / 2, y - half),
        }
        hits = {
            side: sum(b[0] < o[2] and b[2] > o[0] and b[1] < o[3] and b[3] > o[1] for o in taken)
            + (b[0] < left)
            + (b[2] > right)
            + (run.grid is not None and _meets_wall(run.grid, b))
            for side, b in boxes.items()
        }
        found.append(min(hits, key=hits.__getitem__))
        taken.append(boxes[found[-1]])
    return found


def _meets_wall(grid: Grid, box: tuple[float, float, float, float]) -> bool:
    (bottom, left), (top, right) = grid.cell_of(*box[:2]), grid.cell_of(*box[2:])
    cells = grid.cells[max(bottom, 0) : max(top + 1, 0), max(left, 0) : max(right + 1, 0)]
    return bool((cells == OCCUPIED).any())


def _crashes(run: RunData) -> list[Chart]:
    crashes = run.report.get("breaches", {}).get("collisions", [])
    if not crashes:
        return []
    names = [" and ".join([*c["robots"], *filter(None, [c["obstacle"]])]) for c in crashes]
    return [
        line(
            f"collisions ({len(crashes)})",
            [crash["x"] for crash in crashes],
            [crash["y"] for crash in crashes],
            mode="markers",
            text=[
                f"{text(who)}<br>t = {crash['sim_time']:.1f} s"
                for who, crash in zip(names, crashes, strict=True)
            ],
            marker={"symbol": "x", "size": 12, "color": VERMILLION, "line": {"width": 1}},
            hovertemplate="%{text}<extra>collision</extra>",
        )
    ]


def _on_map(run: RunData, data: list[Chart]) -> Chart:
    plain = {"showgrid": False, "zeroline": False, "constrain": "domain"}
    layout: Chart = {
        "hovermode": "closest",
        "xaxis": axis("x in map [m]", **plain),
        "yaxis": axis("y in map [m]", scaleanchor="x", **plain),
        "legend": {"orientation": "v", "x": 1.0, "y": 1.0, "yanchor": "top"},
        "height": 470,
    }
    if run.grid is not None:
        left, right, bottom, top = extent(run.grid)
        layout["xaxis"]["range"], layout["yaxis"]["range"] = [left, right], [bottom, top]
    return {"data": data, "layout": layout, "on_map": True}


def density(run: RunData) -> Chart | None:
    """Return where robots were."""
    return _heat_map(run, maps.presence_heat(run), "YlGnBu")


def waiting(run: RunData) -> Chart | None:
    """Return where robots held or waited."""
    return _heat_map(run, maps.waiting_heat(run), "YlOrRd")


def _heat_map(run: RunData, heat: maps.Heat | None, colors: str) -> Chart | None:
    if heat is None or heat.values.max() <= 0.0:
        return None
    values = heat.values.T
    with np.errstate(divide="ignore"):
        power = np.where(values > 0.0, np.log10(values), np.nan)
    low, high = float(np.nanmin(power)), float(np.nanmax(power))
    ticks = np.arange(np.ceil(low), np.floor(high) + 1.0)
    if len(ticks) < 2:
        ticks = np.array([low, high])
    shades = mpl.colormaps[colors](np.linspace(maps.PALEST, 1.0, 9))
    left, _, bottom, _ = heat.extent
    trace = {
        "type": "heatmap",
        "z": packed(power),
        "customdata": packed(values),
        "x0": left + 0.5 * heat.steps[0],
        "dx": heat.steps[0],
        "y0": bottom + 0.5 * heat.steps[1],
        "dy": heat.steps[1],
        "hoverongaps": False,
        "colorscale": [[place / 8, to_hex(shade)] for place, shade in enumerate(shades)],
        "colorbar": {
            "title": {"text": "robot-seconds per m²", "side": "right"},
            "tickvals": ticks.tolist(),
            "ticktext": [f"{float(f'{10.0**tick:.2g}'):g}" for tick in ticks],
            "thickness": 14,
        },
        "hovertemplate": "x %{x:.2f} y %{y:.2f} m<br>%{customdata:.1f} robot-seconds per m²"
        "<extra></extra>",
    }
    return _on_map(run, [trace, *_station_marks(run)])


def timeline(run: RunData) -> Chart | None:
    """Return a bar per robot, coloured by its state."""
    spans = run.spans
    if not spans:
        return None
    shortest = run.end / 1500.0 if len(spans) > MOST_BARS else 0.0
    data = []
    for state in STATES:
        shown = [span for span in spans if span.state == state and span.length > shortest]
        if shown:
            data.append(_bars_of_state(run, state, shown))
    missed = [event for event in run.goals if event.outcome == "failed"]
    if missed:
        data.append(_missed(run, missed))
    count = len(run.robots)
    every = 1 if count <= 40 else 5
    y_axis = axis(
        "",
        autorange="reversed",
        tickmode="array",
        showgrid=False,
        tickvals=list(range(0, count, every)),
        ticktext=[text(name) for name in run.robots[::every]],
    )
    height = 150 + max(120, min(900, 17 * count))
    return _over_time(run, data, y_axis, barmode="overlay", bargap=0.12, height=height)


def _bars_of_state(run: RunData, state: str, spans: Sequence[Span]) -> Chart:
    return bars(
        LABELS.get(state, state),
        packed(np.array([span.length for span in spans])),
        [span.robot for span in spans],
        base=packed(np.array([span.start for span in spans])),
        width=0.88,  # else the fewer robots were in the state, the higher are its bars
        customdata=packed(np.array([(span.start, span.end) for span in spans])),
        text=[_about(run, span) for span in spans],
        textposition="none",
        marker={"color": STATES[state], "line": {"width": 0}},
        hovertemplate="%{text}<br>%{customdata[0]:.1f} to %{customdata[1]:.1f} s",
    )


def _about(run: RunData, span: Span) -> str:
    place = f", {span.place}. in its queue" if span.place else ""
    station = f"<br>{text(span.station)}{place}" if span.station else ""
    return f"{text(run.robots[span.robot])}{station}"


def _missed(run: RunData, events: Sequence[GoalEvent]) -> Chart:
    return line(
        "missed goal",
        [event.time for event in events],
        [event.robot for event in events],
        mode="markers",
        text=[text(f"{run.robots[event.robot]} missed {event.goal}") for event in events],
        marker={"symbol": "x", "size": 10, "color": INK},
        hovertemplate="%{text}<br>t = %{x:.1f} s<extra></extra>",
    )


def goals(run: RunData) -> Chart | None:
    """Return goals reached and missed over time."""
    settled = [event for event in run.goals if event.outcome != "sent"]
    if not settled:
        return None
    data = []
    for outcome, word, color in (("reached", "reached", BLUE), ("failed", "missed", VERMILLION)):
        events = [event for event in settled if event.outcome == outcome]
        if events or outcome == "reached":
            names = [text(f"{run.robots[event.robot]}: {event.goal}") for event in events]
            times = [0.0, *(event.time for event in events), run.end]
            counts = [*range(len(events) + 1), len(events)]
            look = {"shape": "hv", "color": color, "width": 2}
            says = "%{y} after %{x:.1f} s<br>%{text}"
            title = f"{word} ({len(events)})"
            texts = ["", *names, ""]
            data.append(line(title, times, counts, line=look, text=texts, hovertemplate=says))
    total = mission_goals(run.report)
    if total:
        data.append(_level(run, total, f"mission ({total})"))
    return _over_time(run, data, axis("goals of all robots", rangemode="tozero"))


def _level(run: RunData, value: float, name: str) -> Chart:
    look = {"dash": "dot", "width": 1.2, "color": INK}
    return line(name, [0.0, run.end], [value, value], line=look, hoverinfo="name")


def flow(run: RunData) -> Chart | None:
    """Return goals per minute over time."""
    rates = throughput(run)
    if rates is None:
        return None
    widths = rates.ends - rates.starts
    columns = {
        "type": "bar",
        "name": "goals per minute",
        "x": (rates.starts + 0.5 * widths).tolist(),
        "width": widths.tolist(),
        "y": rates.per_minute.tolist(),
        "customdata": np.column_stack([rates.starts, rates.ends, rates.goals]).tolist(),
        "marker": {"color": SKY},
        "hovertemplate": "%{y:.1f} per minute: %{customdata[2]:.0f} goals"
        "<br>%{customdata[0]:.0f} to %{customdata[1]:.0f} s<extra></extra>",
    }
    data = [columns, _level(run, rates.mean, rates.mean_label)]
    return _over_time(run, data, axis("goals per minute", rangemode="tozero"), bargap=0.04)


def states(run: RunData) -> Chart | None:
    """Return the share of the robots in each state over time."""
    shares = shares_over_time(run)
    if shares is None:
        return None
    data = []
    for state, share in shares.by_state.items():
        name, color = LABELS.get(state, state), STATES.get(state, "#000000")
        look = {"width": 0, "color": color}
        data.append(
            line(
                name, packed(shares.times), packed(100.0 * share), line=look,
                stackgroup="robots", fillcolor=color, hovertemplate="%{y:.0f} %",
            )
        )  # fmt: skip
    return _over_time(run, data, axis("robots [%]", range=[0, 100]), hovermode="x unified")


def stations(run: RunData) -> Chart | None:
    """Return use and queue of each station."""
    uses = station_use(run)
    if not uses or run.series is None:
        return None
    names = [text(name) for name in uses]
    used = bars(
        "in use",
        [100.0 * (use.utilisation or 0.0) for use in uses.values()],
        names,
        customdata=[use.goals for use in uses.values()],
        text=[f"{use.goals} goals" for use in uses.values()],
        textposition="none",
        marker={"color": BLUE},
        hovertemplate="in use %{x:.1f} % of the time<br>%{customdata} goals",
    )
    queued = bars(
        "queue",
        [use.queue for use in uses.values()],
        names,
        xaxis="x2",
        customdata=[[use.longest_queue, use.queue_time] for use in uses.values()],
        marker={"color": ORANGE},
        hovertemplate="%{x:.2f} robots on average, %{customdata[0]} at most"
        "<br>%{customdata[1]:.0f} robot-seconds",
    )
    layout = {
        "xaxis": axis(
            f"robot within {AT_STATION:g} m [% of time]", range=[0, 115], domain=[0, 0.48]
        ),
        "xaxis2": axis("queueing or holding, on average", domain=[0.54, 1.0], rangemode="tozero"),
        "yaxis": axis("", autorange="reversed", automargin=True),
        "hovermode": "closest",
        "showlegend": False,
        "height": 170 + 26 * len(names),
    }
    return {"data": [used, queued], "layout": layout}


def clearance(run: RunData) -> Chart | None:
    """Return how near robots came to each other and to obstacles."""
    series = run.series
    if series is None or not len(series.times):
        return None
    edges = np.arange(0.0, series.near + BIN, BIN)
    says = (
        "from %{x:.2f} m: %{y} robot-seconds<br>%{customdata:.1f} % are"
        f" nearer than this and {BIN:g} m more"
    )
    data = []
    for values, name, color, dash in (
        (series.to_robot, "to the nearest robot", BLUE, "solid"),
        (series.to_world, "to the nearest obstacle", ORANGE, "dash"),
    ):
        known = values[np.isfinite(values)]
        counts, _ = np.histogram(known[known < series.near - 1e-9], bins=edges)
        below = 100.0 * np.cumsum(counts) / max(known.size, 1)
        x, y = np.round(edges, 3).tolist(), [*counts.tolist(), int(counts[-1])]
        look = {"shape": "hv", "color": color, "dash": dash, "width": 2}
        shares = np.round([*below, below[-1]], 3).tolist()
        data.append(line(name, x, y, line=look, customdata=shares, hovertemplate=says))
    limits = [(NEAR_MISS, f"near miss ({NEAR_MISS} m)", VERMILLION, "dot")]
    smallest = run.report.get("min_clearance")
    if smallest is not None:
        limits.append((smallest, f"smallest ({smallest:.3f} m)", INK, "dashdot"))
    top = max((max(trace["y"]) for trace in data), default=1) or 1
    for at, name, color, dash in limits:
        look = {"color": color, "dash": dash, "width": 1.2}
        data.append(line(name, [at, at], [0, top], line=look, hoverinfo="name"))
    layout = {
        "xaxis": axis("smallest clearance within a second [m]", range=[0.0, series.near]),
        "yaxis": axis(f"robot-seconds per {BIN:g} m", rangemode="tozero"),
        "hovermode": "closest",
    }
    return {"data": data, "layout": layout}


def usage(run: RunData) -> Chart | None:
    """Return speed, CPU and memory over the wall clock."""
    measured = run.usage
    if measured is None:
        return None
    wall, sim = packed(measured.wall), packed(measured.sim)

    def curve(
        name: str, values: NDArray[Any], color: str, y_axis: str, unit: str, place: int
    ) -> Chart:
        look = {"color": color, "width": 1.6, "dash": DASHES[place % len(DASHES)]}
        says = f"%{{y:.2f}}{unit} (t = %{{customdata:.0f}} s)"
        return line(
            text(name), wall, packed(values), legendgroup=text(name), customdata=sim,
            yaxis=y_axis, line=look, hovertemplate=says,
        )  # fmt: skip

    data = [curve("real-time factor", measured.factor, INK, "y", "", 0)]
    for place, (group, cores) in enumerate(measured.cores.items()):
        color = GROUPS.get(group, INK)
        data.append(curve(group, cores, color, "y2", " cores", place))
        if group in measured.memory_mb:
            memory = measured.memory_mb[group] / 1000.0
            data.append(curve(group, memory, color, "y3", " GB", place) | {"showlegend": False})
    layout = {
        "xaxis": axis("wall time since the start of the command [s]", anchor="y3"),
        "yaxis": axis("real-time factor", domain=[0.7, 1.0], rangemode="tozero"),
        "yaxis2": axis("CPU [cores]", domain=[0.36, 0.64], rangemode="tozero"),
        "yaxis3": axis("memory [GB]", domain=[0.0, 0.3], rangemode="tozero"),
        "hovermode": "x unified",
        "height": 520,
    }
    return {"data": data, "layout": layout}
