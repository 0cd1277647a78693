"""A robot with a battery on the real graph: its topic, its trip to charge, what it tells."""

import dataclasses
from math import isnan

import pytest
from rclpy.serialization import serialize_message
from sensor_msgs.msg import BatteryState
from swarm_interfaces.msg import RobotStatus

from swarm_common.middleware.rejections import RejectedError
from swarm_common.middleware.ros_io import battery_message, read_battery
from swarm_common.middleware.topic_table import ROBOT_TOPICS
from swarm_common.model.battery import BatteryReading, BatterySpec, SupplyStatus
from tests.fakes.charging import CHARGERS, hall_with_chargers

BATTERY = {
    "capacity": 20.0, "voltage": 11.1, "idle_power": 5.0, "drive_power": 10.0,
    "charge_power": 9000.0, "initial": 0.2,
}  # fmt: skip
READING = BatteryReading(120, 0.25, -6.0, SupplyStatus.DISCHARGING)
SPEC = BatterySpec(**{name: value for name, value in BATTERY.items() if name != "initial"})


@pytest.fixture(scope="module")
def swarm(start_swarm, tmp_path_factory):
    world = hall_with_chargers(
        tmp_path_factory.mktemp("world"),
        spawn={"x_min": 6.0, "x_max": 8.0, "y_min": 2.0, "y_max": 2.0, "pitch": 1.5},
    )
    model = "turtlebot3_waffle"
    robots = [
        {"name": "Srobot1", "model": model, "battery": BATTERY},
        {"name": "Srobot2", "model": model},
    ]
    numbers = {name: value for name, value in BATTERY.items() if name != "initial"}
    started = start_swarm(
        2,
        world={"world": str(world), "robots": robots},
        sites=str(world.with_name("sites.yaml")),
        by_robot={"Srobot1": {f"robot.battery.{name}": value for name, value in numbers.items()}},
    )
    return started


@pytest.mark.timeout(240)
def test_a_robot_tells_its_battery_and_charges_it(swarm):
    states, statuses = [], []
    node = swarm.node
    node.create_subscription(BatteryState, "/Srobot1/battery_state", states.append, 100)
    node.create_subscription(RobotStatus, "/Srobot1/status", statuses.append, 100)
    others = []
    node.create_subscription(RobotStatus, "/Srobot2/status", others.append, 100)
    swarm.wait_until_active()
    swarm.spin_until(lambda: any(status.state == "charging" for status in statuses), 90.0)
    charging = BatteryState.POWER_SUPPLY_STATUS_CHARGING
    swarm.spin_until(lambda: any(s.power_supply_status == charging for s in states), 30.0)
    stamps = [state.header.stamp.sec for state in states]
    fresh = sorted(set(stamps))
    assert fresh == list(range(fresh[0], fresh[-1] + 1))  # once a second, none left out
    assert all(state.header.stamp.nanosec == 0 for state in states)
    first = states[0]
    assert first.power_supply_status == BatteryState.POWER_SUPPLY_STATUS_DISCHARGING
    assert first.present
    assert first.percentage == pytest.approx(0.2, abs=0.01)
    assert first.voltage == pytest.approx(11.1)
    assert first.current < -5.0 / 11.1 + 1e-3
    assert first.capacity == first.design_capacity == pytest.approx(20.0 / 11.1)
    assert first.charge == pytest.approx(first.percentage * first.capacity)
    charged = next(state for state in states if state.power_supply_status == charging)
    assert charged.current > 0.0
    at_charger = next(status for status in statuses if status.state == "charging")
    assert at_charger.station in CHARGERS
    assert 0.15 < at_charger.battery <= 1.0
    swarm.spin_until(lambda: statuses[-1].state != "charging" and statuses[-1].battery >= 0.9, 30.0)
    swarm.spin_until(lambda: others)
    assert isnan(others[-1].battery)


def test_a_robot_without_a_battery_has_no_such_topic_and_other_bytes_are_rejected(swarm):
    assert swarm.node.count_publishers("/Srobot1/battery_state") == 1
    assert swarm.node.count_publishers("/Srobot2/battery_state") == 0
    assert [t.name for t in ROBOT_TOPICS if t.is_optional] == ["battery_state"]
    with pytest.raises(RejectedError):
        read_battery(b"\x00\x01\x00\x00\x05")


@pytest.mark.parametrize("status", SupplyStatus)
def test_a_reading_is_the_same_behind_the_message(status):
    reading = dataclasses.replace(READING, status=status)
    found = read_battery(serialize_message(battery_message(reading, SPEC)))
    assert (found.tick, found.share, found.status) == (reading.tick, reading.share, reading.status)
    assert found.power == pytest.approx(reading.power, rel=1e-6)


@pytest.mark.parametrize("share", [float("nan"), -0.1, 1.5, float("inf")])
def test_a_message_without_a_charge_is_rejected(share):
    message = battery_message(READING, SPEC)
    message.percentage = share
    with pytest.raises(RejectedError, match="percentage"):
        read_battery(serialize_message(message))
