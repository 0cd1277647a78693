"""What is certain about energy before a run: refused, or said."""

import dataclasses
import math

import pytest

from swarm_common.model.battery import BatterySpec
from swarm_common.model.errors import ConfigError
from swarm_common.model.records import Pose
from swarm_common.model.sites import Sites
from swarm_describe.robots.loading import load_robot
from swarm_mission.energy import check_energy, least_energy
from swarm_mission.leg import Stop

BATTERY = BatterySpec(
    capacity=1.0, voltage=12.0, idle_power=5.0, drive_power=10.0, charge_power=60.0
)
WAFFLE = load_robot("turtlebot3_waffle")
SPEC = dataclasses.replace(WAFFLE, max_vel_x=0.25, battery=BATTERY)
UNKNOWN = Pose(math.nan, math.nan, math.nan)


def stops(*xs, pause=0):
    return [Stop("s", Pose(x, 0.0, 0.0), pause) for x in xs]


def test_the_least_energy_beyond_one_charge_needs_a_station():
    # 120 m at 0.25 m/s: 480 s at 7.5 W; three pauses of 10 s at 5 W: 3750 J
    assert least_energy(BATTERY, 0.25, stops(0, 60, 0, pause=100)) == pytest.approx(3750.0 / 3600.0)
    home = [*stops(0, 60), Stop("home", UNKNOWN, 0)]
    assert least_energy(BATTERY, 0.25, home) == pytest.approx(1800.0 / 3600.0)
    route = {"Srobot2": stops(0, 60, 0, 60)}
    with pytest.raises(
        ConfigError, match=r"sites.yaml: Srobot2 needs 1.5 Wh.*holds 1 Wh.*charging"
    ):
        check_energy({"Srobot1": WAFFLE, "Srobot2": SPEC}, route, Sites(), "sites.yaml")
    sites = Sites(stations={"c": Pose(0.0, 0.0, 0.0)}, charging=("c",))
    assert check_energy({"Srobot2": SPEC}, route, sites, "sites.yaml") == []


def test_chargers_that_lack_or_give_too_little_are_told():
    (remark,) = check_energy({"Srobot1": SPEC}, {"Srobot1": stops(0, 60)}, Sites(), "sites.yaml")
    assert "Srobot1 stands still after 12 min" in remark
    assert "charging: [charger_1]" in remark
    assert check_energy({"Srobot1": WAFFLE}, {}, Sites(), "sites.yaml") == []
    sites = Sites(stations={"c": Pose(0.0, 0.0, 0.0)}, charging=("c",))
    robots = {f"Srobot{k}": SPEC for k in range(1, 13)}
    (remark,) = check_energy(robots, {}, sites, "sites.yaml")
    assert "12 robots draw 60 W at rest and 1 charging stations give 60 W" in remark
