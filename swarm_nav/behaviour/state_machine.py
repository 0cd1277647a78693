"""The state that a robot is in, by the table of `states.py`, and what changing it brings along."""

from __future__ import annotations

from swarm_nav.core.goals import Event as Report
from swarm_nav.core.goals import StateChanged
from swarm_nav.core.states import Event, State, next_state
from swarm_nav.traffic.arbiter import Arbiter
from swarm_nav.traffic.holding import HoldingPattern
from swarm_nav.traffic.robot_state import RobotState


class StateMachine:
    """Keeps the state and what happened; the holding pattern is entered and left with the state.

    Attributes:
        state: By the table of `core/states.py`.
        is_waiting: Whether the robot waits for its turn or is served, also while it makes way.
        holding_since: Tick at which the robot began to hold last.
        events: Events since the last `pop_events`, in order.
    """

    def __init__(self, robot: RobotState, holding: HoldingPattern, arbiter: Arbiter) -> None:
        """Start idle.

        Args:
            holding: Entered and left with the state `HOLDING`.
        """
        self._s = robot
        self._holding = holding
        self._arbiter = arbiter
        self.state = State.IDLE
        self.is_waiting = False
        self.holding_since = 0
        self.events: list[Report] = []

    def switch(self, event: Event) -> None:
        """Go to the state that follows `event`.

        Raises:
            IllegalTransitionError: If the table has no such pair.
        """
        new = next_state(self.state, event)
        if event is not Event.PUSHED:
            self.is_waiting = event in (Event.STATION_TAKEN, Event.BEHAVIOR)
        if new is self.state:
            return
        if self.state is State.HOLDING:
            self._holding.leave()
            if event is not Event.PUSHED:  # that one brought a path of its own
                self._arbiter.drop_path()
        if new is State.HOLDING:
            self.holding_since = self._s.tick
            self._holding.enter(self._s)
            self._arbiter.drop_path()
        self.state = new
        self.events.append(StateChanged(new.value, self._s.tick))

    def pop_events(self) -> tuple[Report, ...]:
        """Return the events since the last call, and forget them."""
        events, self.events = tuple(self.events), []
        return events
