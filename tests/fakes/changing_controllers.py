"""Controllers that change what they want, wherever the path leads; for hunts of the stop filter."""

import collections
import dataclasses
import itertools
import math
import random
from dataclasses import dataclass

from swarm_common.model.records import FloatArray, Pose, RobotSpec, Twist
from swarm_nav.interfaces import DriveLimits, PathAhead


@dataclass(frozen=True, slots=True)
class Habit:
    """What an `Erratic` controller does, again and again."""

    back: int = 30  # ticks in which it backs
    ahead: int = 10  # ticks in which it drives ahead, after that
    back_speed: float = 1.0  # share of the largest speed
    ahead_speed: float = 1.0  # likewise
    turn: float = 0.16  # share of the largest rate
    swing: int = 0  # ticks after which the turn changes sides; 0 for never
    aside: float = 0.0  # share of the largest speed sideways, for drives that can
    pulse: int = 0  # ticks of each ten in which it wants to stand
    delay: int = 0  # ticks by which its wishes are late
    whims: float = 0.0  # chance of a new random wish, kept for up to two seconds
    follows: float = 0.0  # share of the ticks in which it heads for the path like a sane one
    nan: float = 0.0  # chance of a number that is not finite
    fault: float = 0.0  # chance of an exception


class Erratic:
    """Drives by `habit`; each robot has a random phase of its own."""

    habit = Habit()
    numbers = itertools.count()

    def __init__(self, spec: RobotSpec) -> None:
        self._rng = random.Random(next(self.numbers))
        self._tick = self._rng.randrange(self.habit.back + self.habit.ahead)
        self._late: collections.deque[Twist] = collections.deque(
            [Twist()] * self.habit.delay, maxlen=self.habit.delay + 1
        )
        self._whim, self._until = Twist(), 0
        self._follows = False

    def follow(self, path: PathAhead, pose_map: Pose, twist: Twist, limits: DriveLimits) -> Twist:
        """Return the next wish."""
        self._tick += 1
        rng, habit = self._rng, self.habit
        if rng.random() < habit.fault:
            raise RuntimeError("a fault")
        if rng.random() < habit.nan:
            return Twist(rng.choice((math.nan, math.inf, -1e308)), 0.0, math.nan)
        if self._tick % 10 == 0:
            self._follows = rng.random() < habit.follows
        wish = (
            self._sane(path.points_map, pose_map, limits) if self._follows else self._wish(limits)
        )
        self._late.append(wish)
        return self._late[0]

    def _wish(self, limits: DriveLimits) -> Twist:
        rng, habit, n = self._rng, self.habit, self._tick
        if n < self._until:
            return self._whim
        if rng.random() < habit.whims:
            self._until = n + rng.randint(1, 20)
            self._whim = Twist(
                rng.uniform(-1.0, 1.0) * limits.max_vel_x,
                rng.uniform(-1.0, 1.0) * limits.max_vel_y,
                rng.uniform(-1.0, 1.0) * limits.max_vel_theta,
            )
            return self._whim
        if n % 10 < habit.pulse:
            return Twist()
        is_back = n % (habit.back + habit.ahead) < habit.back
        speed = -habit.back_speed if is_back else habit.ahead_speed
        side = -1.0 if habit.swing and n // habit.swing % 2 else 1.0
        return Twist(
            speed * limits.max_vel_x,
            side * habit.aside * limits.max_vel_y,
            side * habit.turn * limits.max_vel_theta,
        )

    @staticmethod
    def _sane(points: FloatArray, pose: Pose, limits: DriveLimits) -> Twist:
        x, y = points[min(4, len(points) - 1)].tolist()
        off = math.remainder(math.atan2(y - pose.y, x - pose.x) - pose.yaw, math.tau)
        speed = limits.max_vel_x if abs(off) < 0.5 else 0.0
        return Twist(speed, 0.0, max(-1.0, min(1.0, 2.0 * off)) * limits.max_vel_theta)


def random_habit(rng: random.Random) -> Habit:
    """Return any habit."""
    return Habit(
        back=rng.randint(1, 60),
        ahead=rng.randint(1, 60),
        back_speed=rng.uniform(-0.2, 1.0),
        ahead_speed=rng.uniform(0.2, 1.0),
        turn=rng.uniform(-1.0, 1.0) * rng.choice((0.0, 0.2, 1.0)),
        swing=rng.choice((0, 1, 3, 7, 20)),
        aside=rng.choice((0.0, 0.5, 1.0)),
        pulse=rng.choice((0, 0, 3, 8)),
        delay=rng.randint(0, 5),
        whims=rng.choice((0.0, 0.0, 0.02, 0.2)),
        follows=rng.choice((0.0, 0.3, 0.6, 0.9)),
        nan=rng.choice((0.0, 0.0, 0.002)),
        fault=rng.choice((0.0, 0.0, 0.0005)),
    )


def near(habit: Habit, rng: random.Random) -> Habit:
    """Return a habit that differs from another one in some fields."""
    other = random_habit(rng)
    changes = {
        field.name: getattr(other, field.name)
        for field in dataclasses.fields(Habit)
        if rng.random() < 0.25
    }
    return dataclasses.replace(habit, **changes)
