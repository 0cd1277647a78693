"""The reading of a battery as sensor_msgs/BatteryState, which the world sends once a second."""

from __future__ import annotations

import math

from sensor_msgs.msg import BatteryState

from swarm_common.middleware import ros_io
from swarm_common.middleware.rejections import RejectedError
from swarm_common.model.battery import BatteryReading, BatterySpec, SupplyStatus
from swarm_common.model.records import tick_from_stamp

NAME = "battery_state"  # of the topic


def battery_message(reading: BatteryReading, battery: BatterySpec) -> BatteryState:
    """Return the message of a reading; charges are in Ah at the battery's voltage."""
    capacity = battery.capacity / battery.voltage
    message = BatteryState(header=ros_io.header(reading.tick, ""), present=True)
    message.voltage = battery.voltage
    message.temperature = math.nan
    message.current = reading.power / battery.voltage
    message.charge = reading.share * capacity
    message.capacity = message.design_capacity = capacity
    message.percentage = reading.share
    message.power_supply_status = int(reading.status)
    message.power_supply_health = BatteryState.POWER_SUPPLY_HEALTH_GOOD
    return message


def read_battery(data: bytes) -> BatteryReading:
    """Return the reading in a message."""
    message = ros_io.unpacked(data, BatteryState)
    share = float(message.percentage)
    if not 0.0 <= share <= 1.0:
        raise RejectedError(f"percentage is {share:g}; expected 0 to 1")
    status = int(message.power_supply_status)
    is_known = status in (SupplyStatus.CHARGING, SupplyStatus.FULL)
    return BatteryReading(
        tick=tick_from_stamp(message.header.stamp.sec, message.header.stamp.nanosec),
        share=share,
        power=float(message.current) * float(message.voltage),
        status=SupplyStatus(status) if is_known else SupplyStatus.DISCHARGING,
    )
