"""Orders over a real ROS graph: station processes, the mission process and fake robots."""

from __future__ import annotations

import json
import subprocess
import sys
from collections import Counter
from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.graph.test_missions import ENVIRONMENT, SITES, Runner, config_of

MISSION = """
groups: {ends: [loader_1, loader_2]}
orders:
  - {from: ends, to: shipping, shifts: [{begin: 0, end: 12, every: 1}], service: 0.5}
"""
STATIONS = ("loader_1", "loader_2", "shipping")
COUNT = 8
ORDERS = 12


@pytest.fixture
def robots() -> Iterator[subprocess.Popen[bytes]]:
    """Start eight fake robots."""
    command = (sys.executable, "-m", "tests.fakes.ros_robots", str(COUNT), "--mute", "Srobot3")
    process = subprocess.Popen(command, env=ENVIRONMENT, stdout=subprocess.PIPE)
    assert process.stdout is not None
    assert process.stdout.readline() == b"ready\n"
    yield process
    process.terminate()
    process.communicate(timeout=20)


class Station(Runner):
    """A station's process."""

    def __init__(self, folder: Path, number: int, name: str, mission: Path) -> None:
        config = {
            "station": name,
            "number": number,
            "mission": str(mission),
            "seed": 0,
            "sites": str(SITES),
        }
        path = folder / f"station_{number}.json"
        path.write_text(json.dumps(config | {"loss": 0.1, "delay": 0.2}))
        super().__init__(path, "swarm_commander.mission.station")


@pytest.mark.usefixtures("robots")
def test_eight_robots_do_every_order_once_though_one_falls_silent(tmp_path: Path) -> None:
    mission = tmp_path / "orders.yaml"
    mission.write_text(MISSION)
    names = [f"Srobot{number}" for number in range(1, COUNT + 1)]
    orders = {"map": "", "radius": 0.2, "loss": 0.1, "delay": 0.2}
    config = config_of(
        tmp_path / "mission.json",
        COUNT,
        mission=str(mission),
        mission_file=str(mission),
        orders=orders | {"speeds": dict.fromkeys(names, 0.26)},
    )
    runner = Runner(config, "swarm_commander.mission.runner")
    stations = [Station(tmp_path, i, name, mission) for i, name in enumerate(STATIONS, 1)]
    *origins, target = stations
    try:
        told = [event for each in origins for event in each.events_until("station_done")]
        target.process.terminate()
        output, _ = target.process.communicate(timeout=10)
        told += [json.loads(line) for line in output.splitlines()]
    finally:
        for process in (runner, *stations):
            process.close()
    happened = [each for event in told for each in event.get("events", ())]
    counts = Counter((each["what"], each["order"]) for each in happened)
    received = [order for what, order in counts if what == "received"]
    assert len(received) == ORDERS
    assert {counts["received", order] for order in received} == {1}
    assert any(what == "taken_back" for what, _ in counts)  # of the silent one
