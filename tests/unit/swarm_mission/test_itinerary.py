import pytest

from swarm_common.model.records import Pose
from swarm_mission.itinerary import (
    RETRY_TICKS,
    TRANSITIONS,
    Itinerary,
    ItineraryEvent,
    ItineraryState,
)
from swarm_mission.leg import Stop

A = Stop("a", Pose(1.0, 0.0, 0.0), 2)
B = Stop("b", Pose(2.0, 0.0, 0.0), 0)


def under_way(retries=1):
    itinerary = Itinerary([A, B], retries)
    order = itinerary.start()
    assert (order.stop, order.start_tick, order.number, order.attempt) == (A, 0, 1, 1)
    return itinerary


def test_goals_follow_after_a_pause_until_all_are_reached():
    order = under_way().on_end(True, 100)
    assert (order.stop, order.start_tick, order.number) == (B, 102, 2)
    itinerary = under_way()
    itinerary.on_end(True, 100)
    assert itinerary.on_end(True, 200) is None
    assert itinerary.state is ItineraryState.DONE
    assert [(o.stop, o.reached, o.tick) for o in itinerary.outcomes] == [
        (A, True, 100),
        (B, True, 200),
    ]


def test_a_failed_goal_is_tried_again_unless_hopeless():
    itinerary = under_way(retries=2)
    for attempt in (2, 3):
        order = itinerary.on_end(False, 50)
        assert (order.stop, order.attempt, order.start_tick) == (A, attempt, 50 + RETRY_TICKS)
        assert not itinerary.outcomes
    order = itinerary.on_end(False, 60)
    assert (order.stop, order.attempt) == (B, 1)
    assert not itinerary.outcomes[0].reached
    itinerary = under_way(retries=3)
    order = itinerary.on_end(False, 50, "error 204", is_final=True)
    assert (order.stop, order.attempt) == (B, 1)
    assert itinerary.outcomes[0].reason == "error 204"


def test_an_outcome_says_how_long_the_stop_took_and_why_it_was_missed():
    itinerary = under_way(retries=1)
    itinerary.on_end(True, 100, "of no interest")
    itinerary.on_end(False, 150, "closed")
    itinerary.on_end(False, 200, "still closed")
    first, second = itinerary.outcomes
    assert (first.start_tick, first.duration, first.reason) == (0, 10.0, "")
    assert (second.start_tick, second.reason) == (102, "still closed")
    assert second.duration == pytest.approx(9.8)


def test_what_others_do_to_goals_is_no_failure():
    itinerary = under_way(retries=0)
    itinerary.on_taken_over()
    order = itinerary.on_free_again(70)
    assert (order.stop, order.attempt, order.start_tick) == (A, 1, 70 + RETRY_TICKS)
    itinerary = under_way(retries=0)
    for tick in (50, 60):
        order = itinerary.on_forgotten(tick)
        assert (order.stop, order.attempt, order.start_tick) == (A, 1, tick)
    assert not itinerary.outcomes
    itinerary = Itinerary([], 0)
    assert itinerary.start() is None
    assert itinerary.on_lost(5) == []
    assert itinerary.state is ItineraryState.DONE


def test_the_rest_of_a_lost_robots_goals_fail():
    itinerary = under_way()
    itinerary.on_end(True, 100)
    assert [outcome.stop for outcome in itinerary.on_lost(120)] == [B]
    assert itinerary.is_over
    assert itinerary.outcomes[-1].reason == "the robot was lost"
    assert itinerary.on_lost(130) == []
    assert itinerary.on_end(True, 140) is None
    assert len(itinerary.outcomes) == 2


def test_a_robot_that_is_found_again_gets_back_what_it_lost_and_no_more():
    itinerary = under_way(retries=0)
    itinerary.on_end(False, 100, "closed")
    itinerary.on_lost(120)
    count, order = itinerary.on_found(200)
    assert (count, order.stop, order.number, order.start_tick) == (1, B, 2, 200)
    assert [outcome.reason for outcome in itinerary.outcomes] == ["closed"]
    assert not itinerary.is_over
    assert itinerary.on_end(True, 300) is None
    assert itinerary.state is ItineraryState.DONE


def test_a_mission_process_that_is_started_anew_goes_on_where_the_last_one_was():
    itinerary = Itinerary([A, B], 0, settled=1)
    assert itinerary.total == 2
    order = itinerary.start(500)
    assert (order.stop, order.number, order.start_tick) == (B, 2, 500)
    itinerary.on_end(True, 600)
    assert itinerary.outcomes[0].duration == 10.0
    assert Itinerary([A, B], 0, settled=2).start() is None


@pytest.mark.parametrize("state", ItineraryState)
@pytest.mark.parametrize("event", ItineraryEvent)
def test_every_pair_of_state_and_event_is_decided(state, event):
    calls = {
        ItineraryEvent.START: lambda i: i.start(),
        ItineraryEvent.REACHED: lambda i: i.on_end(True, 1),
        ItineraryEvent.FAILED: lambda i: i.on_end(False, 1),
        ItineraryEvent.TAKEN_OVER: lambda i: i.on_taken_over(),
        ItineraryEvent.FREE_AGAIN: lambda i: i.on_free_again(1),
        ItineraryEvent.FORGOTTEN: lambda i: i.on_forgotten(1),
        ItineraryEvent.LOST: lambda i: i.on_lost(1),
        ItineraryEvent.FOUND: lambda i: i.on_found(1),
    }
    itinerary = Itinerary([A, B], 0)
    itinerary.state = state
    if event in TRANSITIONS[state]:
        calls[event](itinerary)
        assert itinerary.state in (TRANSITIONS[state][event], ItineraryState.DONE)
    else:
        with pytest.raises(ValueError, match="cannot happen"):
            calls[event](itinerary)
        assert itinerary.state is state
