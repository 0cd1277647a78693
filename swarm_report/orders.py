"""Tables of a run with orders: what became of orders, stations, robots and floor."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from swarm_report.page import cards_html, escape, table_html
from swarm_report.tables import LONGEST, percent

MOST_ORDERS = 1000  # rows of the table of orders
SPREADS = {
    "lead_time": "lead time",
    "waiting": "waiting",
    "driving": "driving",
    "service": "service",
}
ROBOT_COLUMNS = ("driving_empty", "driving_loaded", "waiting", "service", "idle")


def order_sections(orders: Mapping[str, Any]) -> list[str]:
    """Return the sections of a page for the orders in report.json."""
    remarks = "".join(f'<p class="bottleneck">{escape(each)}</p>' for each in orders["remarks"])
    return [
        "<h2>Orders</h2>",
        remarks,
        cards_html(_cards(orders)),
        _orders(orders["orders"]),
        "<h2>Stations of orders</h2>",
        _stations(orders["stations"]),
        "<h2>What robots did for orders</h2>",
        _robots(orders.get("robots") or {}),
        "<h2>Floor</h2>",
        _floor(orders.get("floor") or {}),
    ]


def _cards(orders: Mapping[str, Any]) -> dict[str, str]:
    late = orders["lateness"]
    pairs = {name: [_text(orders[name][key]) for key in ("median", "p95")] for name in SPREADS}
    spreads = {
        f"{name.replace('_', ' ')}, median and 95 % [s]": ", ".join(pair)
        for name, pair in pairs.items()
    }
    return {
        "orders done of those that came": f"{orders['done']} / {orders['created']}",
        "orders per hour": _text(orders["throughput_per_hour"]),
        **spreads,
        "orders late": str(late["late"]),
        "orders taken back": str(orders["taken_back"]),
        "dispatch": orders["dispatch"],
    }


def _orders(records: Sequence[Mapping[str, Any]]) -> str:
    times = ("created", "waiting", "driving", "handover", "service", "lead_time", "lateness")
    head = ["order", "from", "to", "robot", *(f"{name.replace('_', ' ')} [s]" for name in times)]
    rows = [
        [
            record["id"],
            record["from"],
            record["to"],
            record["robot"] or "–",
            *(_text(record[name]) for name in times),
        ]
        for record in records[:MOST_ORDERS]
    ]
    hidden = len(records) - len(rows)
    note = f'<p class="note">{hidden} more are in report.json.</p>' if hidden else ""
    return table_html(head, rows) + note


def _stations(stations: Mapping[str, Mapping[str, Any]]) -> str:
    shares = {"utilisation": "in service", "blocked": "blocked", "occupied": "occupied"}
    head = ["station", "orders from it", "done", *shares.values(), "queue, mean", "queue, longest"]
    rows = [
        [
            name,
            station["orders_from"],
            station["orders_done"],
            *(percent(station[key]) for key in shares),
            _text(station["queue"]),
            station["queue_worst"],
        ]
        for name, station in stations.items()
    ]
    return table_html(head, rows)


def _robots(robots: Mapping[str, Mapping[str, float]]) -> str:
    head = ["robot", *(name.replace("_", " ") for name in ROBOT_COLUMNS)]
    rows = []
    for name, times in robots.items():
        total = sum(times.values()) or 1.0
        rows.append([name, *(percent(times[key] / total) for key in ROBOT_COLUMNS)])
    return table_html(head, rows)


def _floor(floor: Mapping[str, Any]) -> str:
    cells = sorted(floor.get("cells", ()), key=lambda cell: -cell["density"])[:LONGEST]
    rows = [[cell["x"], cell["y"], cell["flow"], f"{cell['density']:.3f}"] for cell in cells]
    note = f"The {len(rows)} squares of {floor.get('cell', 1.0):g} m with most robots."
    head = ["x [m]", "y [m]", "robots per hour", "robots per m²"]
    return table_html(head, rows) + f'<p class="note">{note}</p>'


def _text(value: float | None) -> str:
    return "–" if value is None else f"{value:.1f}"
