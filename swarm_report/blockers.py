"""Who waited or made way for whom: robots on a circle, with an arrow for each pair."""

from __future__ import annotations

from collections import defaultdict

import numpy as np

from swarm_common.model.records import FloatArray
from swarm_report.charts import INK, Chart, line, text
from swarm_report.headline import waits_between
from swarm_report.run import RunData
from swarm_report.style import BLUE, VERMILLION
from swarm_report.tables import Table, percent

MOST = 40  # arrows, the longest stops
WIDEST = 6.0  # [pt] of an arrow


def chart(run: RunData) -> Chart | None:
    """Return the plot; None if nobody is known to have stopped for another robot."""
    found = _graph(run)
    if found is None:
        return None
    places, edges, kept = found
    longest = max(edges.values())
    arrows = [
        {
            "x": places[blocker][0], "y": places[blocker][1],
            "ax": places[waiter][0], "ay": places[waiter][1],
            "xref": "x", "yref": "y", "axref": "x", "ayref": "y", "text": "", "showarrow": True,
            "arrowhead": 2, "arrowsize": 0.8, "standoff": 6, "startstandoff": 6,
            "arrowwidth": 0.8 + WIDEST * seconds / longest, "arrowcolor": VERMILLION,
            "opacity": 0.25 + 0.7 * seconds / longest,
        }
        for (waiter, blocker), seconds in edges.items()
    ]  # fmt: skip
    points = np.array(list(places.values()))
    robots = line(
        "", points[:, 0].tolist(), points[:, 1].tolist(), mode="markers+text",
        text=[text(name) for name in places],  # outside of the circle, off the arrows
        textposition=[f"{'top' if y > 0.0 else 'bottom'} center" for _, y in places.values()],
        customdata=[text(_about(name, edges)) for name in places],
        marker={
            "color": BLUE, "size": [8.0 + 16.0 * kept[name] / max(kept.values()) for name in places]
        },
        textfont={"color": INK, "size": 10}, hovertemplate="%{customdata}<extra></extra>",
    )  # fmt: skip
    hidden = {"visible": False, "range": [-1.25, 1.25]}
    layout = {
        "xaxis": {**hidden}, "yaxis": {**hidden, "scaleanchor": "x"}, "annotations": arrows,
        "showlegend": False, "height": 460, "margin": {"l": 10, "r": 10, "t": 30, "b": 10},
        "hovermode": "closest",
    }  # fmt: skip
    return {"data": [robots], "layout": layout}


def table(run: RunData) -> Table | None:
    """Return the seconds of each pair."""
    pairs = waits_between(run)
    total = sum(pairs.values())
    rows = [
        [waiter, blocker, f"{seconds:.1f}", percent(seconds / total)]
        for (waiter, blocker), seconds in pairs.items()
    ]
    return Table(["robot", "stopped for", "time [s]", "of all"], rows) if rows else None


def _about(name: str, edges: dict[tuple[str, str], float]) -> str:
    own = ", ".join(f"{other} {time:.0f} s" for (one, other), time in edges.items() if one == name)
    by = ", ".join(f"{one} {time:.0f} s" for (one, other), time in edges.items() if other == name)
    return f"{name} stopped for: {own or 'nobody'}. For it stopped: {by or 'nobody'}."


def _graph(
    run: RunData,
) -> tuple[dict[str, FloatArray], dict[tuple[str, str], float], dict[str, float]] | None:
    """Return places (2,) by robot, seconds by pair, and seconds that each robot was stopped for."""
    edges = dict(list(waits_between(run).items())[:MOST])
    if not edges:
        return None
    names = [name for name in run.robots if any(name in pair for pair in edges)]
    kept: dict[str, float] = defaultdict(float)
    for (_, blocker), seconds in edges.items():
        kept[blocker] += seconds
    angles = np.linspace(0.5 * np.pi, -1.5 * np.pi, len(names), endpoint=False)
    spots = np.column_stack([np.cos(angles), np.sin(angles)])
    return dict(zip(names, spots, strict=True)), edges, kept
