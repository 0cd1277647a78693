"""Collects what belongs to one control tick: odometry, neighbours, scan and battery when due."""

from __future__ import annotations

from dataclasses import dataclass

from swarm_common.model.battery import READING_TICKS, BatteryReading
from swarm_common.model.beacon import BeaconArray
from swarm_common.model.records import Odometry, Scan

MAX_OPEN = 50  # incomplete ticks kept; more than that were lost


@dataclass(slots=True)
class TickInput:
    """Inputs that have arrived for a tick."""

    tick: int
    odom: Odometry | None = None
    scan: Scan | None = None
    neighbors: BeaconArray | None = None
    battery: BatteryReading | None = None


class TickInputs:
    """The topics of a tick arrive in any order; a tick is complete when all are there."""

    def __init__(self, scan_every: int, *, has_battery: bool = False) -> None:
        """Start before the first tick.

        Args:
            scan_every: Control ticks from one scan to the next; 0 for a world without LiDAR.
            has_battery: Whether there is a reading of the battery once a second.
        """
        self._battery_every = READING_TICKS if has_battery else 0
        self._scan_every = scan_every
        self._open: dict[int, TickInput] = {}
        self.last_tick = -1  # newest tick that was complete

    def is_repeat(self, tick: int) -> bool:
        """Whether a message belongs to the newest complete tick, that is, asks for it again."""
        return tick == self.last_tick

    @property
    def is_settled(self) -> bool:
        """Whether nothing has come of ticks after the newest complete one."""
        return self.last_tick >= 0 and not self._open

    @property
    def missing(self) -> str:
        """Name of the input that the newest tick lacks; of several, the one that is sent last."""
        newest = self._open[max(self._open)] if self._open else None
        if newest is None or newest.neighbors is None:
            return "neighbors"
        if self._lacks_battery(newest):
            return "battery_state"
        return "scan" if self._lacks_scan(newest) else "odom"

    def add_odom(self, odom: Odometry) -> TickInput | None:
        """Receive an odometry; ticks that are over are ignored.

        Returns:
            The inputs of its tick, if that is complete now; else None.
        """
        return self._set(odom.tick, "odom", odom)

    def add_scan(self, scan: Scan) -> TickInput | None:
        """Receive a scan; ticks that are over are ignored.

        Returns:
            The inputs of its tick, if that is complete now; else None.
        """
        return self._set(scan.tick, "scan", scan)

    def add_battery(self, reading: BatteryReading) -> TickInput | None:
        """Receive a reading of the battery; ticks that are over are ignored.

        Returns:
            The inputs of its tick, if that is complete now; else None.
        """
        return self._set(reading.tick, "battery", reading)

    def add_neighbors(self, tick: int, beacons: BeaconArray) -> TickInput | None:
        """Receive the radio's batch; ticks that are over are ignored.

        Args:
            beacons: (n,) by ascending id; n may be 0.

        Returns:
            The inputs of that tick, if it is complete now; else None.
        """
        return self._set(tick, "neighbors", beacons)

    def _set(self, tick: int, name: str, value: object) -> TickInput | None:
        if tick <= self.last_tick:
            return None
        entry = self._open.setdefault(tick, TickInput(tick))
        setattr(entry, name, value)
        is_sensed = not (self._lacks_scan(entry) or self._lacks_battery(entry))
        if entry.odom is None or entry.neighbors is None or not is_sensed:
            self._limit()
            return None
        self.last_tick = tick
        del self._open[tick]
        if self._open:
            self._open = {other: item for other, item in self._open.items() if other > tick}
        return entry

    def _lacks_scan(self, entry: TickInput) -> bool:
        is_due = self._scan_every > 0 and entry.tick % self._scan_every == 0
        return is_due and entry.scan is None

    def _lacks_battery(self, entry: TickInput) -> bool:
        is_due = self._battery_every > 0 and entry.tick % self._battery_every == 0
        return is_due and entry.battery is None

    def _limit(self) -> None:
        while len(self._open) > MAX_OPEN:
            del self._open[min(self._open)]
