"""The reservation protocol without robots: real tubes, claims and beacons, abstract motion.

No planner, no controller, no walls: actors ask for random straight paths through a small square,
move along what they hold or stand, change their minds, fall silent, die and begin again, while an
adversarial radio loses, delays and reorders their beacons. Thousands of ticks take a second, and
contention is far denser than in any hall.
"""

import dataclasses
import functools
import itertools
import math
from collections.abc import Iterator
from dataclasses import dataclass, field

import numpy as np

from swarm_common.model.beacon import (
    BEACON_DTYPE,
    FLAG_ACTIVE,
    FLAG_DEAF,
    NO_ROBOT,
    BeaconArray,
    reception_of,
    word_of,
    words_of,
)
from swarm_common.model.records import Pose, RobotSpec, Twist
from swarm_nav.core.config import NavConfig
from swarm_nav.interfaces import Proposal
from swarm_nav.planning.planner import SPACING
from swarm_nav.reservation.tube import padded
from swarm_nav.traffic.arbiter import Arbiter
from swarm_nav.traffic.robot_state import RobotState, initial_state
from swarm_nav.traffic.senses import Senses
from swarm_nav.traffic.single_lanes import SingleLanes
from tests.fakes.decisions import arbiter_of
from tests.fakes.navigation import room, waffle, without_lidar

SIDE = 3.2  # [m] of the square in which targets lie
MARGIN = 2.0  # [m] around it
SPEED = 0.26  # [m/s]
STEP_TICKS = 2  # ticks per path point at that speed
EAGERNESS = 0.8  # chance of moving on when it is time
COASTING = 3  # path points that a drive without commands still covers
ACQUAINTED = 20  # ticks after which everybody has heard everybody
LOST_BEFORE_DEATH = 4  # beacons in a row at most where robots die
HALL = room(SIDE + 2 * MARGIN, SIDE + 2 * MARGIN)


@functools.cache
def small() -> RobotSpec:
    footprint = tuple((0.55 * x, 0.55 * y) for x, y in waffle().footprint)
    return dataclasses.replace(waffle(), footprint=footprint)


@dataclass(frozen=True)
class Schedule:
    """One adversarial run; shares are chances per message, whims per robot and tick.

    Attributes:
        seed: Of everything random.
        count: Number of robots.
        ticks: Length of the run.
        loss: Share of the messages that are lost.
        delay: Ticks that every message is late.
        jitter: Further ticks that a message is late at most, each on its own.
        whims: Chance of each change of mind.
        deafness: Chance of losing all batches for a while.
        deaths: Chance of dying while nobody else is dead or deaf, to begin again at the same place.
        cut_links: Chance per pair that from some tick on one of the two never hears the other.
        mute: Robots that from some tick on nobody hears.
        hard_of_hearing: Robots that from some tick on hear nobody, without knowing why.
        silence: Ticks for which a pair of the living can be unheard of each other, at most.
    """

    seed: int
    count: int = 4
    ticks: int = 300
    loss: float = 0.0
    delay: int = 0
    jitter: int = 0
    whims: float = 0.02
    deafness: float = 0.0
    deaths: float = 0.0
    cut_links: float = 0.0
    mute: int = 0
    hard_of_hearing: int = 0
    silence: int = 12


@dataclass
class Outcome:
    """Smallest distance [m] between two held tubes beyond R, where, and how much was granted."""

    excess: float = math.inf
    tick: int = -1
    pair: tuple[int, int] = (0, 0)
    granted: int = 0

    def note(self, excess: float, tick: int, pair: tuple[int, int]) -> None:
        if excess < self.excess:
            self.excess, self.tick, self.pair = excess, tick, pair


class Actor:
    """One robot: its claim is real, its wishes are random, its motion is perfect."""

    def __init__(self, robot_id: int, pose: Pose, tick: int, config: NavConfig) -> None:
        self._config = config
        self._spec = waffle() if robot_id % 2 else small()
        self.robot_id = robot_id
        self.start(pose, tick)

    def start(self, pose: Pose, tick: int) -> None:
        """Begin as a new process: nothing known, nothing held but the place."""
        self.s: RobotState = initial_state(self._config, self._spec, HALL, self.robot_id, pose)
        self.s.listening_since = tick
        self.senses = Senses(self.s)
        self.s.priority = 0
        self._next_priority = 0
        self._moved_tick = tick
        self.reservation = Arbiter(self.s, SingleLanes())

    def live(self, tick: int, batch: BeaconArray | None, rng: np.random.Generator) -> np.void:
        """Pass one tick and return the beacon; `batch` is None for a deaf robot."""
        s = self.s
        s.tick = tick
        is_time = tick - self._moved_tick >= STEP_TICKS
        self.move(1 if is_time and rng.random() < EAGERNESS else 0)
        if batch is not None:
            self.senses.on_reception(reception_of(batch))
        s.neighbors.refresh(tick)
        if self.senses.update():
            self.reservation.extend()
        else:
            self.reservation.retract()
        return self._publish()

    def move(self, points: int) -> None:
        """Go on by some path points, as far as they are held."""
        tube = self.s.tube
        ahead = min(points, tube.stop - tube.near)
        tube.near += ahead
        tube.tail = tube.near  # as the stop filter moves it
        self._moved_tick = self.s.tick if ahead else self._moved_tick
        x, y = tube.points[tube.near]
        self.s.pose = Pose(float(x), float(y), 0.0)
        self.s.twist = Twist(SPEED if ahead else 0.0, 0.0, 0.0)

    def change_mind(self, whim: int, target: tuple[float, float], priority: int) -> None:
        """Do something that a navigator may do at any time."""
        tube = self.s.tube
        match whim:
            case 0:
                self.adopt(target)
            case 1:
                tube.cut()
            case 2:
                tube.reset(self.s.pose)
            case 3:
                arbiter_of(self.s).apply(Proposal(keep_ahead=self.s.brake_points))
            case 4:
                tube.withdraw()
            case 5:
                self._next_priority = priority
            case 6:
                self.s.donations.yields_for = 0 if self.s.donations.yields_for else 1 + priority

    def adopt(self, target: tuple[float, float]) -> None:
        """Take a straight path from the stop point."""
        start = np.array(self.s.stop_point)
        gap = np.array(target) - start
        count = int(math.hypot(*gap) / SPACING)
        if count >= 1:
            step = gap / math.hypot(*gap) * SPACING
            self.s.tube.adopt(start + np.arange(count + 1)[:, None] * step)

    def _publish(self) -> np.void:
        s = self.s
        beacon: np.void = np.zeros(1, BEACON_DTYPE)[0]
        beacon["id"], beacon["tick"], beacon["radius"] = s.robot_id, s.tick, s.radius
        beacon["pose"] = (s.pose.x, s.pose.y, 0.0)
        beacon["flags"] = FLAG_ACTIVE | (FLAG_DEAF if self.senses.is_deaf else 0)
        beacon["heard"] = s.neighbors.heard(s.tick)
        words_of(beacon.reshape(1))[0, word_of("sighted_id") :] = s.neighbors.sighted(s.tick)
        if s.priority != self._next_priority:
            s.tube.forget_requests()
        s.priority = self._next_priority
        beacon["priority"] = (0, s.priority)
        beacon["blocked_ticks"], beacon["blocked_by"] = s.blocked_ticks, s.blocked_by
        beacon["yields_for"] = s.donations.yields_for or NO_ROBOT
        held, wanted, intent = s.tube.publish(s.pose, s.tick)
        for name, points in (("held", held), ("wanted", wanted), ("intent", intent)):
            beacon[name], beacon[f"{name}_size"] = padded(points, len(beacon[name]))
        return beacon


@dataclass
class Air:
    """Beacons under way: each receiver loses and delays each message on its own."""

    schedule: Schedule
    rng: np.random.Generator
    _arrivals: dict[tuple[int, int], list[np.void]] = field(default_factory=dict)
    _lost: dict[tuple[int, int], int] = field(default_factory=dict)
    _cut_since: dict[tuple[int, int], int] = field(default_factory=dict)

    def __post_init__(self) -> None:
        plan = self.schedule
        robots = range(plan.count)
        for a, b in itertools.combinations(robots, 2):
            if self.rng.random() < plan.cut_links:
                self._cut((a, b) if self.rng.random() < 0.5 else (b, a))
        for index in range(plan.mute):
            since = self._someday()
            for other in robots:
                self._cut((index, other), since)
        for index in range(plan.count - plan.hard_of_hearing, plan.count):
            since = self._someday()
            for other in robots:
                self._cut((other, index), since)

    def _someday(self) -> int:
        return int(self.rng.integers(ACQUAINTED, self.schedule.ticks))

    def _cut(self, link: tuple[int, int], since: int | None = None) -> None:
        if link[::-1] not in self._cut_since:
            self._cut_since[link] = self._someday() if since is None else since

    def send(self, tick: int, sender: int, beacon: np.void) -> None:
        plan = self.schedule
        longest = LOST_BEFORE_DEATH if plan.deaths else plan.silence - plan.delay - plan.jitter
        for receiver in range(plan.count):
            link = (sender, receiver)
            is_cut = tick >= self._cut_since.get(link, tick + 1)
            is_lost = self.rng.random() < plan.loss and self._lost.get(link, 0) < longest
            self._lost[link] = self._lost.get(link, 0) + 1 if is_lost else 0
            if receiver != sender and not is_lost and not is_cut:
                late = plan.delay + int(self.rng.integers(0, plan.jitter + 1))
                self._arrivals.setdefault((tick + 1 + late, receiver), []).append(beacon)

    def batch(self, tick: int, receiver: int) -> BeaconArray:
        found = self._arrivals.pop((tick, receiver), [])
        self.rng.shuffle(found)  # the adversary chooses which of two late ones comes first
        newest = {int(beacon["id"]): beacon for beacon in found}
        return np.array([newest[key] for key in sorted(newest)], BEACON_DTYPE)


class Crowd:
    """Runs a schedule and watches the distance between all held tubes."""

    def __init__(self, schedule: Schedule, config: NavConfig | None = None) -> None:
        self._plan = schedule
        self._config = without_lidar(config)
        self._rng = np.random.default_rng(schedule.seed)
        self._air = Air(schedule, self._rng)
        self.actors = [Actor(i + 1, pose, 0, self._config) for i, pose in enumerate(self._starts())]
        self._deaf_until = [0] * schedule.count
        self._dead_until = [0] * schedule.count
        self.outcome = Outcome()

    def _starts(self) -> Iterator[Pose]:
        reach = 2.0 * (waffle().circumscribed_radius + self._config.traffic.safety_margin)
        places: list[tuple[float, float]] = []
        while len(places) < self._plan.count:
            place = self._target()
            if all(math.dist(place, other) > reach + 0.02 for other in places):
                places.append(place)
                yield Pose(*place, 0.0)

    def _target(self) -> tuple[float, float]:
        x, y = self._rng.uniform(MARGIN, MARGIN + SIDE, 2)
        return float(x), float(y)

    def run(self) -> Outcome:
        for tick in range(1, self._plan.ticks + 1):
            self._step(tick)
        return self.outcome

    def _step(self, tick: int) -> None:
        held: list[tuple[np.ndarray, float]] = []
        for index, actor in enumerate(self.actors):
            batch = self._air.batch(tick, index)
            if self._is_dead(index, actor, tick):
                here = actor.s.pose
                held.append((np.array(((here.x, here.y),), np.float32), actor.s.radius))
                continue
            self._tempt(actor)
            stop = actor.s.tube.stop
            deaf = self._is_deaf(index, tick)
            beacon = actor.live(tick, None if deaf else batch, self._rng)
            self.outcome.granted += max(0, actor.s.tube.stop - stop)
            self._air.send(tick, index, beacon)
            held.append((beacon["held"][: beacon["held_size"]], float(beacon["radius"])))
        for (i, (a, r)), (j, (b, q)) in itertools.combinations(enumerate(held), 2):
            gap = float(np.hypot(*(a[:, None] - b[None]).T).min())
            self.outcome.note(gap - r - q, tick, (i + 1, j + 1))

    def _tempt(self, actor: Actor) -> None:
        chance = 0.3 if actor.s.tube.is_complete else 0.0
        if self._rng.random() < chance:
            actor.adopt(self._target())
        if self._rng.random() < 7 * self._plan.whims:
            priority = int(self._rng.integers(0, 3))  # equal ones are common
            actor.change_mind(int(self._rng.integers(0, 7)), self._target(), priority)

    def _is_deaf(self, index: int, tick: int) -> bool:
        if self._rng.random() < self._plan.deafness and not any(self._dead_until):
            self._deaf_until[index] = tick + int(self._rng.integers(1, 40))
        return tick < self._deaf_until[index]

    def _is_dead(self, index: int, actor: Actor, tick: int) -> bool:
        if tick < self._dead_until[index]:
            return True
        if self._dead_until[index]:
            self._dead_until[index] = 0
            actor.start(actor.s.pose, tick)
        is_known = tick - actor.s.listening_since > ACQUAINTED
        all_well = is_known and not any(self._dead_until) and max(self._deaf_until) < tick
        if all_well and self._rng.random() < self._plan.deaths:
            self._dead_until[index] = tick + int(self._rng.integers(1, 150))
            actor.move(COASTING)
            return True
        return False
