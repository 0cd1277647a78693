"""Every state with every event: the table decides, and what it does not foresee raises."""

import itertools

import pytest

from swarm_nav.core.states import (
    MAKING_WAY,
    TABLES,
    TRANSITIONS,
    Event,
    IllegalTransitionError,
    MakingWay,
    Push,
    State,
    diagram,
    next_state,
)

# What must never be possible, whatever else the table says.
FORBIDDEN = {
    (State.IDLE, Event.STATION_TAKEN),
    (State.IDLE, Event.NO_PROGRESS),
    (State.HOLDING, Event.STATION_TAKEN),
    (State.HOLDING, Event.NO_PROGRESS),
    (State.YIELDING, Event.STATION_TAKEN),
    (State.YIELDING, Event.STATION_GRANTED),
    (State.YIELDING, Event.NO_PROGRESS),
    (State.DRIVING, Event.RELEASED),
    (State.DRIVING, Event.RECOVERED),
    (State.BEHAVING, Event.NO_PROGRESS),
}


@pytest.mark.parametrize(
    ("state", "event"), list(itertools.product(State, Event)), ids=lambda item: item.name
)
def test_every_state_answers_every_event_as_the_table_says(state, event):
    target = TRANSITIONS[state].get(event)
    if target is None:
        with pytest.raises(IllegalTransitionError, match=f"'{event.value}' in state"):
            next_state(state, event)
    else:
        assert next_state(state, event) is target
        assert (state, event) not in FORBIDDEN


def test_every_state_is_in_the_table_and_can_be_left_and_reached():
    assert set(TRANSITIONS) == set(State)
    for state, row in TRANSITIONS.items():
        assert any(target is not state for target in row.values())
    reached = {target for row in TRANSITIONS.values() for target in row.values()}
    assert reached == set(State)


@pytest.mark.parametrize("state", State)
def test_goals_end_and_begin_and_robots_are_pushed_in_every_state(state):
    assert next_state(state, Event.FINISHED) in (State.IDLE, State.YIELDING)
    assert next_state(state, Event.PUSHED) is State.YIELDING
    for event in (Event.GOAL, Event.BEHAVIOR):
        assert next_state(state, event) is not State.IDLE


@pytest.mark.parametrize(("state", "event"), list(itertools.product(MakingWay, Push)))
def test_making_way_answers_every_event_as_the_table_says(state, event):
    target = MAKING_WAY[state].get(event)
    if target is None:
        with pytest.raises(IllegalTransitionError, match=f"'{event.value}' in state"):
            next_state(state, event)
    else:
        assert next_state(state, event) is target


@pytest.mark.parametrize("state", MakingWay)
def test_who_makes_way_can_be_pushed_by_another_one_and_is_free_in_the_end(state):
    assert next_state(state, Push.PUSHED) is MakingWay.LEAVING
    ends = Push.OVER if state is MakingWay.RETREATING else Push.RELEASED
    assert next_state(state, ends) is MakingWay.FREE
    assert any(state in row.values() for row in MAKING_WAY.values())


@pytest.mark.parametrize("states", [State, MakingWay])
def test_a_diagram_shows_every_change_once(states):
    lines = diagram(states).splitlines()
    arrows = [line for line in lines if "-->" in line and "[*]" not in line]
    changes = [
        (*(one.value.replace(" ", "_") for one in (state, target)), event.value)
        for state, row in TABLES[states].items()
        for event, target in row.items()
        if target is not state
    ]
    pairs = {(source, target) for source, target, _ in changes}
    assert len(arrows) == len(pairs) == len(set(arrows))
    shown = [
        (*arrow.strip().split(": ")[0].split(" --> "), event)
        for arrow in arrows
        for event in arrow.split(": ")[1].split(", ")
    ]
    assert sorted(shown) == sorted(changes)
    assert lines[0] == "stateDiagram-v2"
