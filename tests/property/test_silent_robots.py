"""Property: what robots in a large hall believe of those that they do not hear.

Robots drive anywhere, hang for a while and die; only their beacons and tables are real.
"""

import math
from collections import deque
from dataclasses import dataclass, field

import numpy as np
from hypothesis import HealthCheck, example, given, settings
from hypothesis import strategies as st

from swarm_common.model.beacon import BEACON_WORDS, Reception, empty_beacons, word_of, words_of
from swarm_nav.core.config import TrafficConfig
from swarm_nav.perception.absence import JUDGED_EVERY
from swarm_nav.perception.absence_kernels import (
    DECIDE_TICKS,
    ELSEWHERE,
    PARTED_TICKS,
    nearest_and_farthest,
)
from swarm_nav.perception.neighbor_table import PARKED, NeighborTable

STEP = 0.026  # [m] in a tick
AHEAD = 15  # points of 0.05 m that are held and requested
RANGE = TrafficConfig().radio_range
CERTAINLY_NEAR = 4.2  # [m]
BODIES = 0.5  # [m] between the centres of two robots
POSE, TICK = word_of("pose"), word_of("tick")
DECIDED = TrafficConfig().lost_ticks + DECIDE_TICKS + 2 * JUDGED_EVERY  # ticks

Sighting = tuple[int, float, float]  # tick, x [m], y [m]


@dataclass(frozen=True)
class Plan:
    """One run; chances are per robot and tick."""

    seed: int
    robots: int
    side: float  # [m] of the hall
    loss: float  # share of the beacons
    deaths: float
    hangs: float
    ticks: int = 800


@dataclass
class Robot:
    """Drives straight to one place after the other, sometimes parks, and says so."""

    robot_id: int
    place: np.ndarray
    goal: np.ndarray
    parked_until: int = 0
    hung_until: int = 0
    is_dead: bool = False
    table: NeighborTable = field(init=False)

    def __post_init__(self):
        self.table = NeighborTable(self.robot_id, TrafficConfig())

    def move(self, tick, rng, side):
        """Move; return the points (n, 2) [m] that are held and requested."""
        gap = self.goal - self.place
        length = math.hypot(*gap)
        if length < STEP:
            self.goal = rng.uniform(0.0, side, 2)
            self.parked_until = tick + int(rng.integers(0, 150))
        if length < STEP or tick < self.parked_until:
            return self.place[None].copy()
        self.place = self.place + STEP / length * gap
        count = min(AHEAD, int(length / 0.05))
        return self.place + 0.05 * np.arange(count + 1)[:, None] * (gap / length)


class Hall:
    """Runs a plan, and keeps what the radio delivered."""

    def __init__(self, plan):
        self.plan = plan
        self._rng = rng = np.random.default_rng(plan.seed)
        self.robots = [
            Robot(k + 1, *rng.uniform(0.0, plan.side, (2, 2))) for k in range(plan.robots)
        ]
        self._air = np.zeros((0, BEACON_WORDS), np.uint32)
        self._hears = np.zeros((plan.robots, 0), np.bool_)
        self.heard: list[dict[int, np.ndarray]] = []  # beacons of this tick by index, per robot

    def run(self):
        for tick in range(1, self.plan.ticks):
            self._deliver(tick)
            yield tick
            self._send(tick)
            self._strike(tick)

    def is_live(self, k, tick):
        return not self.robots[k].is_dead and self.robots[k].hung_until <= tick

    def _deliver(self, tick):
        self.heard = [{} for _ in self.robots]
        for k, robot in enumerate(self.robots):
            if self.is_live(k, tick):
                rows = np.flatnonzero(self._hears[k])
                x, y = robot.place.tolist()
                robot.table.take(Reception(self._air, rows), x, y)
                robot.table.refresh(tick)
                self.heard[k] = {int(w[word_of("id")]) - 1: w for w in self._air[rows]}

    def _send(self, tick):
        senders = [k for k in range(len(self.robots)) if self.is_live(k, tick)]
        records = empty_beacons(len(senders))
        self._air = words_of(records)
        for row, k in enumerate(senders):
            robot, record = self.robots[k], records[row]
            points = robot.move(tick, self._rng, self.plan.side)
            held, wanted = points[:8], points[8:]
            record["id"], record["tick"], record["radius"] = robot.robot_id, tick, 0.285
            record["pose"][:2] = robot.place
            record["held"][: len(held)], record["held_size"] = held, len(held)
            record["wanted"][: len(wanted)], record["wanted_size"] = wanted, len(wanted)
            self._air[row, word_of("sighted_id") :] = robot.table.sighted(tick)
        places = np.array([robot.place for robot in self.robots])
        gaps = np.hypot(*(places[:, None] - places[senders]).transpose(2, 0, 1))
        self._hears = (gaps <= RANGE) & (self._rng.random(gaps.shape) >= self.plan.loss)
        self._hears[senders, np.arange(len(senders))] = False

    def _strike(self, tick):
        for k, robot in enumerate(self.robots):
            if self.is_live(k, tick):
                robot.is_dead = tick > 100 and self._rng.random() < self.plan.deaths
                if self._rng.random() < self.plan.hangs:
                    robot.hung_until = tick + int(self._rng.integers(5, 300))


def sighting(words):
    x, y = words.view(np.float32)[POSE : POSE + 2].tolist()
    return int(words[TICK]), x, y


def span(words, x, y):
    """Return the smallest and largest distance [m] of a point from what a beacon claims."""
    return nearest_and_farthest(words, words.view(np.float32), x, y)


class Gossip:
    """What each robot can know of the others at least, if it is told all within a round."""

    def __init__(self, count):
        self._round = -(-count // 2) + 2  # ticks
        self._talks: dict[tuple[int, int], int] = {}  # ticks for which each heard each
        self._past: deque[list[dict[int, Sighting]]] = deque(maxlen=self._round)
        self.known: list[dict[int, Sighting]] = [{} for _ in range(count)]

    def note(self, heard):
        self._past.append([dict(items) for items in self.known])
        for k, beacons in enumerate(heard):
            told = [(other, sighting(words)) for other, words in beacons.items()]
            for other in range(len(heard)):
                talk = self._talks.get((k, other), 0) + 1 if other in beacons else 0
                self._talks[k, other] = talk
                if talk > self._round:
                    told += self._past[0][other].items()
            for other, what in told:
                if other != k and what > self.known[k].get(other, (-1,)):
                    self.known[k][other] = what


class Believes:
    """Holds what robots believe of a silent one against what happened."""

    def __init__(self, hall):
        self._hall, count = hall, len(hall.robots)
        self._gossip = Gossip(count)
        self._last: dict[tuple[int, int], np.ndarray] = {}  # newest beacon that k heard of j
        self._has_roamed: set[tuple[int, int]] = set()  # j was heard elsewhere since, by anybody
        self._near: dict[tuple[int, int], int] = {}  # ticks for which k is near dead j's last place
        self._stale: dict[tuple[int, int], int] = {}  # ticks for which k knew better
        self._ran_over: set[int] = set()
        self.checked = 0

    def check(self, tick):
        hall, robots = self._hall, self._hall.robots
        self._gossip.note(hall.heard)
        sent = {j: words for beacons in hall.heard for j, words in beacons.items()}
        for (k, j), last in self._last.items():
            if j in sent and span(last, *sighting(sent[j])[1:])[0] > ELSEWHERE:
                self._has_roamed.add((k, j))
        for k, beacons in enumerate(hall.heard):
            for j, words in beacons.items():
                self._last[k, j] = words.copy()
                self._has_roamed.discard((k, j))
        for j, robot in enumerate(robots):
            gaps = [math.dist(robot.place, other.place) for other in robots if other is not robot]
            if robot.is_dead and min(gaps) < BODIES:
                self._ran_over.add(j)
        for k in range(len(robots)):
            if hall.is_live(k, tick):
                self._check_robot(k)

    def _check_robot(self, k):
        table, place = self._hall.robots[k].table, self._hall.robots[k].place
        silent = {int(table.ids[row]) - 1: int(row) for row in np.flatnonzero(table.gone)}
        for j, robot in enumerate(self._hall.robots):
            if (k, j) not in self._last:
                continue
            pair, last = (k, j), self._last[k, j]
            is_near = robot.is_dead and span(last, *place.tolist())[1] < CERTAINLY_NEAR
            self._near[pair] = self._near.get(pair, 0) + 1 if is_near else 0
            if robot.is_dead and j not in self._ran_over and pair not in self._has_roamed:
                is_parted = span(last, *sighting(last)[1:])[1] > PARKED
                most = PARTED_TICKS if is_parted else math.inf
                if DECIDED < self._near[pair] < most:
                    self.checked += 1
                    assert j in silent, f"{k + 1} forgot {j + 1}, which died there"
            self._stale[pair] = (
                self._stale.get(pair, 0) + 1 if self._knows_better(pair, silent) else 0
            )
            assert self._stale[pair] <= JUDGED_EVERY + 1, f"{k + 1} knows that {j + 1} left"

    def _knows_better(self, pair, silent):
        k, j = pair
        if j not in silent or j not in self._gossip.known[k]:
            return False
        words = words_of(self._hall.robots[k].table.beacons[[silent[j]]])[0]
        tick, x, y = self._gossip.known[k][j]
        return tick > words[TICK] and span(words, x, y)[0] > ELSEWHERE


HUNG = (  # and stayed obstacles there for those who knew that they had gone on
    Plan(seed=17, robots=6, side=13.0, loss=0.0, deaths=0.001, hangs=0.002),
    Plan(seed=25, robots=5, side=9.0, loss=0.0, deaths=0.001, hangs=0.002),
)
plans = st.builds(
    Plan,
    seed=st.integers(0, 2**31),
    robots=st.integers(2, 6),
    side=st.sampled_from((9.0, 13.0, 17.0)),
    loss=st.sampled_from((0.0, 0.0, 0.1)),
    deaths=st.sampled_from((0.0, 0.001)),
    hangs=st.sampled_from((0.0, 0.002)),
)


@settings(
    max_examples=4, deadline=None, derandomize=True, suppress_health_check=[HealthCheck.too_slow]
)
@given(plans)
@example(HUNG[0])
@example(HUNG[1])
def test_who_died_is_remembered_and_who_was_seen_elsewhere_is_not(plan):
    hall = Hall(plan)
    believes = Believes(hall)
    for tick in hall.run():
        believes.check(tick)
