"""Orders over a real ROS graph: processes of stations and couriers, and fake robots."""

import json
import subprocess
import sys
from collections import Counter

import pytest

from tests.graph.test_missions import ENVIRONMENT, SITES, Runner

MISSION = """
groups: {ends: [loader_1, loader_2]}
orders:
  - {from: ends, to: shipping, shifts: [{begin: 0, end: 12, every: 1}], service: 0.5}
"""
STATIONS = ("loader_1", "loader_2", "shipping")
COUNT = 4
ORDERS = 12


@pytest.fixture
def robots():
    """Start four fake robots."""
    command = (sys.executable, "-m", "tests.fakes.ros_robots", str(COUNT), "--mute", "Srobot3")
    process = subprocess.Popen(command, env=ENVIRONMENT, stdout=subprocess.PIPE)
    assert process.stdout.readline() == b"ready\n"
    yield process
    process.terminate()
    process.communicate(timeout=20)


class Party(Runner):
    """The process of a station, or of a robot's courier."""

    def __init__(self, folder, kind, number, **config):
        parties = {f"station_{i}": [name] for i, name in enumerate(STATIONS, 1)}
        parties |= {f"courier_{i}": [f"Srobot{i}"] for i in range(1, COUNT + 1)}
        common = {
            "number": number, "mission": str(folder / "orders.yaml"), "sites": str(SITES),
            "party": f"{kind}_{number}", "parties": parties, "ends_with": [],
        }  # fmt: skip
        path = folder / f"{kind}_{number}.json"
        path.write_text(json.dumps(config | common | {"seed": 0, "loss": 0.1, "delay": 0.2}))
        super().__init__(path, f"swarm_commander.mission.{kind}")


@pytest.mark.usefixtures("robots")
def test_four_robots_do_every_order_once_though_one_falls_silent(tmp_path):
    (tmp_path / "orders.yaml").write_text(MISSION)
    stations = [Party(tmp_path, "station", i, station=n) for i, n in enumerate(STATIONS, 1)]
    couriers = [
        Party(
            tmp_path, "courier", number, map="", radius=0.2, is_in_step=False,
            robots={f"Srobot{number}": {"home": [0.0, 0.0, 0.0], "speed": 0.26}},
        )
        for number in range(1, COUNT + 1)
    ]  # fmt: skip
    *origins, target = stations
    try:
        told = [event for each in origins for event in each.events_until("station_done")]
        target.process.terminate()
        output, _ = target.process.communicate(timeout=10)
        told += [json.loads(line) for line in output.splitlines()]
    finally:
        for process in (*couriers, *stations):
            process.close()
    happened = [each for event in told for each in event.get("events", ())]
    counts = Counter((each["what"], each["order"]) for each in happened)
    received = [order for what, order in counts if what == "received"]
    assert len(received) == ORDERS
    assert {counts["received", order] for order in received} == {1}
    assert any(what == "taken_back" for what, _ in counts)  # of the silent one
