"""Tables of orders: the same records as in report.json."""

from swarm_mission.orders.floor_use import FloorUse
from swarm_mission.orders.order_book import OrderBook, OrderEvent, OrderEventKind
from swarm_report.orders import order_sections


def test_orders_stations_robots_and_floor_have_a_table_each():
    book = OrderBook("claim", ("240 orders/h need at least 17 robots by distance alone",))
    book.apply_all(
        [
            OrderEvent(OrderEventKind.CREATED, 0, "1-1", "a", target="b", due=250),
            OrderEvent(OrderEventKind.GRANTED, 5, "1-1", "a", "r1"),
            OrderEvent(OrderEventKind.ARRIVED, 100, "1-1", "a", "r1"),
            OrderEvent(OrderEventKind.LOADING, 102, "1-1", "a", "r1", until=132),
            OrderEvent(OrderEventKind.LEFT, 132, "", "a", "r1"),
            OrderEvent(OrderEventKind.ARRIVED, 232, "1-1", "b", "r1"),
            OrderEvent(OrderEventKind.RECEIVED, 233, "1-1", "b", "r1"),
            OrderEvent(OrderEventKind.UNLOADING, 234, "1-1", "b", "r1", until=264),
            OrderEvent(OrderEventKind.CREATED, 200, "1-2", "a", target="b"),
        ]
    )
    floor = FloorUse()
    for tick in range(0, 300, 5):
        floor.note(tick, "r1", 0.02 * tick, 0.5, "driving_loaded" if tick < 200 else "idle")
    results = {**book.as_json(30.0), **floor.as_json()}
    first, second = results["orders"]
    assert (first["lead_time"], first["lateness"], first["service"]) == (26.4, 1.4, 6.0)
    assert second["done"] is None
    station = results["stations"]["a"]
    assert (station["utilisation"], station["occupied"], station["blocked"]) == (0.1, 0.107, 0.007)
    assert (station["queue"], station["queue_worst"]) == (round((102 + 100) / 300, 3), 1)
    assert results["robots"]["r1"] == {
        "driving_empty": 0.0, "driving_loaded": 20.0, "waiting": 0.0, "service": 0.0, "idle": 9.5,
    }  # fmt: skip
    assert [cell["flow"] for cell in results["floor"]["cells"][:2]] == [122.0, 122.0]
    text = "\n".join(order_sections(results))
    for words in ("need at least 17 robots", "1 / 2", "1-1", "26.4", "10.7 %", "67.8 %", "122.0"):
        assert words in text
