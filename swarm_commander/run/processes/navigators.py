"""Restarts navigators: which run, which are to be restarted, and whether the fork server obeys.

Part of `swarm-up` (`fork_server.py`); `restarts.py` says when and how often.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

from swarm_commander.run.processes.restarts import Restarts
from swarm_common.process.messages import ForkServerCommand, KillNavigator, StartNavigator

ANSWER_LIMIT = 60.0  # [s] of wall time for the fork server to carry out a command
HANGING = 30.0  # [s] of wall time that a navigator may be behind the others at the start
START_LIMIT = 60.0  # [s] of wall time for a restarted one to become active


class NavigatorSupervisor:
    """Tells the fork server to restart navigators that died or hang.

    A navigator that hangs is killed first; its death is then reported like any other.

    Attributes:
        params: Parameter file of each robot that is to have a navigator.
        down: Robots whose navigator died and will be restarted.
        given_up: Robots whose navigator stays down.
    """

    def __init__(
        self,
        restarts: Restarts,
        tell: Callable[[ForkServerCommand], None],
        clock: Callable[[], float],
    ) -> None:
        """Begin without robots.

        Args:
            clock: Wall time [s].
        """
        self.params: dict[str, str] = {}
        self.down: set[str] = set()
        self.given_up: set[str] = set()
        self._restarts = restarts
        self._tell = tell
        self._clock = clock
        self._asked: dict[str, float] = {}  # when, by robot
        self._wanted: set[str] = set()  # to restart at the user's request, once they have ended
        self._starting: dict[str, float] = {}  # when, by restarted robot
        self._active = -1
        self._active_since = 0.0

    def on_death(self, name: str, *, begins_anew: bool = False) -> float | None:
        """Record a death.

        Args:
            name: Name of the robot, like `Srobot3`.
            begins_anew: Whether it ended because it was stopped and others had forgotten it; it is
                restarted even if nobody else is.

        Returns:
            Pause [s] before the restart; None if it stays down.
        """
        self._asked.pop(name, None)
        self._starting.pop(name, None)
        if name in self._wanted or begins_anew:
            self._wanted.discard(name)
            self._restarts.on_request(name, self._clock())
            self.down.add(name)
            return 0.0
        pause = self._restarts.on_death(name, self._clock())
        (self.given_up if pause is None else self.down).add(name)
        return pause

    def on_fork(self, name: str) -> None:
        """Note that the fork server has started a navigator."""
        self._asked.pop(name, None)
        if name in self.down:
            self._starting[name] = self._clock()

    def on_active(self, name: str) -> bool:
        """Note that a navigator is active.

        Returns:
            Whether it is one that had died.
        """
        was_down = name in self.down
        self.down.discard(name)
        self._starting.pop(name, None)
        return was_down

    def on_fork_server_end(self) -> list[str]:
        """The fork server ended with all navigators; return the robots that it will start."""
        self._asked.clear()
        self._starting.clear()
        self._wanted.clear()
        names = [name for name in self.params if name not in self.given_up]
        for name in names:
            self._restarts.forget(name)
        self.down.update(names)
        return names

    def kill(self, name: str) -> None:
        """End a navigator that hangs."""
        if name in self.params and name not in self.given_up:
            self._asked[name] = self._clock()
            self._tell(KillNavigator(name))

    def restart(self, name: str) -> None:
        """Restart a navigator at the user's request, in any state."""
        if name in self.given_up:
            self.given_up.discard(name)
            self.down.add(name)
            self._restarts.on_request(name, self._clock())
        elif self._restarts.is_waiting(name):
            self._restarts.on_request(name, self._clock())
        else:
            self._wanted.add(name)
            self.kill(name)

    def remove(self, name: str) -> None:
        """Forget a robot that was taken out of the world."""
        for names in (self.down, self.given_up):
            names.discard(name)
        self.params.pop(name, None)
        for times in (self._asked, self._starting):
            times.pop(name, None)
        self._restarts.forget(name)

    def turn(self, due: Sequence[str]) -> None:
        """Start the navigators that are due.

        Args:
            due: Names of robots and of other processes, which are ignored.
        """
        for name in due:
            if name in self.down:
                self._asked[name] = self._clock()
                self._tell(StartNavigator(name, self.params[name]))

    def is_fork_server_deaf(self) -> bool:
        """True if the fork server did not carry out a command in time."""
        return any(self._clock() - asked > ANSWER_LIMIT for asked in self._asked.values())

    def overdue(self) -> list[str]:
        """Return robots whose new navigator has not become active in time, each once."""
        now = self._clock()
        names = [name for name, start in self._starting.items() if now - start > START_LIMIT]
        for name in names:
            del self._starting[name]
        return names

    def stragglers(self, active: int, missing: Sequence[str]) -> list[str]:
        """Return robots at the start whose navigators have hung for too long after the others."""
        now = self._clock()
        if active != self._active:
            self._active, self._active_since = active, now
        if not active or now - self._active_since < HANGING:
            return []
        self._active_since = now  # each gets the whole time once more
        return [name for name in missing if name not in self.down | self.given_up]
