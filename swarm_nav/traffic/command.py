"""Orders of a centre: the way that a robot may take, and whether its command still counts.

A robot comes under command by an order of a new command: it stops, and says so once it stands.
Then the centre gives it points, which it never takes back.
"""

from __future__ import annotations

import math

from swarm_common.model.central import SERIAL_BITS, TeamOrder

Point = tuple[float, float]
PASSED = 0.06  # [m] before a point at which it counts as left behind; robots stop a bit short


class Command:
    """Orders as they were heard.

    Attributes:
        is_joined: Whether the robot stood after the command had begun, so that it gets points.
        passed: Number of points left behind, which is the next one's index.
        last: Index of the last point; 0 without any.
    """

    def __init__(self, silence: int | None) -> None:
        """Wait for a centre.

        Args:
            silence: Ticks without a word of it after which the robot decides alone; None: never.
        """
        self._silence = silence
        self._heard_tick = 0
        self._left = 0  # the command that lapsed last
        self._begin(0)

    def _begin(self, number: int) -> None:
        self._number = number  # of the command
        self._heard = number << SERIAL_BITS
        self.is_joined = False
        self._points: dict[int, Point] = {}
        self.passed, self.last = 1, 0

    def take(self, order: TeamOrder, tick: int) -> None:
        """Receive an order, unless a newer one came first or its command has lapsed."""
        number = order.number >> SERIAL_BITS
        if number == self._left:
            return
        self._heard_tick = tick
        if number != self._number:
            self._begin(number)
        if order.number > self._heard and self.is_joined:
            self._heard = order.number
            self._points.update(enumerate(order.points_map, order.first))
            self.last = order.first + len(order.points_map) - 1

    def counts(self, tick: int) -> bool:
        """Whether the centre decides, or is waited for; else the robot decides alone."""
        if self._silence is None or tick - self._heard_tick <= self._silence:
            return True
        if self._number:
            self._left = self._number
            self._begin(0)
        return False

    @property
    def heard(self) -> int:
        """Number of the newest order, for the centre; 0 if the robot is not under command."""
        return self._heard if self.is_joined else 0

    def join(self) -> None:
        """Record that the robot stands, if there is a command."""
        self.is_joined = self._number > 0

    def advance(self, place: Point) -> None:
        """Leave points behind that the robot has passed; never the last one.

        Args:
            place: First point (x, y) [m] in map that it holds: only what is given up is passed.
        """
        while self.passed < self.last:
            (x0, y0), (x, y) = self._points[self.passed - 1], self._points[self.passed]
            length = math.hypot(x - x0, y - y0)
            rest = (x - place[0]) * (x - x0) + (y - place[1]) * (y - y0)
            if length > 1e-6 and rest > PASSED * length:
                return
            self._points.pop(self.passed - 1)
            self.passed += 1

    def ahead(self, first: int) -> list[Point]:
        """Return the points from an index on.

        Args:
            first: Not before `passed`.
        """
        return [self._points[index] for index in range(first, self.last + 1)]
