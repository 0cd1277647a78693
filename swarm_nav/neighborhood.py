"""What a robot knows of the others, from their beacons alone."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from swarm_common.beacon import BEACON_DTYPE, FLAG_ACTIVE, FLAG_STUCK, BeaconArray
from swarm_common.records import CONTROL_PERIOD
from swarm_nav.config import TrafficConfig

STOPPING_POINTS = 5  # held points, the pose first, on which a drive without commands stops
MAX_SPEED = 0.52  # [m/s] at which two robots can part
INITIAL_ROWS = 32
CLAIM_COLUMNS = (
    "id",
    "radius",
    "blocked_ticks",
    "held",
    "held_size",
    "wanted",
    "wanted_size",
    "intent",
    "intent_size",
)


class Neighborhood:
    """The newest beacon of every robot heard, with its age and whether the robot is gone.

    A robot that is not heard for `lost_ticks` has left the radio range if it was last heard near
    the range's edge. If it was heard well inside, it is *gone* (dead or mute): it stays an
    obstacle at the space that it last held or requested, until it is heard again; once it has
    been silent for `dead_ticks`, at the place where it stopped.
    """

    def __init__(self, own_id: int, config: TrafficConfig) -> None:
        """Start knowing nobody."""
        self._own_id = own_id
        self._config = config
        # indexed by robot id
        self._table: BeaconArray = np.zeros(INITIAL_ROWS, BEACON_DTYPE)
        self._is_known: NDArray[np.bool_] = np.zeros(INITIAL_ROWS, np.bool_)
        self._distance: NDArray[np.float64] = np.zeros(INITIAL_ROWS)
        self.beacons: BeaconArray = self._table[:0]
        self.ages: NDArray[np.int64] = np.zeros(0, np.int64)
        self.gone: NDArray[np.bool_] = np.zeros(0, np.bool_)
        self.priorities: NDArray[np.int64] = np.zeros(0, np.int64)

    def configure(self, config: TrafficConfig) -> None:
        """Take new parameters, effective from the next tick."""
        self._config = config

    def receive(self, beacons: BeaconArray, x: float, y: float) -> None:
        """Store a batch; (x, y) is the own position in map."""
        if len(beacons) == 0:
            return
        ids = beacons["id"]
        highest = int(ids.max())
        if highest >= len(self._table):
            self._grow(highest + 1)
        self._table[ids] = beacons
        self._is_known[ids] = True
        pose = beacons["pose"]
        self._distance[ids] = np.hypot(pose[:, 0] - x, pose[:, 1] - y)

    def refresh(self, tick: int) -> None:
        """Work out ages at `tick` and forget those who left."""
        config = self._config
        edge = config.radio_range - 2.0 * MAX_SPEED * config.lost_ticks * CONTROL_PERIOD
        ids = np.flatnonzero(self._is_known)
        ages = tick - self._table["tick"][ids].astype(np.int64)
        has_left = (ages > config.lost_ticks) & (self._distance[ids] > edge)
        if has_left.any():
            self._is_known[ids[has_left]] = False
            ids, ages = ids[~has_left], ages[~has_left]
        self.beacons = self._table[ids]
        self.ages = ages
        self.gone = ages > config.lost_ticks
        self._settle_dead(ages > config.dead_ticks)
        words = self.beacons["priority"].astype(np.int64)
        self.priorities = (words[:, 0] << 32) | words[:, 1]

    def _settle_dead(self, is_dead: NDArray[np.bool_]) -> None:
        """Shrink the space of robots silent for long to where they can have come to a stop.

        A drive without commands stops after half a second, within the first points of the held
        tube. What the robot held or requested beyond would close a station next to it for ever.
        """
        sizes = self.beacons["held_size"]
        self.beacons["held_size"] = np.where(is_dead, np.minimum(sizes, STOPPING_POINTS), sizes)
        self.beacons["wanted_size"] = np.where(is_dead, 0, self.beacons["wanted_size"])

    @property
    def ids(self) -> NDArray[np.uint32]:
        """Ids of all known robots, ascending."""
        return self.beacons["id"]

    @property
    def stuck(self) -> NDArray[np.bool_]:
        """Robots that said that they cannot make way, and those that will not."""
        return ((self.beacons["flags"] & FLAG_STUCK) > 0) | self.immovable

    @property
    def immovable(self) -> NDArray[np.bool_]:
        """Robots that nobody can push: gone ones and those whose navigator is inactive."""
        is_inactive: NDArray[np.bool_] = (self.beacons["flags"] & FLAG_ACTIVE) == 0
        return self.gone | is_inactive

    def claims(self) -> tuple[NDArray[np.generic], ...]:
        """Return the columns that `tube_kernels.extend` reads.

        They are contiguous for any number of rows: a view of one field is so for one row only,
        and numba would compile the kernels a second time, in each robot.
        """
        columns = [np.ascontiguousarray(self.beacons[name]) for name in CLAIM_COLUMNS]
        return (columns[0], self.ages, self.gone, self.priorities, *columns[1:])

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

    def _grow(self, rows: int) -> None:
        """Make room for ids below `rows`, at least doubling."""
        more = max(rows - len(self._table), len(self._table))
        self._table = np.concatenate((self._table, np.zeros(more, BEACON_DTYPE)))
        self._is_known = np.concatenate((self._is_known, np.zeros(more, np.bool_)))
        self._distance = np.concatenate((self._distance, np.zeros(more)))
