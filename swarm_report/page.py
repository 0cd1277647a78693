"""One self-contained HTML page from figures, tables and a verdict."""

from __future__ import annotations

import base64
import functools
import gzip
import html
import importlib.util
import json
import shlex
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from importlib.resources import files
from pathlib import Path
from typing import Any

from swarm_report.headline import HeadlinePart
from swarm_report.tables import Table

BEFORE = 5.0  # [s] before a moment, at which its replay begins
# A page needs nothing but itself, and may ask nobody for anything.
POLICY = (
    "default-src 'none'; img-src data: blob:; style-src 'unsafe-inline'; script-src 'unsafe-inline'"
)


@dataclass(frozen=True, slots=True)
class Plot:
    """A figure of the page."""

    name: str  # unique within the page
    caption: str  # what it shows
    svg: bytes  # the still drawing, for paper and for browsers without scripts
    is_wide: bool = False  # whether it takes the whole width
    # the same for plotly.js; None if there is only the still drawing
    chart: Mapping[str, Any] | None = None
    table: Table | None = None  # the figures behind it


def escape(value: object) -> str:
    """Return text that is safe in HTML."""
    return html.escape(str(value), quote=True)


def plots_html(plots: Sequence[Plot], map_image: Mapping[str, Any] | None = None) -> str:
    """Return the figures with their tables, and the data for plotly.js.

    `map_image` lies below charts that are `on_map`.
    """
    figures = "\n".join(map(_figure, plots))
    charts = {plot.name: plot.chart for plot in plots if plot.chart is not None}
    packed = plotly_js() if charts else ""
    scripts = ""
    if packed:
        data = json.dumps({"charts": charts, "map": map_image}, separators=(",", ":"))
        data = data.replace("<", "\\u003c")  # nothing in it may end the script
        scripts = (
            f'<script type="application/json" id="charts">{data}</script>'
            f'<script type="text/plain" id="plotly-js">{packed}</script>'
        )
    return f'<div class="plots">{figures}</div>{scripts}'


def _figure(plot: Plot) -> str:
    """Return a figure; as an image, so that the names within two drawings never meet."""
    data = base64.b64encode(plot.svg).decode()
    kind = ' class="wide"' if plot.is_wide else ""
    return (
        f'<figure{kind} id="{escape(plot.name)}"><img alt="{escape(plot.caption)}"'
        f' src="data:image/svg+xml;base64,{data}"><div class="live"></div>'
        f"<figcaption>{escape(plot.caption)}</figcaption>{_data(plot.table)}</figure>"
    )


def _data(table: Table | None) -> str:
    if table is None:
        return ""
    note = f'<p class="note">{escape(table.note)}</p>' if table.note else ""
    return (
        f'<details class="data"><summary>Table</summary>{note}'
        f"{table_html(table.head, table.rows)}</details>"
    )


def cards_html(values: Mapping[str, str]) -> str:
    """Return a box per figure of merit."""
    cards = "".join(
        f'<div class="card"><b>{escape(value)}</b><span>{escape(name)}</span></div>'
        for name, value in values.items()
    )
    return f'<div class="cards">{cards}</div>'


def table_html(
    head: Sequence[str],
    rows: Sequence[Sequence[object]],
    marks: Mapping[tuple[int, int], str] | None = None,
) -> str:
    """Return a table; `marks` are classes of cells by row and column."""
    top = "".join(f"<th>{escape(cell)}</th>" for cell in head)
    classes = {place: f' class="{escape(name)}"' for place, name in (marks or {}).items()}
    body = "".join(
        "<tr>"
        + "".join(
            f"<td{classes.get((at, column), '')}>{escape(cell)}</td>"
            for column, cell in enumerate(row)
        )
        + "</tr>"
        for at, row in enumerate(rows)
    )
    return (
        f'<div class="scroll"><table><thead><tr>{top}</tr></thead>'
        f"<tbody>{body}</tbody></table></div>"
    )


def verdict_html(kind: str, headline: str, lines: Sequence[str]) -> str:
    """Return the verdict; `kind` is good, bad or open."""
    points = "".join(f"<li>{escape(line)}</li>" for line in lines)
    rest = f"<ul>{points}</ul>" if points else ""
    return f'<div class="verdict {kind}"><strong>{escape(headline)}</strong>{rest}</div>'


def headline_html(parts: Sequence[HeadlinePart], folder: Path) -> str:
    """Return the headline; a part that is about a moment leads there, and says how to replay it."""
    texts = []
    for part in parts:
        words = escape(part.text)
        if part.time is not None:
            start = max(0.0, part.time - BEFORE)
            replay = f"swarm-replay {shlex.quote(str(folder))} --start {start:.0f}"
            words = (
                f'<a href="#timeline" data-moment="{part.time:.1f}"'
                f' title="{escape(replay)}">{words}</a>'
            )
        texts.append(words)
    return f'<p class="headline">{"".join(texts)}</p><p class="note" id="replay"></p>'


def page_html(title: str, subtitle: str, body: Sequence[str], script: str = "") -> str:
    """Return the whole page; `script` is of this page alone."""
    css, js = (asset(name) for name in ("page.css", "page.js"))
    return (
        '<!DOCTYPE html>\n<html lang="en"><head><meta charset="utf-8">'
        f'<meta http-equiv="Content-Security-Policy" content="{escape(POLICY)}">'
        '<meta name="viewport" content="width=device-width, initial-scale=1">'
        f"<title>{escape(title)}</title><style>{css}</style><script>{js}{script}</script></head>"
        '<body><button id="theme" type="button">Dark</button>'
        f'<h1>{escape(title)}</h1><p class="sub">{escape(subtitle)}</p>' + "\n".join(body) + "\n"
        "</body></html>\n"
    )


def asset(name: str) -> str:
    """Return a file of this package as text."""
    return files("swarm_report").joinpath(name).read_text(encoding="utf-8")


@functools.cache
def plotly_js() -> str:
    """Return plotly.js, gzipped and in base64; empty if the package `plotly` is not installed."""
    found = importlib.util.find_spec("plotly")
    for folder in (found.submodule_search_locations or []) if found is not None else []:
        path = Path(folder) / "package_data" / "plotly.min.js"
        if path.is_file():
            return base64.b64encode(gzip.compress(path.read_bytes(), 9, mtime=0)).decode()
    return ""
