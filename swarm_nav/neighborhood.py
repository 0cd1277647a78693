"""What a robot knows of the others, from their beacons alone."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from swarm_common.beacon import BEACON_DTYPE, FLAG_STUCK, BeaconArray
from swarm_nav.config import TrafficConfig

MAX_SPEED = 0.52  # [m/s] at which two robots can part
INITIAL_ROWS = 32


class Neighborhood:
    """The newest beacon of every robot heard, with its age and whether the robot is gone.

    A robot that is not heard for `lost_ticks` has left the radio range if it was last heard near
    the range's edge. If it was heard well inside, it is *gone* (dead or mute): it stays an
    obstacle at the space that it last held or requested, until it is heard again.
    """

    def __init__(self, own_id: int, config: TrafficConfig) -> None:
        """Start knowing nobody."""
        self._own_id = own_id
        self._config = config
        self._table: BeaconArray = np.zeros(INITIAL_ROWS, BEACON_DTYPE)
        self._row_of: dict[int, int] = {}
        self._distance: dict[int, float] = {}
        self.beacons: BeaconArray = self._table[:0]
        self.ages: NDArray[np.int64] = np.zeros(0, np.int64)
        self.gone: NDArray[np.bool_] = np.zeros(0, np.bool_)
        self.priorities: NDArray[np.int64] = np.zeros(0, np.int64)
        self.batch_tick = -1

    def receive(self, beacons: BeaconArray, x: float, y: float) -> None:
        """Store a batch; (x, y) is the own position in map."""
        rows = []
        for beacon_id, pose in zip(beacons["id"].tolist(), beacons["pose"].tolist(), strict=True):
            row = self._row_of.get(beacon_id)
            if row is None:
                row = self._new_row(beacon_id)
            rows.append(row)
            self._distance[beacon_id] = math.hypot(pose[0] - x, pose[1] - y)
        if rows:
            self._table[rows] = beacons

    def refresh(self, tick: int) -> None:
        """Work out ages at `tick` and forget those who left."""
        config = self._config
        edge = config.radio_range - 2.0 * MAX_SPEED * config.lost_ticks * 0.1
        ids = sorted(self._row_of)
        ages = {i: tick - int(self._table[self._row_of[i]]["tick"]) for i in ids}
        for i in ids:
            if ages[i] > config.lost_ticks and self._distance[i] > edge:
                del self._row_of[i], self._distance[i]
        ids = [i for i in ids if i in self._row_of]
        self.beacons = self._table[[self._row_of[i] for i in ids]]
        self.ages = np.array([ages[i] for i in ids], np.int64)
        self.gone = self.ages > config.lost_ticks
        words = self.beacons["priority"].astype(np.int64)
        self.priorities = (words[:, 0] << 32) | words[:, 1]

    @property
    def ids(self) -> NDArray[np.uint32]:
        """Ids of all known robots, ascending."""
        return self.beacons["id"]

    @property
    def stuck(self) -> NDArray[np.bool_]:
        """Robots that said that they cannot make way, and those that are gone."""
        return ((self.beacons["flags"] & FLAG_STUCK) > 0) | self.gone

    def claims(self) -> tuple[NDArray[np.generic], ...]:
        """Return the columns that `tube_kernels.extend` reads."""
        b = self.beacons
        return (
            b["id"],
            self.ages,
            self.gone,
            self.priorities,
            b["radius"],
            b["blocked_ticks"],
            b["held"],
            b["held_size"],
            b["wanted"],
            b["wanted_size"],
            b["intent"],
            b["intent_size"],
        )

    def row(self, robot_id: int) -> int | None:
        """Return the row of a robot, None if it is not known."""
        found = np.flatnonzero(self.beacons["id"] == robot_id)
        return int(found[0]) if len(found) else None

    def tubes(self, row: int) -> NDArray[np.float32]:
        """Return the held points (n, 2) of one robot, with what it requested if it is gone."""
        beacon = self.beacons[row]
        held: NDArray[np.float32] = beacon["held"][: beacon["held_size"]]
        if not self.gone[row]:
            return held
        return np.vstack((held, beacon["wanted"][: beacon["wanted_size"]]))

    def _new_row(self, robot_id: int) -> int:
        used = set(self._row_of.values())
        row = next(k for k in range(len(used) + 1) if k not in used)
        if row >= len(self._table):
            self._table = np.concatenate((self._table, np.zeros_like(self._table)))
        self._row_of[robot_id] = row
        return row
