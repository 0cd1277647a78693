"""The radio: which robots hear which beacons at a tick, with range, loss and delay.

Whether a message is lost depends only on (seed, tick, sender, receiver), so that no order of
arrival and no other random number can change it.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from swarm_common.model.beacon import (
    BEACON_DTYPE,
    BEACON_WORDS,
    FLAG_DEAF,
    FLAG_LEFT,
    FLAG_STUCK,
    BeaconArray,
    Reception,
    word_of,
)
from swarm_common.model.errors import ConfigError
from swarm_common.model.records import CONTROL_PERIOD, FloatArray, Pose, stamp_from_tick
from swarm_sim.sensing import radio_kernels

FAREWELL_TICKS = 50  # for which all are told that a robot was removed; late robots hear it, too
ID = word_of("id")
KEPT = ("id", "radius", "priority", "footprint_size", "footprint")  # of a robot that was moved


@dataclass(frozen=True, slots=True, kw_only=True)
class RadioConfig:
    """Quality of the radio; `radio:` of the world."""

    range: float = 6.0  # [m] between the centres of two robots
    loss: float = 0.0  # share of the messages that are lost, each receiver on its own
    delay: float = 0.0  # [s] in addition to the one tick that a beacon always takes

    def __post_init__(self) -> None:
        if not self.range > 0.0:
            raise ConfigError(f"radio.range is {self.range} m; it must be positive")
        if not 0.0 <= self.loss <= 1.0:
            raise ConfigError(f"radio.loss is {self.loss}; it must lie between 0 and 1")
        if not 0.0 <= self.delay < math.inf:
            raise ConfigError(f"radio.delay is {self.delay} s; it must not be negative")


class Radio:
    """Keeps the beacons in transit and decides which robot hears which."""

    def __init__(self, config: RadioConfig, count: int, seed: int) -> None:
        self._config = config
        self._count = count
        self._seed = seed
        delay_ticks = math.ceil(config.delay / CONTROL_PERIOD - 1e-9)
        silence = _Wave(np.zeros((0, BEACON_WORDS), np.uint32), np.zeros((count, 0), np.bool_), 0)
        self._farewells: dict[int, int] = {}  # ticks until which they are sent, by id
        self._stand_ins: dict[int, tuple[int, np.void]] = {}  # index and beacon, by id
        self._under_way: deque[_Wave] = deque([silence] * (delay_ticks + 1))

    def add(self) -> None:
        """Add a robot; it has not heard anything yet."""
        self._count += 1
        for wave in self._under_way:
            wave.add_receiver()

    def forget(self, robot_id: int, tick: int) -> None:
        """Remove a robot: its beacons in transit are lost, and all are told that it holds no space.

        The radio tells every robot, regardless of range and losses, because a robot that only
        fell silent would stay an obstacle to the others for ever.
        """
        self._silence(robot_id)
        self._farewells[robot_id] = tick + FAREWELL_TICKS

    def speak_for(self, robot: int, beacon: np.void) -> None:
        """Send a robot's beacon to all others until it is welcome; its own in transit are lost.

        A robot that was put elsewhere does not know at once. Meanwhile it tells nobody where it
        stands, and others' LiDARs may look over it.
        """
        robot_id = int(beacon["id"])
        self._silence(robot_id)
        self._stand_ins[robot_id] = robot, beacon

    def welcome(self, robot_id: int) -> None:
        """Let a robot speak for itself: it is there again, or knows where it is."""
        self._farewells.pop(robot_id, None)
        self._stand_ins.pop(robot_id, None)

    def _silence(self, robot_id: int) -> None:
        self.welcome(robot_id)
        for wave in self._under_way:
            wave.drop(robot_id)

    def send(self, tick: int, beacons: Sequence[np.void | None], positions: FloatArray) -> None:
        """Accept the beacons that robots send at a tick; ends the tick."""
        senders = np.array([i for i, b in enumerate(beacons) if b is not None], np.int64)
        joined = b"".join([b.tobytes() for b in beacons if b is not None])
        order = np.argsort(np.frombuffer(joined, BEACON_DTYPE)["id"], kind="stable")
        # As plain words: numpy copies records of many members member by member.
        sent = np.frombuffer(joined, np.uint32).reshape(len(senders), BEACON_WORDS)[order]
        heard = np.empty((self._count, len(senders)), np.bool_)
        config = self._config
        count = radio_kernels.listen(
            positions, senders[order], config.range, config.loss, self._seed, tick, heard
        )
        self._under_way.popleft()
        wave = _Wave(sent, heard, count)
        if self._farewells or self._stand_ins:
            spoken_for = [robot for robot, _ in self._stand_ins.values()]
            wave.add_for_all(self._announcements(tick), spoken_for)
        self._under_way.append(wave)

    def _announcements(self, tick: int) -> NDArray[np.uint32]:
        """Return the beacons (s, words) of robots that were taken out or are spoken for."""
        self._farewells = {i: last for i, last in self._farewells.items() if tick <= last}
        count = len(self._farewells)
        beacons = np.zeros(count + len(self._stand_ins), BEACON_DTYPE)
        beacons["id"][:count], beacons["flags"][:count] = list(self._farewells), FLAG_LEFT
        for row, (_, beacon) in enumerate(self._stand_ins.values(), count):
            beacons[row] = beacon
        beacons["sec"], beacons["nanosec"] = stamp_from_tick(tick)
        beacons["tick"] = tick
        return beacons.view(np.uint32).reshape(-1, BEACON_WORDS)

    def reception(self, receiver: int) -> Reception:
        """Return the beacons that reach a robot at the present tick, ordered by id."""
        return self._under_way[0].reception(receiver)

    def heard(self, receiver: int) -> BeaconArray:
        """Return the same, copied."""
        return self.reception(receiver).beacons


def standing_beacon(last: np.void, pose: Pose) -> np.void:
    """Return the beacon of a robot that stands, inactive and deaf, and claims its place only.

    Args:
        last: Gives radius, priority and footprint.
        pose: Of base_footprint in map.
    """
    beacon = np.zeros(1, BEACON_DTYPE)
    for name in KEPT:
        beacon[name] = last[name]
    beacon["flags"] = FLAG_DEAF | FLAG_STUCK
    beacon["pose"] = pose.x, pose.y, pose.yaw
    beacon["held"][:, 0], beacon["held_size"] = (pose.x, pose.y), 1
    beacon["target"] = beacon["station"] = math.nan
    made: np.void = beacon[0]
    return made


class _Wave:
    """The beacons sent at one tick, and their receivers."""

    def __init__(self, sent: NDArray[np.uint32], heard: NDArray[np.bool_], count: int) -> None:
        """Keep what was sent.

        Args:
            sent: Beacons (s, words), ordered by id.
            heard: (n, s) whether robot n hears beacon s.
            count: Number of true entries of `heard`.
        """
        self._sent = sent
        self._heard = heard
        self._count = count
        self._starts: list[int] = []
        self._rows: NDArray[np.int64] = np.zeros(0, np.int64)

    def add_receiver(self) -> None:
        """Add a robot that hears none of these beacons."""
        self._heard = np.vstack([self._heard, np.zeros((1, len(self._sent)), np.bool_)])
        self._starts = []

    def drop(self, robot_id: int) -> None:
        """Let nobody hear a robot."""
        self._take(self._sent[:, ID] != robot_id)

    def add_for_all(self, beacons: NDArray[np.uint32], spoken_for: Sequence[int]) -> None:
        """Let everybody hear further beacons, too, but nobody its own.

        Args:
            beacons: (k, words) in any order, those of the robots that are spoken for last.
            spoken_for: Their indices.
        """
        self._sent = np.vstack([self._sent, beacons])
        everybody = np.ones((len(self._heard), len(beacons)), np.bool_)
        everybody[spoken_for, range(len(beacons) - len(spoken_for), len(beacons))] = False
        self._heard = np.hstack([self._heard, everybody])
        self._take(np.argsort(self._sent[:, ID], kind="stable"))

    def _take(self, columns: NDArray[np.generic]) -> None:
        self._sent = np.ascontiguousarray(self._sent[columns])
        self._heard = np.ascontiguousarray(self._heard[:, columns])
        self._count = int(self._heard.sum())
        self._starts = []

    def reception(self, receiver: int) -> Reception:
        """Return the beacons that one robot hears; the first call makes the lists of all robots."""
        if not self._starts:
            starts = np.empty(len(self._heard) + 1, np.int64)
            self._rows = np.empty(self._count, np.int64)
            radio_kernels.rows_heard(self._heard, starts, self._rows)
            self._starts = starts.tolist()
        return Reception(
            self._sent, self._rows[self._starts[receiver] : self._starts[receiver + 1]]
        )
