"""Still pictures of charts, for paper, for files, and for browsers without scripts.

A chart is what plotly.js is given; matplotlib draws the part of it that ours use.
"""

from __future__ import annotations

import base64
import html
import io
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import PolyCollection
from matplotlib.colors import LinearSegmentedColormap
from matplotlib.figure import Figure
from matplotlib.ticker import PercentFormatter
from numpy.typing import NDArray
from PIL import Image

from swarm_report.charts import INK, Chart
from swarm_report.style import BLACK, WIDE_WIDTH, WIDTH

HEIGHT = 360  # [px] of a chart that does not say
PIXELS = 105.0  # of a chart in an inch of its still picture
SIDES: dict[str, tuple[tuple[int, int], dict[str, Any]]] = {  # of a text at a point
    "top center": ((0, 5), {"ha": "center"}),
    "bottom center": ((0, -5), {"ha": "center", "va": "top"}),
    "middle right": ((5, 0), {"ha": "left", "va": "center"}),
    "middle left": ((-5, 0), {"ha": "right", "va": "center"}),
}
POINTS = 0.75  # [pt] in a pixel, of lines
MOST_NAMED = 12  # entries of a legend; with more, only those that are marks or areas are named
VECTOR_LIMIT = 1500  # bars beyond which they are drawn as pixels, to keep the SVG small
STYLES = {"solid": "-", "dash": "--", "dashdot": "-.", "dot": ":"}
SYMBOLS = {"square-open": "s", "x": "X", "triangle-up": "^", "circle": "o"}


def still(chart: Chart, map_image: Chart | None = None, *, is_wide: bool = False) -> Figure:
    """Return a chart as a figure; `map_image` lies below one that is `on_map`."""
    layout = chart["layout"]
    drawing = Figure(figsize=_size(layout, is_wide=is_wide), layout="constrained")
    panels = _panels(drawing, chart)
    floors: dict[str, NDArray[Any]] = {}  # of stacked areas
    for trace in chart["data"]:
        axes = panels[_place(trace)]
        if trace["type"] == "heatmap":
            _draw_heatmap(drawing, axes, trace)
        elif trace["type"] == "bar":
            _draw_bars(axes, trace)
        else:
            _draw_line(axes, trace, floors)
    for area in layout.get("shapes", ()):
        axes = panels["x", "y"]
        axes.axvspan(area["x0"], area["x1"], color=area["fillcolor"], alpha=area["opacity"])
    for note in layout.get("annotations", ()):
        _draw_arrow(panels["x", "y"], note)
    if map_image is not None and chart.get("on_map"):
        _draw_map(panels["x", "y"], map_image)
    for (x, y), axes in panels.items():
        _set_axis(axes, "x", layout.get(_key(x), {}))
        _set_axis(axes, "y", layout.get(_key(y), {}))
        if "grid" not in layout:
            axes.label_outer()
    if layout.get("showlegend", True):
        _draw_legend(drawing, list(panels.values()), columns=8 if is_wide else 4)
    return drawing


def values(given: Any) -> NDArray[Any]:
    """Return the numbers or names of a chart's field, packed or not; NaN where there is none."""
    if not isinstance(given, Mapping):
        return np.array([np.nan if value is None else value for value in given])
    data = np.frombuffer(base64.b64decode(given["bdata"]), f"<{given['dtype']}")
    shape = given.get("shape")
    return data if shape is None else data.reshape([int(part) for part in shape.split(",")])


def _size(layout: Chart, *, is_wide: bool) -> tuple[float, float]:
    width = WIDE_WIDTH if is_wide else WIDTH
    spans = [layout.get(name, {}).get("range") for name in ("xaxis", "yaxis")]
    if "scaleanchor" in layout.get("yaxis", {}) and all(spans):
        (left, right), (bottom, top) = spans
        return width, max(2.6, min(9.0, width * 0.88 * (top - bottom) / (right - left) + 0.7))
    return width, layout.get("height", HEIGHT) / PIXELS


def _place(trace: Chart) -> tuple[str, str]:
    return trace.get("xaxis", "x"), trace.get("yaxis", "y")


def _key(axis: str) -> str:
    return f"{axis[0]}axis{axis[1:]}"


def _panels(drawing: Figure, chart: Chart) -> dict[tuple[str, str], Axes]:
    """Return the axes of each pair of a chart: in a grid, above each other, or side by side."""
    places = list(dict.fromkeys(map(_place, chart["data"]))) or [("x", "y")]
    rows, columns = 1, len(places)
    if grid := chart["layout"].get("grid"):
        rows, columns = grid["rows"], grid["columns"]
    elif len({y for _, y in places}) > 1:
        rows, columns = len(places), 1
    is_one_x, is_one_y = (len({place[side] for place in places}) == 1 for side in (0, 1))
    axes = drawing.subplots(rows, columns, squeeze=False, sharex=is_one_x, sharey=is_one_y)
    return dict(zip(places, axes.ravel(), strict=True))


def _color(look: Mapping[str, Any]) -> Any:
    color = look.get("color", BLACK)
    return BLACK if isinstance(color, str) and color == INK else color


def _label(trace: Chart) -> str | None:
    is_named = trace.get("name") and trace.get("showlegend", True)
    return html.unescape(trace["name"]) if is_named else None


def _draw_line(axes: Axes, trace: Chart, floors: dict[str, NDArray[Any]]) -> None:
    x, y = values(trace["x"]), values(trace["y"])
    look, marker, mode = trace.get("line", {}), trace.get("marker", {}), trace.get("mode", "lines")
    label = _label(trace)
    if group := trace.get("stackgroup"):
        floor = floors.get(group, np.zeros(len(x)))
        floors[group] = floor + y
        axes.fill_between(x, floor, floors[group], color=_color(look), linewidth=0.0, label=label)
        return
    if trace.get("fill") == "toself":
        ends = np.flatnonzero(np.isnan(x))
        parts = [part[np.isfinite(part[:, 0])] for part in np.split(np.column_stack([x, y]), ends)]
        color = trace["fillcolor"]
        axes.add_collection(PolyCollection(parts, facecolors=color, alpha=0.35, label=label))
        return
    if "lines" in mode:
        axes.plot(
            x, y, STYLES[look.get("dash", "solid")], color=_color(look), label=label,
            linewidth=POINTS * look.get("width", 2), zorder=3,
            drawstyle="steps-post" if look.get("shape") == "hv" else "default",
        )  # fmt: skip
    if "markers" in mode:
        color, symbol = _color(marker or look), marker.get("symbol", "circle")
        is_open = symbol.endswith("-open")
        axes.scatter(
            x, y, (POINTS * np.asarray(marker.get("size", 6))) ** 2, marker=SYMBOLS[symbol],
            facecolors="none" if is_open else color, edgecolors=color, zorder=5,
            label=None if "lines" in mode else label,
        )  # fmt: skip
    if "text" in mode:
        given = trace["textposition"]
        sides = [given] * len(trace["text"]) if isinstance(given, str) else given
        for at, name, side in zip(zip(x, y, strict=True), trace["text"], sides, strict=True):
            offset, aligned = SIDES[side]
            axes.annotate(
                html.unescape(name), at, offset, textcoords="offset points", fontsize=7,
                zorder=6, **aligned,
            )  # fmt: skip
    if error := trace.get("error_y"):
        sides = [error["arrayminus"], error["array"]]
        axes.errorbar(x, y, sides, fmt="none", ecolor=_color(look), capsize=2)


def _draw_bars(axes: Axes, trace: Chart) -> None:
    x, y, color = values(trace["x"]), values(trace["y"]), _color(trace.get("marker", {}))
    if "base" in trace:
        start, half = values(trace["base"]), 0.5 * trace["width"]
        sides = [start, start + x, start + x, start], [y - half, y - half, y + half, y + half]
        bars = PolyCollection(  # one of all is far cheaper than a patch of each
            list(np.stack([np.stack(side, 1) for side in sides], 2)),
            facecolors=color,
            linewidths=0.0,
            rasterized=len(x) > VECTOR_LIMIT,
            label=_label(trace),
        )
        axes.add_collection(bars)
        axes.autoscale_view()
        return
    if trace.get("orientation") == "h":
        names: Any = [html.unescape(name) for name in y]
        drawn = axes.barh(names, np.nan_to_num(x), 0.7, color=color, label=_label(trace))
    else:
        drawn = axes.bar(x, y, trace["width"], color=color, label=_label(trace))
    if "text" in trace:
        axes.bar_label(drawn, trace["text"], padding=3, fontsize=7)
        axes.margins(x=0.18)


def _draw_heatmap(drawing: Figure, axes: Axes, trace: Chart) -> None:
    z, width, height = values(trace["z"]), trace["dx"], trace["dy"]
    left, bottom = trace["x0"] - 0.5 * width, trace["y0"] - 0.5 * height
    extent = (left, left + z.shape[1] * width, bottom, bottom + z.shape[0] * height)
    colors = LinearSegmentedColormap.from_list("chart", trace["colorscale"])
    image = axes.imshow(
        np.ma.masked_invalid(z),
        origin="lower",
        extent=extent,
        cmap=colors,
        interpolation="nearest",
        zorder=1,
    )
    bar = trace["colorbar"]
    scale = drawing.colorbar(image, ax=axes, label=bar["title"]["text"], shrink=0.8)
    scale.set_ticks(bar["tickvals"], labels=bar["ticktext"])


def _draw_arrow(axes: Axes, note: Chart) -> None:
    axes.annotate(
        "", (note["x"], note["y"]), (note["ax"], note["ay"]),
        arrowprops={
            "arrowstyle": "-|>", "color": note["arrowcolor"], "alpha": note["opacity"],
            "linewidth": POINTS * note["arrowwidth"], "shrinkA": 5, "shrinkB": 5,
            "connectionstyle": "arc3,rad=0.12",
        },
    )  # fmt: skip


def _draw_map(axes: Axes, image: Chart) -> None:
    data = base64.b64decode(image["source"].partition(",")[2])
    pixels = np.asarray(Image.open(io.BytesIO(data)).convert("RGBA"))
    left, top = image["x"], image["y"]
    extent = (left, left + image["sizex"], top - image["sizey"], top)
    axes.imshow(pixels, extent=extent, interpolation="nearest", zorder=2)


def _set_axis(axes: Axes, name: str, given: Chart) -> None:
    """Give an axis the title, limits and ticks of a chart's."""
    axis = axes.xaxis if name == "x" else axes.yaxis
    axes.set(**{f"{name}label": given.get("title", {}).get("text", "")})
    if not given.get("visible", True):
        axes.axis("off")
    if "tickvals" in given:
        axis.set_ticks(given["tickvals"], [html.unescape(each) for each in given["ticktext"]])
    if "tickformat" in given:
        axis.set_major_formatter(PercentFormatter(1.0, 0))
    if not given.get("showgrid", True):
        axes.grid(visible=False, axis="x" if name == "x" else "y")
    if not given.get("showticklabels", True):
        axis.set_tick_params(labelleft=False, labelbottom=False)
    if "range" in given:
        axes.set(**{f"{name}lim": given["range"]})
    elif given.get("rangemode") == "tozero":
        axes.set(**{f"{name}lim": (0.0, None)})
    if given.get("autorange") == "reversed" and not axis.get_inverted():
        axis.set_inverted(True)
    if "scaleanchor" in given:
        axes.set_aspect("equal")


def _draw_legend(drawing: Figure, panels: Sequence[Axes], columns: int) -> None:
    entries: dict[str, Any] = {}
    for axes in panels:
        handles, labels = axes.get_legend_handles_labels()
        entries |= dict(zip(labels, handles, strict=True))
    if len(entries) > MOST_NAMED:
        lines = {line.get_label() for axes in panels for line in axes.lines}
        entries = {label: handle for label, handle in entries.items() if label not in lines}
    if entries:
        drawing.legend(
            list(entries.values()),
            list(entries),
            ncols=columns,
            fontsize=8,
            loc="outside upper left",
        )
