"""A robot's battery: what it holds, what driving takes from it, and what a reading of it says."""

from __future__ import annotations

from dataclasses import dataclass
from enum import IntEnum

from swarm_common.model.errors import ConfigError
from swarm_common.model.schema import NotNegative, Positive, check_fields

# [m] from a charging station within which a robot that stands is charged: as far as targets are
# one station to the queue. A station charges one robot, the nearest.
CHARGING_REACH = 0.6
READING_TICKS = 10  # between two readings: 1 Hz


@dataclass(frozen=True, slots=True, kw_only=True)
class BatterySpec:
    """The section `battery:` of robot.yaml or of a group of a fleet.

    The robot draws idle_power + drive_power·|v| + turn_power·|w|.
    """

    capacity: Positive  # [Wh]
    voltage: Positive  # [V] taken for constant
    idle_power: NotNegative  # [W] of computer, sensors and drives at rest
    drive_power: NotNegative  # [W per m/s] beyond that
    charge_power: Positive  # [W] that a charging station puts into the battery
    turn_power: NotNegative = 0.0  # [W per rad/s]
    initial: tuple[float, float] = (1.0, 1.0)  # charge at the start, as a share: least and most

    def __post_init__(self) -> None:
        check_fields(self)
        low, high = self.initial
        if not 0.0 < low <= high <= 1.0:
            raise ConfigError(
                f"initial is {low:g} to {high:g}; expected a share from above 0 to 1, or [least,"
                " most]"
            )

    @property
    def joules(self) -> float:
        """Capacity [J]."""
        return 3600.0 * self.capacity

    def share_of_way(self, way: float, speed: float) -> float:
        """Return the share of the capacity that a way takes."""
        return way / speed * (self.idle_power + self.drive_power * speed) / self.joules


class SupplyStatus(IntEnum):
    """`power_supply_status` of sensor_msgs/BatteryState, as far as it occurs."""

    CHARGING = 1
    DISCHARGING = 2
    FULL = 4


@dataclass(frozen=True, slots=True)
class BatteryReading:
    """Reading of a robot's battery at a tick; numbers are those of float32."""

    tick: int
    share: float  # charge by capacity, 0 to 1
    power: float  # [W] into the battery; negative while it discharges
    status: SupplyStatus

    @property
    def is_on_charger(self) -> bool:
        """Whether the robot gets current from a charging station, or needs no more."""
        return self.status is not SupplyStatus.DISCHARGING


def charging_time(battery: BatterySpec, share: float) -> float:
    """Return how long [s] a station takes to charge a share of the capacity."""
    return share * battery.joules / battery.charge_power
