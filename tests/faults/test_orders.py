"""Orders with real navigators: each is done once, though a navigator and a courier are killed."""

import signal

import pytest

pytestmark = pytest.mark.timeout(300)

MISSION = """
groups: {ends: [north_east, south_east]}
orders:
  - {from: ends, to: south_west, shifts: [{begin: 0, end: 12, every: 1.5}], service: 0.5}
"""
RADIO = "/world: {ros__parameters: {radio: {loss: 0.2, delay: 0.2}}}\n"
ORDERS = 8


def test_every_order_is_done_once_though_robots_fail(start, tmp_path):
    (tmp_path / "orders.yaml").write_text(MISSION)
    (tmp_path / "radio.yaml").write_text(RADIO)
    swarm = start(
        "--world", "hall_12", "--swarm-size", "4", "--mission", str(tmp_path / "orders.yaml"),
        "--params", str(tmp_path / "radio.yaml"), "--drive", "planar", "--until-done",
        "--duration", "600", "--speed", "8", "--headless", "--no-report",
    )  # fmt: skip
    swarm.wait_until(lambda: swarm.sim_time() > 4.0)
    assert swarm.send("Srobot2", signal.SIGKILL)
    assert swarm.send("courier", signal.SIGKILL)
    code = swarm.wait_for_end()
    report = swarm.report()
    orders = report["orders"]["orders"]
    assert code == 0, swarm.output
    assert (len(orders), report["orders"]["done"]) == (ORDERS, ORDERS)
    assert {order["receipts"] for order in orders} == {1}
    assert report["orders"]["taken_back"] > 0
    assert len({order["robot"] for order in orders}) > 1
    assert report["restarts"] == 2
    assert report["goals"]["pending"] == 0
