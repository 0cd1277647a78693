"""The navigator's state machines as tables; the diagrams in docs/architecture are made of them."""

from __future__ import annotations

import enum
from collections.abc import Mapping
from typing import Any, TypeVar

from swarm_common.model.errors import SwarmError


class State(enum.Enum):
    """Activity of the robot; the value is what `status` shows."""

    IDLE = "idle"
    DRIVING = "driving"
    HOLDING = "holding"
    YIELDING = "yielding"
    RECOVERING = "recovering"
    BEHAVING = "pausing"


class Event(enum.Enum):
    """Events of the state machine."""

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


class MakingWay(enum.Enum):
    """Progress of a robot in making way for another one, or in stepping back."""

    FREE = "own way"
    LEAVING = "to a refuge"
    STUCK = "no refuge"
    AGAIN = "to another refuge"
    BARRED = "barred"
    TIGHTLY = "tightly to a refuge"  # on rough paths, since smooth ones were barred
    RETREATING = "steps back"


class Push(enum.Enum):
    """Events of a robot that makes way."""

    PUSHED = "pushed"
    CLEARS = "clears the way"
    NO_REFUGE = "finds none"
    WAITED = "waited"
    GETS_ON = "gets on"  # or stands in a refuge
    RELEASED = "released"
    REFUSED = "blocker is stuck"
    OVER = "time is over"


M, P = MakingWay, Push
_DIVERTED = {P.PUSHED: M.LEAVING, P.WAITED: M.BARRED, P.RELEASED: M.FREE}
MAKING_WAY: dict[MakingWay, dict[Push, MakingWay]] = {
    M.FREE: {P.PUSHED: M.LEAVING, P.CLEARS: M.FREE, P.RELEASED: M.FREE, P.REFUSED: M.RETREATING},
    M.LEAVING: {**_DIVERTED, P.NO_REFUGE: M.STUCK, P.GETS_ON: M.LEAVING},
    M.STUCK: {**_DIVERTED, P.NO_REFUGE: M.STUCK, P.GETS_ON: M.AGAIN},
    M.AGAIN: {**_DIVERTED, P.NO_REFUGE: M.STUCK, P.GETS_ON: M.AGAIN},
    M.BARRED: {**_DIVERTED, P.NO_REFUGE: M.BARRED, P.GETS_ON: M.TIGHTLY},
    M.TIGHTLY: {**_DIVERTED, P.NO_REFUGE: M.BARRED, P.GETS_ON: M.TIGHTLY},
    M.RETREATING: {P.PUSHED: M.LEAVING, P.CLEARS: M.FREE, P.RELEASED: M.RETREATING, P.OVER: M.FREE},
}

AnyState = TypeVar("AnyState", State, MakingWay)
TABLES: dict[type, Mapping[Any, Mapping[Any, Any]]] = {State: TRANSITIONS, MakingWay: MAKING_WAY}


class IllegalTransitionError(SwarmError):
    """An event came in a state that the table does not foresee: a bug of ours."""


def next_state(state: AnyState, event: Event | Push) -> AnyState:
    """Return the state after `event`.

    Raises:
        IllegalTransitionError: If the table has no such pair.
    """
    try:
        found: AnyState = TABLES[type(state)][state][event]
    except KeyError:
        raise IllegalTransitionError(f"event '{event.value}' in state '{state.value}'") from None
    return found


def diagram(states: type[State] | type[MakingWay] = State) -> str:
    """Return a state machine as a Mermaid state diagram."""
    lines = ["stateDiagram-v2", f"    [*] --> {_node(next(iter(states)))}"]
    for state, row in TABLES[states].items():
        for target in dict.fromkeys(row.values()):
            events = ", ".join(event.value for event in row if row[event] is target)
            if target is not state:
                lines.append(f"    {_node(state)} --> {_node(target)}: {events}")
    return "\n".join(lines)


def _node(state: enum.Enum) -> str:
    return str(state.value).replace(" ", "_")
