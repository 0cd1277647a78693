"""The batteries of all robots that have one: charge over simulated time, vectorised over robots."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from swarm_common.model.battery import (
    CHARGING_REACH,
    READING_TICKS,
    BatteryReading,
    BatterySpec,
    SupplyStatus,
)
from swarm_common.model.records import CONTROL_PERIOD, FloatArray, Mask, Pose, Twist
from swarm_sim.scene.randomness import hash_words, uniform

CHARGE_WORD = 307  # what a random number is for
STANDING = 0.02, 0.1  # [m/s], [rad/s] up to which a robot stands


@dataclass(frozen=True, slots=True)
class BatteryVerdict:
    """Charge and use of a robot's battery in a run."""

    least: float  # smallest charge, as a share of the capacity
    final: float  # charge at the end, likewise
    charges: int  # stays at a charging station
    charging_time: float  # [s] of them
    energy_used: float  # [Wh] taken out of the battery
    empty_at: float | None  # [s] when it was empty; None if it never was


class Batteries:
    """Charge, consumption and stays at charging stations; a row for each robot with a battery.

    A robot whose battery is empty stays where it is for the rest of the run.
    """

    def __init__(
        self, batteries: Sequence[BatterySpec | None], chargers: Sequence[Pose], seed: int
    ) -> None:
        """Charge the batteries for the start.

        Args:
            batteries: One per robot, None for a robot without.
            chargers: Charging stations in map.
        """
        self._chargers = np.array([(pose.x, pose.y) for pose in chargers]).reshape(-1, 2)
        self._seed = seed
        self._robots: NDArray[np.intp] = np.zeros(0, np.intp)
        self._rows: dict[int, int] = {}  # by robot
        self._capacity, self._charge, self._rate = (np.zeros(0) for _ in range(3))  # [J], [J], [W]
        self._draw: FloatArray = np.zeros((0, 3))  # [W], [W per m/s], [W per rad/s]
        self._least, self._used, self._empty_at = (np.zeros(0) for _ in range(3))  # [J], [J], [s]
        self._power = np.zeros(0)  # [W] into each battery in the last tick
        self._stay, self._stays, self._charges = (np.zeros(0, np.int64) for _ in range(3))  # ticks
        self._is_present: Mask = np.zeros(0, bool)
        for robot, spec in enumerate(batteries):
            self.add(robot, spec)

    def __len__(self) -> int:
        return len(self._robots)

    def add(self, robot: int, spec: BatterySpec | None) -> None:
        """Add a robot."""
        if spec is None:
            return
        low, high = spec.initial
        drawn = float(uniform(hash_words(self._seed, CHARGE_WORD, robot)))
        charge = spec.joules * (low + (high - low) * drawn)
        self._rows[robot] = len(self)
        self._robots = np.append(self._robots, robot)
        self._capacity = np.append(self._capacity, spec.joules)
        self._charge = np.append(self._charge, charge)
        self._least = np.append(self._least, charge)
        self._rate = np.append(self._rate, spec.charge_power)
        rates = (spec.idle_power, spec.drive_power, spec.turn_power)
        self._draw = np.vstack([self._draw, rates])
        self._used = np.append(self._used, 0.0)
        self._empty_at = np.append(self._empty_at, np.inf)
        self._power = np.append(self._power, -spec.idle_power)
        self._stay, self._stays, self._charges = (
            np.append(ticks, 0) for ticks in (self._stay, self._stays, self._charges)
        )
        self._is_present = np.append(self._is_present, True)

    def set_present(self, robot: int, is_present: bool) -> None:
        """Record that a robot was taken out of the world, or has come back as it went."""
        if robot in self._rows:
            self._is_present[self._rows[robot]] = is_present

    def update(self, tick: int, poses: FloatArray, twists: FloatArray) -> None:
        """Let one control period pass."""
        places, twist = poses[self._robots, :2], twists[self._robots]
        speed, turn = np.hypot(twist[:, 0], twist[:, 2]), np.abs(twist[:, 1])
        stands = self._is_present & (speed <= STANDING[0]) & (turn <= STANDING[1])
        is_live = self._is_present & np.isinf(self._empty_at)
        charged = self._charged(places, stands & is_live)
        draw = self._draw[:, 0] + self._draw[:, 1] * speed + self._draw[:, 2] * turn
        change = np.where(charged, self._rate, -draw) * is_live * CONTROL_PERIOD
        before = self._charge
        self._charge = np.clip(before + change, 0.0, self._capacity)
        self._power = (self._charge - before) / CONTROL_PERIOD
        self._used += np.maximum(before - self._charge, 0.0)
        self._least = np.minimum(self._least, self._charge)
        self._empty_at[is_live & (self._charge <= 0.0)] = tick * CONTROL_PERIOD
        self._stay = np.where(charged, self._stay + 1, 0)
        self._stays += charged
        self._charges += self._stay == READING_TICKS  # who stops for a moment is on its way

    def _charged(self, places: FloatArray, stands: Mask) -> Mask:
        """Return who is charged (n,): of those that stand at a station, the nearest."""
        charged = np.zeros(len(places), bool)
        if len(self._chargers) and stands.any():
            gaps = np.hypot(*(places[:, None] - self._chargers[None]).transpose(2, 0, 1))
            gaps[~stands] = np.inf
            nearest = gaps.argmin(axis=0)
            charged[nearest[gaps.min(axis=0) <= CHARGING_REACH]] = True
        return charged

    def silenced(
        self, commands: Sequence[Twist | None], beacons: Sequence[np.void | None]
    ) -> tuple[Sequence[Twist | None], Sequence[np.void | None]]:
        """Return commands and beacons, robots whose battery is empty being at rest and mute."""
        is_empty = np.isfinite(self._empty_at)
        if not is_empty.any():
            return commands, beacons
        dead = set(self._robots[is_empty].tolist())
        return (
            [Twist() if robot in dead else item for robot, item in enumerate(commands)],
            [None if robot in dead else item for robot, item in enumerate(beacons)],
        )

    def readings(self, tick: int) -> dict[int, BatteryReading]:
        """Return the reading of each robot with a battery, by its index."""
        return {robot: self._reading(row, tick) for robot, row in self._rows.items()}

    def _reading(self, row: int, tick: int) -> BatteryReading:
        share = self._charge[row] / self._capacity[row]
        status = SupplyStatus.DISCHARGING
        if self._stay[row]:
            status = SupplyStatus.FULL if share >= 1.0 else SupplyStatus.CHARGING
        return BatteryReading(
            tick, float(np.float32(share)), float(np.float32(self._power[row])), status
        )

    def verdict(self, robot: int) -> BatteryVerdict | None:
        """Return the verdict on a robot's battery; None without one."""
        row = self._rows.get(robot)
        if row is None:
            return None
        capacity, empty_at = self._capacity[row], float(self._empty_at[row])
        return BatteryVerdict(
            least=float(self._least[row] / capacity),
            final=float(self._charge[row] / capacity),
            charges=int(self._charges[row]),
            charging_time=float(self._stays[row] * CONTROL_PERIOD),
            energy_used=float(self._used[row] / 3600.0),
            empty_at=empty_at if np.isfinite(empty_at) else None,
        )
