"""Lockstep: the robots that have answered the current tick, and those awaited. No clock, no I/O."""

from __future__ import annotations

from collections.abc import Sequence

STALL = 5.0  # [s] of wall time between two looks; a longer gap means that this process slept
NEWCOMER_LIMIT = 30.0  # [s] of wall time for a spawned robot's navigator to start


class Barrier:
    """Decides when a tick is complete.

    At the start it waits without limit until every robot has answered once, and while it is held.
    Then a robot that does not answer within the wall limit is late: it is not waited for until it
    answers again.

    Attributes:
        is_held: Whether time may not begin yet.
    """

    def __init__(self, count: int, wall_limit: float, expects: bool = True) -> None:
        """Begin before tick 0."""
        self._wall_limit = wall_limit
        self._expected = [expects] * count
        self._answered = [False] * count
        self._is_dead = [False] * count
        self._newcomers: set[int] = set()  # that have not answered yet
        self._silent_since: dict[int, float] = {}  # wall time, of robots whose host is silent
        self._opened_at = 0.0
        self._looked_at = 0.0
        self._has_started = not expects
        self.is_held = False
        self._expects = expects
        self._last_answers = 0
        self._new_late: list[tuple[int, bool]] = []
        self.late_ticks = 0

    @property
    def has_started(self) -> bool:
        """Whether every robot has answered once."""
        return self._has_started

    @property
    def answering(self) -> int:
        """Robots that are waited for and not late; in free run, that answered the last tick."""
        return sum(self._expected) if self._expects else self._last_answers

    def open(self, now: float) -> None:
        """Begin a tick."""
        self._answered = [False] * len(self._answered)
        self._opened_at = self._looked_at = now

    def add(self) -> None:
        """Add a robot; the barrier waits for its first answer with patience."""
        self._expected.append(False)
        self._answered.append(False)
        self._is_dead.append(False)
        self.welcome(len(self._expected) - 1)

    def welcome(self, robot: int) -> None:
        """Wait for a robot whose navigator is about to start."""
        self._expected[robot] = self._expects
        self._is_dead[robot] = False
        self._newcomers.add(robot)

    def answer(self, robot: int) -> None:
        """Record a robot's whole answer to the present tick; lockstep waits for it from now on."""
        self._answered[robot] = True
        self._newcomers.discard(robot)
        self._expected[robot] = self._expects
        self._is_dead[robot] = False

    def lose(self, robot: int) -> None:
        """Wait no longer for a robot whose process is gone."""
        self._expected[robot] = False
        self._is_dead[robot] = True

    def excuse(self, robot: int) -> None:
        """Wait no longer for a robot that is driven without regard to ticks."""
        self._expected[robot] = False
        self._newcomers.add(robot)  # its ticks do not count as late

    def hear(self, robot: int) -> None:
        """Wait again for a late robot that keeps up, although its answers come too late."""
        self._expected[robot] = self._expects and not self._is_dead[robot]

    def record_silence(self, robot: int, since: float) -> None:
        """Let the limit of a robot run from a wall time on, not anew from each tick."""
        self._silent_since[robot] = since

    def end_silence(self, robot: int) -> None:
        """Let a robot have the whole limit for each tick again."""
        self._silent_since.pop(robot, None)

    def expects(self, robot: int) -> bool:
        """Whether a robot is waited for."""
        return self._expected[robot]

    def missing(self) -> Sequence[int]:
        """Return the robots that are waited for and have not answered."""
        return [
            robot
            for robot, (expected, answered) in enumerate(
                zip(self._expected, self._answered, strict=True)
            )
            if expected and not answered
        ]

    def is_complete(self, now: float) -> bool:
        """Whether the tick may be executed; robots whose limit has passed are late from now on."""
        missing = self.missing()
        self._look(now)
        if not self._has_started:
            return not (missing or self.is_held)
        is_alone = 2 * len(missing) <= sum(self._expected)
        for robot in missing:
            waited = now - min(self._opened_at, self._silent_since.get(robot, self._opened_at))
            limit = NEWCOMER_LIMIT if robot in self._newcomers else 0.0
            if waited > max(limit, self._wall_limit):
                self._expected[robot] = False
                self._new_late.append((robot, is_alone))
        return not self.missing()

    def _look(self, now: float) -> None:
        """Exclude the time in which this process slept: the robots may have slept, too."""
        gap = now - self._looked_at
        if gap > STALL:
            self._opened_at += gap
            self._silent_since = {robot: t + gap for robot, t in self._silent_since.items()}
        self._looked_at = now

    def receive_late(self) -> list[tuple[int, bool]]:
        """Return the robots that are not waited for any more since the last call.

        Returns:
            Each with whether at least half of all had answered: if not, it may be the machine.
        """
        late, self._new_late = self._new_late, []
        return late

    def close(self) -> None:
        """End a complete tick; unanswered ones of robots that are not dead count as late."""
        if self._has_started and self._expects:
            self.late_ticks += sum(
                not answered and not dead and robot not in self._newcomers
                for robot, (answered, dead) in enumerate(
                    zip(self._answered, self._is_dead, strict=True)
                )
            )
        self._has_started = True
        self._last_answers = sum(self._answered)
