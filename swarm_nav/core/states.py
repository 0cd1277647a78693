"""The navigator's states as a table; docs/architecture/tick.md has the diagram made from it."""

from __future__ import annotations

import enum

from swarm_common.model.errors import SwarmError


class State(enum.Enum):
    """What the robot is doing; the value is what `status` shows."""

    IDLE = "idle"
    DRIVING = "driving"
    HOLDING = "holding"
    YIELDING = "yielding"
    RECOVERING = "recovering"
    BEHAVING = "pausing"


class Event(enum.Enum):
    """What can happen to the state machine."""

    GOAL = "goal"
    BEHAVIOR = "behavior"
    FINISHED = "finished"
    STATION_TAKEN = "station taken"
    STATION_GRANTED = "station granted"
    PUSHED = "pushed"
    RELEASED = "released"
    RELEASED_IDLE = "released idle"
    NO_PROGRESS = "no progress"
    RECOVERED = "recovered"


S, E = State, Event
TRANSITIONS: dict[State, dict[Event, State]] = {
    S.IDLE: {E.GOAL: S.DRIVING, E.BEHAVIOR: S.BEHAVING, E.PUSHED: S.YIELDING, E.FINISHED: S.IDLE},
    S.DRIVING: {
        E.GOAL: S.DRIVING,
        E.BEHAVIOR: S.BEHAVING,
        E.FINISHED: S.IDLE,
        E.STATION_TAKEN: S.HOLDING,
        E.PUSHED: S.YIELDING,
        E.NO_PROGRESS: S.RECOVERING,
    },
    S.HOLDING: {
        E.GOAL: S.DRIVING,
        E.BEHAVIOR: S.BEHAVING,
        E.FINISHED: S.IDLE,
        E.STATION_GRANTED: S.DRIVING,
        E.PUSHED: S.YIELDING,
    },
    S.YIELDING: {
        E.GOAL: S.YIELDING,
        E.BEHAVIOR: S.YIELDING,
        E.FINISHED: S.YIELDING,
        E.PUSHED: S.YIELDING,
        E.RELEASED: S.DRIVING,
        E.RELEASED_IDLE: S.IDLE,
    },
    S.RECOVERING: {
        E.GOAL: S.DRIVING,
        E.BEHAVIOR: S.BEHAVING,
        E.FINISHED: S.IDLE,
        E.PUSHED: S.YIELDING,
        E.RECOVERED: S.DRIVING,
    },
    S.BEHAVING: {
        E.GOAL: S.DRIVING,
        E.BEHAVIOR: S.BEHAVING,
        E.FINISHED: S.IDLE,
        E.PUSHED: S.YIELDING,
    },
}


class IllegalTransitionError(SwarmError):
    """An event came in a state that the table does not foresee: a bug of ours."""


def next_state(state: State, event: Event) -> State:
    """Return the state after `event`.

    Raises:
        IllegalTransitionError: If the table has no such pair.
    """
    try:
        return TRANSITIONS[state][event]
    except KeyError:
        raise IllegalTransitionError(f"event '{event.value}' in state '{state.value}'") from None


def diagram() -> str:
    """Return the state machine as a Mermaid state diagram."""
    lines = ["stateDiagram-v2", "    [*] --> idle"]
    for state, row in TRANSITIONS.items():
        for target in dict.fromkeys(row.values()):
            events = ", ".join(event.value for event in row if row[event] is target)
            if target is not state:
                lines.append(f"    {state.value} --> {target.value}: {events}")
    return "\n".join(lines)
