"""The section `battery:` of robot.yaml and fleets: what is taken, and what is refused."""

import pytest

from swarm_common.model.battery import BatterySpec
from swarm_common.model.errors import SwarmError
from swarm_common.model.robot_parameters import robot_from_parameters, robot_parameters
from swarm_describe.robots.fleet import load_fleet
from swarm_describe.robots.loading import load_robot
from swarm_describe.robots.spec import parse_battery
from tests.fakes.charging import BATTERY, waffle_with_battery

FLEET = """
groups:
  - {model: MODEL, count: 1}
  - {model: MODEL, count: 1, battery: {capacity: 2.0, initial: 0.5}}
"""


def test_a_robots_battery_is_read_and_is_among_its_parameters(tmp_path):
    spec = load_robot(str(waffle_with_battery(tmp_path)))
    assert spec.battery is not None
    assert (spec.battery.capacity, spec.battery.initial) == (1.0, (0.4, 0.8))
    found = robot_from_parameters(robot_parameters(spec)).battery
    assert found is not None
    assert found.charge_power == 90.0
    assert found.initial == (1.0, 1.0)  # where a robot starts is the world's business


def test_a_robot_without_a_battery_has_no_parameters_of_one():
    spec = load_robot("turtlebot3_waffle")
    assert spec.battery is None
    assert not [name for name in robot_parameters(spec) if name.startswith("battery")]
    assert robot_from_parameters(robot_parameters(spec)).battery is None


def test_a_group_of_a_fleet_changes_the_battery_of_its_model(tmp_path):
    model = waffle_with_battery(tmp_path)
    (tmp_path / "fleet.yaml").write_text(FLEET.replace("MODEL", str(model)), "utf-8")
    first, second = (member.spec.battery for member in load_fleet(tmp_path / "fleet.yaml").members)
    assert first is not None
    assert second is not None
    assert (first.capacity, second.capacity, second.initial) == (1.0, 2.0, (0.5, 0.5))
    assert second.charge_power == first.charge_power


def test_a_group_whose_model_has_no_battery_must_say_all_of_it(tmp_path):
    text = FLEET.replace("MODEL", "turtlebot3_waffle")
    (tmp_path / "fleet.yaml").write_text(text, "utf-8")
    with pytest.raises(SwarmError, match=r"groups\[1\]: battery lacks voltage, idle_power"):
        load_fleet(tmp_path / "fleet.yaml")


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"capacity": 0}, "battery.capacity is 0; expected a number, more than 0"),
        ({"capacity": -3}, "battery.capacity is -3"),
        ({"voltage": 0.0}, "battery.voltage is 0"),
        ({"idle_power": -5.0}, "battery.idle_power is -5.0; expected a number, 0 or more"),
        ({"drive_power": -1}, "battery.drive_power is -1"),
        ({"turn_power": -1}, "battery.turn_power is -1"),
        ({"charge_power": -60}, "battery.charge_power is -60"),
        ({"charge_power": "60 W"}, "battery.charge_power is '60 W'; expected a number"),
        ({"initial": 0.0}, "battery: initial is 0 to 0; expected a share"),
        ({"initial": 80}, "battery: initial is 80 to 80; expected a share"),
        ({"initial": [0.9, 0.4]}, "battery: initial is 0.9 to 0.4; expected a share"),
        ({"initial": [0.4]}, "battery.initial is"),
        ({"capacty": 1.0}, "capacty"),
        ({"capacity": float("nan")}, "battery.capacity"),
        ({"capacity": True}, "battery.capacity is True"),
    ],
)
def test_a_bad_value_is_one_clear_error(changes, words, tmp_path):
    with pytest.raises(SwarmError) as caught:
        load_robot(str(waffle_with_battery(tmp_path, **changes)))
    assert words in str(caught.value)
    assert "robot.yaml: battery" in str(caught.value)


@pytest.mark.parametrize("data", [None, 3, [], "20 Wh", {}])
def test_what_is_no_battery_is_refused(data):
    with pytest.raises(
        SwarmError, match=r"capacity.*voltage.*idle_power.*drive_power.*charge_power"
    ):
        parse_battery(data, "robot.yaml: battery")


def test_a_way_takes_idle_and_driving_power():
    battery = BatterySpec(**{name: BATTERY[name] for name in BATTERY if name != "initial"})
    # 100 m at 0.25 m/s: 400 s at 5 + 2.5 W are 3000 J of 3600 J
    assert battery.share_of_way(100.0, 0.25) == pytest.approx(3000.0 / 3600.0)
