"""One self-contained HTML page from figures, tables and a verdict."""

from __future__ import annotations

import base64
import html
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

CSS = """
:root { color-scheme: light; --line: #d9d9d9; --soft: #f6f7f8; }
body { font: 15px/1.45 system-ui, "Segoe UI", "DejaVu Sans", sans-serif; color: #1c1c1c;
       max-width: 1180px; margin: 0 auto; padding: 24px; }
h1 { font-size: 1.45rem; margin: 0 0 .2rem; } h2 { font-size: 1.1rem; margin: 2rem 0 .6rem; }
.sub { color: #555; margin: 0 0 1rem; }
.verdict { border-left: 8px solid; padding: .7rem 1rem; background: var(--soft); }
.verdict strong { font-size: 1.15rem; }
.good { border-color: #0072B2; } .bad { border-color: #D55E00; } .open { border-color: #E69F00; }
.verdict ul { margin: .4rem 0 0; padding-left: 1.2rem; }
.cards { display: grid; grid-template-columns: repeat(auto-fill, minmax(165px, 1fr)); gap: 10px;
         margin: 1rem 0; }
.card { border: 1px solid var(--line); border-radius: 6px; padding: .5rem .7rem; }
.card b { display: block; font-size: 1.2rem; } .card span { color: #555; font-size: .82rem; }
.plots { display: grid; grid-template-columns: repeat(auto-fit, minmax(480px, 1fr)); gap: 18px;
  grid-auto-flow: dense;
         align-items: start; }
figure { margin: 0; border: 1px solid var(--line); border-radius: 6px; padding: 10px; }
figure.wide { grid-column: 1 / -1; } figure img { width: 100%; height: auto; }
figcaption { color: #555; font-size: .85rem; padding-top: 4px; }
table { border-collapse: collapse; font-size: .86rem; width: 100%; }
th, td { border-bottom: 1px solid var(--line); padding: 4px 8px; text-align: right;
         font-variant-numeric: tabular-nums; }
th:first-child, td:first-child { text-align: left; } th { background: var(--soft); }
.scroll { overflow-x: auto; } footer { color: #555; font-size: .82rem; margin-top: 2rem; }
@media (max-width: 560px) { .plots { grid-template-columns: 1fr; } }
"""


@dataclass(frozen=True, slots=True)
class Plot:
    """A figure of the page: `caption` says what it shows, `svg` is the drawing."""

    name: str
    caption: str
    svg: bytes
    is_wide: bool = False


def escape(value: object) -> str:
    """Return text that is safe in HTML."""
    return html.escape(str(value), quote=True)


def plot_html(plot: Plot) -> str:
    """Return a figure; as an image, so that the names within two drawings never meet."""
    data = base64.b64encode(plot.svg).decode()
    kind = ' class="wide"' if plot.is_wide else ""
    return (
        f'<figure{kind} id="{escape(plot.name)}"><img alt="{escape(plot.caption)}"'
        f' src="data:image/svg+xml;base64,{data}">'
        f"<figcaption>{escape(plot.caption)}</figcaption></figure>"
    )


def cards_html(values: Mapping[str, str]) -> str:
    """Return a box per figure of merit."""
    cards = "".join(
        f'<div class="card"><b>{escape(value)}</b><span>{escape(name)}</span></div>'
        for name, value in values.items()
    )
    return f'<div class="cards">{cards}</div>'


def table_html(head: Sequence[str], rows: Sequence[Sequence[object]]) -> str:
    """Return a table."""
    top = "".join(f"<th>{escape(cell)}</th>" for cell in head)
    body = "".join(
        "<tr>" + "".join(f"<td>{escape(cell)}</td>" for cell in row) + "</tr>" for row in rows
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


def page_html(title: str, subtitle: str, body: Sequence[str]) -> str:
    """Return the whole page."""
    return (
        '<!DOCTYPE html>\n<html lang="en"><head><meta charset="utf-8">'
        '<meta name="viewport" content="width=device-width, initial-scale=1">'
        f"<title>{escape(title)}</title><style>{CSS}</style></head><body>"
        f'<h1>{escape(title)}</h1><p class="sub">{escape(subtitle)}</p>' + "\n".join(body) + "\n"
        "</body></html>\n"
    )
