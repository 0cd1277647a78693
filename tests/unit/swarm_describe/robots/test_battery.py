"""The section `battery:` of robot.yaml and fleets: what is taken, and what is refused."""

import pytest

from swarm_common.model.errors import SwarmError
from swarm_common.model.robot_parameters import robot_from_parameters, robot_parameters
from swarm_describe.robots.fleet import load_fleet
from swarm_describe.robots.loading import load_robot
from swarm_describe.robots.spec import parse_battery
from tests.fakes.charging import waffle_with_battery

FLEET = """
groups:
  - {model: MODEL, count: 1}
  - {model: MODEL, count: 1, battery: {capacity: 2.0, initial: 0.5}}
"""


def test_a_robots_battery_is_read_and_none_has_no_parameters(tmp_path):
    spec = load_robot(str(waffle_with_battery(tmp_path)))
    assert (spec.battery.capacity, spec.battery.initial) == (1.0, (0.4, 0.8))
    found = robot_from_parameters(robot_parameters(spec)).battery
    assert found.charge_power == 90.0
    assert found.initial == (1.0, 1.0)  # where a robot starts is the world's business
    spec = load_robot("turtlebot3_waffle")
    assert spec.battery is None
    assert not [name for name in robot_parameters(spec) if name.startswith("battery")]
    assert robot_from_parameters(robot_parameters(spec)).battery is None


def test_a_fleets_group_changes_the_battery_or_says_all_of_it(tmp_path):
    model = waffle_with_battery(tmp_path)
    (tmp_path / "fleet.yaml").write_text(FLEET.replace("MODEL", str(model)), "utf-8")
    first, second = (member.spec.battery for member in load_fleet(tmp_path / "fleet.yaml").members)
    assert (first.capacity, second.capacity, second.initial) == (1.0, 2.0, (0.5, 0.5))
    assert second.charge_power == first.charge_power
    text = FLEET.replace("MODEL", "turtlebot3_waffle")
    (tmp_path / "fleet.yaml").write_text(text, "utf-8")
    with pytest.raises(SwarmError, match=r"groups\[1\]: battery lacks voltage, idle_power"):
        load_fleet(tmp_path / "fleet.yaml")


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"capacity": 0}, "battery.capacity is 0; expected a number, more than 0"),
        ({"idle_power": -5.0}, "battery.idle_power is -5.0; expected a number, 0 or more"),
        ({"initial": 0.0}, "battery: initial is 0 to 0; expected a share"),
        ({"initial": 80}, "battery: initial is 80 to 80; expected a share"),
        ({"initial": [0.9, 0.4]}, "battery: initial is 0.9 to 0.4; expected a share"),
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
